//! Echoes over a USB adapter: frames, latency timer, jitter, and the way down.
//!
//! A byte that is sent at s is at the chip at s + down, or where no fixed time is known with the next frame; the wire takes it
//! to the robot, which sends it back after its turnaround, and the wire takes it to the chip at a. From there it is at the
//! laptop at B + extra frames + J, with J uniform in [0, jitter) and B the first frame's boundary at or after the chip's packet
//! was closed: at a, or with a latency timer at the timer's first expiry at or after a, a whole number of periods after the
//! packet before.
//!
//! 1. Frames of the bus keep their own time: [`Bus`] finds it in the log's clock.
//! 2. The residues are J, what noise the clock has, and strays ([`Residues`]).
//! 3. Then each echo has a whole number of frames, and [`Frames`] finds timer, extra frames and way down.
//!
//! Each step may find that the log does not fit, and then there is no result.
//!
//! *Deviation.* The latency timer is searched in whole frames, and its expiries are taken to be at boundaries, as in the
//! simulator. The way down is searched up to one frame: a frame more of it is the same as an extra frame.

use baudbot_sim::link::{Adapter, Uart};

use super::Case;
use super::bus::Bus;
use super::jitter::{Jitter, Residues, centred};
use super::whole::{Frames, Placed, Whole};
use crate::estimate::{Fitted, Outcome, Reason, Remark, Residuals};
use crate::fields::{AdapterField, Field};
use crate::log::Quantity;
use crate::statistics::common_step;

/// The echoes of a log.
pub(crate) struct Echoes {
    pub(crate) sent_s: Vec<f64>,
    pub(crate) received_s: Vec<f64>,
    /// Bytes of an echo.
    pub(crate) bytes: f64,
    /// The time on both wires, and in the robot, in seconds.
    pub(crate) wires_s: f64,
    /// The lines of the echoes in the log.
    lines: Vec<u64>,
    /// All stamps are multiples of this, in seconds.
    step_s: f64,
    /// The assumptions.
    pub(crate) remarks: Vec<Remark>,
}

impl Echoes {
    pub(crate) fn of(case: &Case<'_>, uart: &Uart) -> Result<Self, Reason> {
        let column = |quantity| {
            let instants = "and `received_s`: instants of one clock, as `baudbot measure echo` writes; durations alone do not show frames";
            case.column(quantity)
                .map_err(|_| Reason::Columns { needs: format!("columns `sent_s` {instants}") })
        };
        let (sent, received) = (column(Quantity::Sent)?, column(Quantity::Received)?);
        let pairs = sent.values.iter().zip(&received.values).zip(&case.log.lines);
        let pairs: Vec<_> = pairs.filter(|((sent, received), _)| received > sent).collect();
        if pairs.len() < LEAST_ECHOES {
            let what = "echoes that came back after they were sent".into();
            return Err(Reason::TooFew { what, rows: pairs.len(), least: LEAST_ECHOES });
        }
        let note = |key: &str| case.log.note(key).ok().flatten().filter(|number| *number >= 0.0);
        let bytes = note("bytes").unwrap_or(1.0).max(1.0);
        let noted = note("baud").filter(|baud| *baud > 0.0);
        let baud = noted.unwrap_or_else(|| f64::from(uart.baud));
        let remarks = if noted.is_none() { vec![Remark::Baud { baud }] } else { Vec::new() };
        let bits = f64::from(uart.bits_per_character);
        let turnaround_s = note("turnaround_us").unwrap_or_default() * 1e-6;
        // The robot sends each byte back as it comes: the last is on both wires once, those before it on one at a time.
        let wires_s = (bytes + 1.0) * bits / baud + turnaround_s;
        let lines = pairs.iter().map(|(_, line)| **line).collect();
        let (sent_s, received_s): (Vec<f64>, Vec<f64>) =
            pairs.into_iter().map(|((sent, received), _)| (*sent, *received)).unzip();
        let both: Vec<f64> =
            sent_s.iter().zip(&received_s).flat_map(|(sent, received)| [*sent, *received]).collect();
        let step_s = common_step(&both);
        Ok(Self { sent_s, received_s, bytes, wires_s, lines, step_s, remarks })
    }

    /// Times from sent to received, less those on the wires, in seconds.
    pub(crate) fn rounds_s(&self) -> impl Iterator<Item = f64> {
        self.sent_s.iter().zip(&self.received_s).map(|(sent, received)| received - sent - self.wires_s)
    }
}

/// Fits a USB adapter.
pub(crate) fn fit(case: &Case<'_>, uart: &Uart) -> Fitted {
    let Some((frame_s, has_timer)) = bus(&uart.adapter) else {
        let reason = Reason::Columns { needs: "adapter: the scenario's link has none".into() };
        return Fitted::only(case.none(&reason));
    };
    let fitted =
        Echoes::of(case, uart).and_then(|echoes| Fit::new(echoes, frame_s)?.findings(case, uart, has_timer));
    fitted.unwrap_or_else(|reason| Fitted::only(case.none(&reason)))
}

/// The length of a frame, in seconds, and whether there is a latency timer.
fn bus(adapter: &Adapter) -> Option<(f64, bool)> {
    match adapter {
        Adapter::Cdc(frames) => Some((frames.frame_ns as f64 * 1e-9, false)),
        Adapter::Ftdi(ftdi) => Some((ftdi.frames.frame_ns as f64 * 1e-9, true)),
        Adapter::None | Adapter::Bluetooth(_) => None,
    }
}

/// Echoes by the time of the bus, whose unit is a frame.
struct Fit {
    echoes: Echoes,
    frame_s: f64,
    bus: Bus,
    jitter: Jitter,
    /// The times at which echoes were sent and received, by the bus and by the log; `None` where the bus is not known.
    times: Vec<Option<Times>>,
}

/// The times of one echo, in frames.
#[derive(Clone, Copy, Debug)]
struct Times {
    log: f64,
    sent: f64,
    received: f64,
    piece: usize,
}

impl Fit {
    fn new(echoes: Echoes, frame_s: f64) -> Result<Self, Reason> {
        if echoes.step_s > COARSEST * frame_s {
            return Err(Reason::Coarse { step_us: echoes.step_s * 1e6, frame_us: frame_s * 1e6 });
        }
        let origin = echoes.sent_s[0];
        let to_frames =
            |times: &[f64]| times.iter().map(|time| (time - origin) / frame_s).collect::<Vec<_>>();
        let (sent, received) = (to_frames(&echoes.sent_s), to_frames(&echoes.received_s));
        let bus = Bus::find(&received, &echoes.lines, frame_s * 1e6)?;
        let times = (0..sent.len()).map(|echo| {
            Some(Times {
                log: received[echo],
                sent: bus.time(echo, sent[echo])?,
                received: bus.time(echo, received[echo])?,
                piece: bus.piece(echo)?,
            })
        });
        let mut times: Vec<Option<Times>> = times.collect();
        let stride = times.len().div_ceil(MOST_RESIDUES);
        let known = times.iter().flatten().step_by(stride);
        let mut points: Vec<_> = known.map(|times| (times.log, times.received.rem_euclid(1.0))).collect();
        let middle = centred(&mut points);
        // A cell as fine as this is a point, as a difference of two probabilities would be all rounding.
        let cell = echoes.step_s / frame_s;
        let cell = if cell > POINT { cell } else { 0.0 };
        let jitter = Residues { points, step: cell, frame_s }.fit()?;
        for times in times.iter_mut().flatten() {
            let log = times.log;
            for time in [&mut times.sent, &mut times.received] {
                *time = jitter.past_edge(*time - middle, log);
            }
        }
        let fit = Self { echoes, frame_s, bus, jitter, times };
        fit.follows_sends().map_or(Ok(fit), Err)
    }

    /// Whether echoes come a while after they were sent, not at boundaries: where they are sent at one phase only, as by a
    /// timer, both look alike, but a late byte then has a late echo.
    fn follows_sends(&self) -> Option<Reason> {
        let pairs = self.times.iter().flatten().filter_map(|times| {
            let boundary = self.jitter.boundary(times.received)?;
            Some((times.sent, times.received - boundary))
        });
        let pairs: Vec<(f64, f64)> = pairs.collect();
        let mut phases: Vec<(f64, f64)> = pairs.iter().map(|(sent, _)| (0.0, sent.rem_euclid(1.0))).collect();
        centred(&mut phases);
        let near: Vec<(f64, f64)> = phases
            .iter()
            .zip(&pairs)
            .map(|((_, phase), (_, residue))| (*phase, *residue))
            .filter(|(phase, _)| phase.abs() < 0.2)
            .collect();
        let n = near.len() as f64;
        if n < 0.8 * pairs.len() as f64 {
            return None;
        }
        let mean = near.iter().fold((0.0, 0.0), |sum, one| (sum.0 + one.0 / n, sum.1 + one.1 / n));
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            near.iter().map(|one| of(one.0 - mean.0, one.1 - mean.1)).sum::<f64>()
        };
        let (own, both, other) = (sum(&|s, _| s * s), sum(&|s, r| s * r), sum(&|_, r| r * r));
        let slope = both / own.max(1e-12);
        let error = (other / own.max(1e-12) / n).sqrt();
        (slope - 3.0 * error > 0.4).then(|| Reason::NoFrames {
            what: "an echo that is sent later is received later, so it waits for no boundary".into(),
        })
    }

    fn findings(self, case: &Case<'_>, uart: &Uart, has_timer: bool) -> Result<Fitted, Reason> {
        let searches_down = case.wants(Field::Adapter(AdapterField::Down));
        let whole = self.frames(uart, has_timer, searches_down).explain();
        let mut findings = Vec::new();
        for field in case.wanted {
            let Field::Adapter(adapter) = field else { continue };
            let outcome = match adapter {
                AdapterField::Jitter => self.jitter.outcome.clone(),
                AdapterField::Latency => whole.latency(self.frame_s * 1e3),
                AdapterField::ExtraFrames => whole.extra(),
                AdapterField::Down => whole.down(self.frame_s * 1e6, self.jitter.is_uniform),
                AdapterField::Spread | AdapterField::BurstProbability | AdapterField::Burst => {
                    Outcome::CannotTell(Reason::Columns { needs: "radio".into() })
                }
            };
            findings.push(case.finding(*field, outcome));
        }
        let remarks = self.remarks(&whole, uart);
        Ok(Fitted { findings, residuals: vec![self.residuals()], remarks })
    }

    /// The echoes that are at boundaries, as far as one looks.
    fn frames(&self, uart: &Uart, has_timer: bool, searches_down: bool) -> Frames {
        let at = |times: &Option<Times>| {
            times.and_then(|times| Some((times, self.jitter.boundary(times.received)?)))
        };
        let stride = self.times.len().div_ceil(MOST_ECHOES).max(1);
        let placed = (1..self.times.len()).step_by(stride).filter_map(|echo| {
            let (times, boundary) = at(&self.times[echo])?;
            let before = at(&self.times[echo - 1]).filter(|(before, _)| before.piece == times.piece);
            let before = before.map(|(_, boundary)| boundary).filter(|before| *before < boundary);
            Some(Placed { sent: times.sent, boundary, before })
        });
        let [edge, low, high] = self.jitter.edge;
        Frames {
            placed: placed.collect(),
            wires: self.echoes.wires_s / self.frame_s,
            cell: self.echoes.step_s / self.frame_s,
            has_timer,
            searches_down,
            slack: [low - edge, high - edge],
            scenario_extra: extra_frames(&uart.adapter),
        }
    }

    fn remarks(&self, whole: &Whole, uart: &Uart) -> Vec<Remark> {
        let mut remarks = self.echoes.remarks.clone();
        remarks.extend(self.bus.remarks.iter().cloned());
        if self.echoes.step_s > FINE * self.frame_s {
            remarks.push(Remark::Stamps { step_us: self.echoes.step_s * 1e6 });
        }
        let is_stray = |times: &&Times| self.jitter.boundary(times.received).is_none();
        let of = self.times.iter().flatten().count();
        let echoes = self.times.iter().flatten().filter(is_stray).count();
        if echoes * 100 > of {
            remarks.push(Remark::Strays { echoes, of });
        }
        if !self.jitter.is_uniform {
            remarks.push(Remark::Shape);
        }
        if whole.kept_periods().is_some() {
            remarks.push(Remark::Kept {
                field: "extra_frames",
                value: f64::from(extra_frames(&uart.adapter)),
                tells: "latency_ms",
            });
        }
        remarks
    }

    fn residuals(&self) -> Residuals {
        let to_us = self.frame_s * 1e6;
        let middle = 0.5 * self.jitter.width;
        let points = self.times.iter().flatten().map(|times| {
            let residue = times.received - (times.received - middle + 0.5).floor();
            (times.log * self.frame_s, residue * to_us)
        });
        Residuals {
            title: "received after the boundary of a frame".into(),
            x: "time in s".into(),
            unit: "µs".into(),
            points: points.collect(),
        }
    }
}

fn extra_frames(adapter: &Adapter) -> u32 {
    match adapter {
        Adapter::Cdc(frames) => frames.extra,
        Adapter::Ftdi(ftdi) => ftdi.frames.extra,
        Adapter::None | Adapter::Bluetooth(_) => 0,
    }
}

const LEAST_ECHOES: usize = 50;

/// Echoes that are looked at one by one.
const MOST_ECHOES: usize = 2000;

/// The most residues from which the jitter is fitted.
const MOST_RESIDUES: usize = 3000;

/// Stamps that are a coarser fraction of a frame do not show it, …
const COARSEST: f64 = 0.25;

/// … and finer ones are not worth a word.
const FINE: f64 = 1e-3;

/// A cell of less than this share of a frame is a point.
const POINT: f64 = 1e-4;
