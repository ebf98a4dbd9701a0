//! Echoes over a USB adapter: frames, latency timer, jitter, and the way down.
//!
//! A byte that is sent at s is at the chip at s + down, or where no fixed time is known with the next frame; the wire takes it
//! to the robot, which sends it back after its turnaround, and the wire takes it to the chip at a. From there it is at the
//! laptop at B + extra frames + J, with J uniform in [0, jitter) and B the first frame's boundary at or after the chip's packet
//! was closed: at a, or with a latency timer at the timer's first expiry at or after a, a whole number of periods after the
//! packet before.
//!
//! 1. Frames of the bus keep their own time. Their rate and phase in the log's clock are where the residues of the received
//!    times agree best.
//! 2. The residues are J, and what noise the clock has: a uniform and a normal number.
//! 3. Then each echo has a whole number of frames. Timer, extra frames and way down are those that explain it in most echoes; an
//!    echo that misses a frame now and then is allowed for.
//!
//! *Deviation.* The latency timer is searched in whole frames, and its expiries are taken to be at boundaries, as in the
//! simulator. The way down is searched up to one frame: a frame more of it is the same as an extra frame.

use baudbot_sim::link::{Adapter, Uart};

use super::Case;
use crate::estimate::{Estimate, Fitted, Outcome, Reason, Residuals, found};
use crate::fields::{AdapterField, Field};
use crate::log::Quantity;
use crate::search::{EDGES, REGULAR, Search, Unknown};
use crate::statistics::Noise;

/// The echoes of a log.
pub(crate) struct Echoes {
    pub(crate) sent_s: Vec<f64>,
    pub(crate) received_s: Vec<f64>,
    /// Bytes of an echo.
    pub(crate) bytes: f64,
    /// The time on both wires, and in the robot, in seconds.
    pub(crate) wires_s: f64,
}

impl Echoes {
    pub(crate) fn of(case: &Case<'_>, uart: &Uart) -> Result<Self, Reason> {
        let (sent, received) = (case.column(Quantity::Sent)?, case.column(Quantity::Received)?);
        let pairs = sent.values.iter().zip(&received.values);
        let pairs: Vec<_> = pairs.filter(|(sent, received)| received > sent).collect();
        if pairs.len() < LEAST_ECHOES {
            let what = "echoes that came back after they were sent".into();
            return Err(Reason::TooFew { what, rows: pairs.len(), least: LEAST_ECHOES });
        }
        let note = |key: &str| case.log.note(key).ok().flatten().filter(|number| *number >= 0.0);
        let bytes = note("bytes").unwrap_or(1.0).max(1.0);
        let baud = note("baud").filter(|baud| *baud > 0.0).unwrap_or_else(|| f64::from(uart.baud));
        let bits = f64::from(uart.bits_per_character);
        let turnaround_s = note("turnaround_us").unwrap_or_default() * 1e-6;
        // The robot sends each byte back as it comes: the last is on both wires once, those before it on one at a time.
        let wires_s = (bytes + 1.0) * bits / baud + turnaround_s;
        let (sent_s, received_s) = pairs.into_iter().map(|(sent, received)| (*sent, *received)).unzip();
        Ok(Self { sent_s, received_s, bytes, wires_s })
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
        return Fitted { findings: case.none(&reason), residuals: Vec::new() };
    };
    match Echoes::of(case, uart) {
        Ok(echoes) => Frames::new(echoes, frame_s).fit(case, has_timer),
        Err(reason) => Fitted { findings: case.none(&reason), residuals: Vec::new() },
    }
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
struct Frames {
    frame_s: f64,
    wires: f64,
    sent: Vec<f64>,
    /// When the echoes were received after a boundary; these are around 0, and that may be an early edge.
    residues: Vec<f64>,
    /// The boundary.
    boundaries: Vec<f64>,
}

impl Frames {
    fn new(echoes: Echoes, frame_s: f64) -> Self {
        let origin = echoes.sent_s[0];
        let to_frames =
            |times: &[f64]| times.iter().map(|time| (time - origin) / frame_s).collect::<Vec<_>>();
        let (mut sent, mut received) = (to_frames(&echoes.sent_s), to_frames(&echoes.received_s));
        let rate = rate(&received);
        for time in sent.iter_mut().chain(&mut received) {
            *time *= 1.0 - rate;
        }
        let phase = early_edge(&received);
        for time in sent.iter_mut().chain(&mut received) {
            *time -= phase;
        }
        // A little before the edge is still after it.
        let boundaries: Vec<f64> = received.iter().map(|time| (time + EARLY).floor()).collect();
        let residues = received.iter().zip(&boundaries).map(|(time, boundary)| time - boundary).collect();
        Self { frame_s, wires: echoes.wires_s / frame_s, sent, residues, boundaries }
    }

    fn fit(&self, case: &Case<'_>, has_timer: bool) -> Fitted {
        let jitter = self.jitter();
        let fixed_down = case.wants(Field::Adapter(AdapterField::Down));
        let whole = self.whole(has_timer, fixed_down);
        let mut findings = Vec::new();
        for field in case.wanted {
            let Field::Adapter(adapter) = field else { continue };
            let outcome = match adapter {
                AdapterField::Jitter => jitter.clone(),
                AdapterField::Latency => whole.latency(self.frame_s * 1e3),
                AdapterField::ExtraFrames => whole.extra(),
                AdapterField::Down => whole.down(self.frame_s * 1e6),
                AdapterField::Spread | AdapterField::BurstProbability | AdapterField::Burst => {
                    Outcome::CannotTell(Reason::Columns { needs: "radio".into() })
                }
            };
            findings.push(case.finding(*field, outcome));
        }
        let to_us = self.frame_s * 1e6;
        let points = self
            .sent
            .iter()
            .zip(&self.residues)
            .map(|(sent, residue)| (sent * self.frame_s, residue * to_us));
        let residuals = Residuals {
            title: "received after the boundary of a frame".into(),
            x: "time in s".into(),
            unit: "µs".into(),
            points: points.collect(),
        };
        Fitted { findings, residuals: vec![residuals] }
    }

    /// The width of the residues beside their noise.
    fn jitter(&self) -> Outcome {
        let mut sorted = self.residues.clone();
        sorted.sort_by(f64::total_cmp);
        let (low, high) = (sorted[sorted.len() / 100], sorted[sorted.len() - 1 - sorted.len() / 100]);
        let span = self.sent.last().copied().unwrap_or(1.0);
        let cost = |numbers: &[f64]| {
            let [edge, width, sigma, rate] = numbers else { return f64::INFINITY };
            let noise = Noise { sigma: *sigma, half_width: 0.5 * width, step: 0.0 };
            let middle = edge + 0.5 * width;
            let each = self.residues.iter().zip(&self.sent).map(|(residue, sent)| {
                let likelihood = (-noise.cost(residue - middle - rate * (sent / span - 0.5))).exp();
                -((1.0 - STRAY) * likelihood + STRAY).ln()
            });
            each.sum()
        };
        let unknowns = vec![
            Unknown::linear(-0.5, 0.5),
            Unknown::log(1e-6, 1.0).rising(EDGES[2]),
            Unknown::log(1e-7, 0.3),
            Unknown::linear(-0.1, 0.1),
        ];
        let search = Search { unknowns, cost: &cost };
        let width = (high - low).max(2e-6);
        let starts = [(1.0, 0.01), (0.9, 0.05), (0.3, 0.3)];
        let starts = starts
            .map(|(share, noise)| vec![low + 0.5 * (1.0 - share) * width, share * width, noise * width, 0.0]);
        let mut best = search.best(&starts);
        let names =
            ["the frames' phase", "`link.adapter.jitter_us`", "noise of the clock", "the clock's rate"]
                .map(str::to_owned);
        found(&search, &mut best, (1, &names), 1e-6 / self.frame_s)
    }

    /// All explanations of the whole frames that echoes took.
    fn whole(&self, has_timer: bool, fixed_down: bool) -> Whole {
        let periods: Vec<u32> = if has_timer { self.periods() } else { vec![1] };
        let downs: Vec<f64> = match fixed_down {
            true => (0..DOWN_STEPS).map(|i| (f64::from(i) + 0.5) / f64::from(DOWN_STEPS)).collect(),
            false => vec![f64::NAN],
        };
        let mut found = Vec::new();
        for &period in &periods {
            for &down in &downs {
                for extra in 0..=MOST_EXTRA {
                    found.push(Explanation { period, extra, down, cost: self.cost(period, down, extra) });
                }
            }
        }
        Whole { found, has_timer, is_locked: self.is_locked() }
    }

    /// −log L of a timer, a way down and extra frames. The packet of the echo before closed the extra frames before its
    /// boundary, and this one's closes at the first expiry, whole periods later, at which the bytes are in the chip.
    fn cost(&self, period: u32, down: f64, extra: u32) -> f64 {
        let (period, extra) = (f64::from(period), f64::from(extra));
        let echoes = self.sent.len().min(MOST_ECHOES);
        let explained = (1..echoes).filter(|&i| {
            let sent = self.sent[i];
            let at_chip = self.wires + if down.is_nan() { (sent - EXACT).ceil() } else { sent + down };
            let before = self.boundaries[i - 1];
            let periods = ((at_chip + extra - before - EXACT) / period).ceil().max(1.0);
            (before + period * periods - self.boundaries[i]).abs() < 0.5
        });
        let (explained, total) = (explained.count() as f64, (echoes - 1) as f64);
        let share = ((total - explained + 0.5) / (total + 1.0)).min(0.999);
        -(explained * (1.0 - share).ln() + (total - explained) * (share / OTHERS).ln())
    }

    /// Periods that explain the distances between most boundaries.
    fn periods(&self) -> Vec<u32> {
        let steps: Vec<f64> = self.boundaries.windows(2).map(|pair| (pair[1] - pair[0]).round()).collect();
        let explains = |period: &u32| {
            let is_multiple = |step: &&f64| (**step / f64::from(*period)).fract() == 0.0;
            steps.iter().filter(is_multiple).count() * 10 >= steps.len() * 8
        };
        (1..=255).filter(explains).collect()
    }

    /// Whether all echoes were sent right after the boundary of a frame.
    fn is_locked(&self) -> bool {
        let mut phases: Vec<f64> =
            self.sent.iter().skip(1).map(|sent| (sent + EARLY).rem_euclid(1.0)).collect();
        phases.sort_by(f64::total_cmp);
        phases[phases.len() * 95 / 100] - phases[phases.len() * 5 / 100] < LOCKED
    }
}

/// A way to explain the frames that echoes took.
struct Explanation {
    period: u32,
    extra: u32,
    down: f64,
    cost: f64,
}

/// All of them.
struct Whole {
    found: Vec<Explanation>,
    has_timer: bool,
    is_locked: bool,
}

impl Whole {
    /// The explanations that are about as likely as the best.
    fn likely(&self) -> impl Iterator<Item = &Explanation> {
        let least = self.found.iter().map(|one| one.cost).fold(f64::INFINITY, f64::min);
        self.found.iter().filter(move |one| one.cost <= least + REGULAR)
    }

    fn best(&self) -> Option<&Explanation> {
        self.found.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    fn number(&self, of: impl Fn(&Explanation) -> f64, whole: bool) -> Option<Estimate> {
        let (low, high) =
            self.likely().map(&of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| {
                (low.min(number), high.max(number))
            });
        let value = if whole { of(self.best()?) } else { 0.5 * (low + high) };
        Some(Estimate { value, low, high, whole })
    }

    fn latency(&self, frame_ms: f64) -> Outcome {
        if !self.has_timer {
            return Outcome::CannotTell(Reason::Columns { needs: "latency timer".into() });
        }
        let Some(estimate) = self.number(|one| f64::from(one.period) * frame_ms, false) else {
            let what = "the echoes are no whole number of any timer's periods apart".into();
            return Outcome::CannotTell(Reason::Excitation { what });
        };
        let value = self.best().map_or(estimate.value, |best| f64::from(best.period) * frame_ms);
        Outcome::Estimate(Estimate { value, ..estimate })
    }

    fn extra(&self) -> Outcome {
        match self.number(|one| f64::from(one.extra), true) {
            Some(estimate) if estimate.high - estimate.low <= 1.0 => Outcome::Estimate(estimate),
            Some(estimate) => Outcome::CannotTell(Reason::Flat { low: estimate.low, high: estimate.high }),
            None => Outcome::CannotTell(Reason::Excitation {
                what: "no number of frames explains the echoes".into(),
            }),
        }
    }

    fn down(&self, frame_us: f64) -> Outcome {
        let Some(estimate) = self.number(|one| one.down, false) else {
            let what = "no number of frames explains the echoes".into();
            return Outcome::CannotTell(Reason::Excitation { what });
        };
        let step = 1.0 / f64::from(DOWN_STEPS);
        let (low, high) =
            ((estimate.low - step).max(0.0) * frame_us, (estimate.high + step).min(1.0) * frame_us);
        if estimate.high - estimate.low > WIDE {
            return Outcome::CannotTell(if self.is_locked {
                let what = "each echo was sent right after a frame's boundary, so the way down is hidden in the wait for the \
                            next; send at random times";
                Reason::Excitation { what: what.into() }
            } else {
                Reason::Flat { low, high }
            });
        }
        Outcome::Estimate(Estimate { value: estimate.value * frame_us, low, high, whole: false })
    }
}

/// How much faster than the log's clock the frames are: where the residues agree best.
fn rate(received: &[f64]) -> f64 {
    let span = received.last().copied().unwrap_or_default() - received[0];
    let step = 0.1 / span.max(1.0);
    let steps = ((MOST_RATE / step) as i64).min(MOST_RATES);
    let stride = (received.len() / 2000).max(1);
    let agreement = |rate: f64| {
        let sum = received.iter().step_by(stride).fold((0.0, 0.0), |sum, time| {
            let (sin, cos) = (std::f64::consts::TAU * time * (1.0 - rate)).sin_cos();
            (sum.0 + sin, sum.1 + cos)
        });
        sum.0.hypot(sum.1)
    };
    let none = agreement(0.0);
    let rates = (-steps..=steps).map(|i| i as f64 * step).map(|rate| (agreement(rate), rate));
    let mut best = rates.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((none, 0.0));
    for finer in [0.5, 0.25, 0.12, 0.06, 0.03, 0.015].map(|share| share * step) {
        let beside = [best.1 - finer, best.1 + finer].map(|rate| (agreement(rate), rate));
        best = beside.into_iter().fold(best, |best, one| if one.0 > best.0 { one } else { best });
    }
    // A clock that is in step explains the log as well: then it is.
    if best.0 < none * 1.0001 { 0.0 } else { best.1 }
}

/// The phase at which the residues begin: after the widest gap between them.
fn early_edge(received: &[f64]) -> f64 {
    let mut residues: Vec<f64> = received.iter().map(|time| time.rem_euclid(1.0)).collect();
    residues.sort_by(f64::total_cmp);
    let trimmed = trimmed(&residues);
    let gaps = (0..trimmed.len()).map(|i| {
        let before = if i == 0 { trimmed[trimmed.len() - 1] - 1.0 } else { trimmed[i - 1] };
        (trimmed[i] - before, trimmed[i])
    });
    gaps.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, edge)| edge)
}

/// The residues without those that have hardly any near them: strays would hide the gap.
fn trimmed(sorted: &[f64]) -> Vec<f64> {
    let bins = 200;
    let mut counts = vec![0_usize; bins];
    let bin = |residue: f64| ((residue * bins as f64) as usize).min(bins - 1);
    for residue in sorted {
        counts[bin(*residue)] += 1;
    }
    let least = counts.iter().max().copied().unwrap_or_default() / 20;
    let kept: Vec<f64> = sorted.iter().copied().filter(|residue| counts[bin(*residue)] > least).collect();
    if kept.is_empty() { sorted.to_vec() } else { kept }
}

const LEAST_ECHOES: usize = 50;

/// Echoes that are looked at one by one.
const MOST_ECHOES: usize = 2000;

/// Boundaries at which an echo that is not explained may come.
const OTHERS: f64 = 16.0;

/// Rounding errors of times, in frames.
const EXACT: f64 = 1e-6;

/// Extra frames that are searched.
const MOST_EXTRA: u32 = 8;

/// Steps of a frame in which the way down is searched.
const DOWN_STEPS: u32 = 200;

/// A share of the residues that nothing explains.
const STRAY: f64 = 0.002;

/// A way down that may be anything within this share of a frame is not told.
const WIDE: f64 = 0.5;

/// How early, in frames, an echo may seem to be.
const EARLY: f64 = 0.02;

/// Echoes sent within this share of a frame are locked to it.
const LOCKED: f64 = 0.4;

/// Clocks differ by no more than this.
const MOST_RATE: f64 = 3e-4;

const MOST_RATES: i64 = 3000;
