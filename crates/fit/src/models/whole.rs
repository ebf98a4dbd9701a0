//! The whole frames that echoes take: latency timer, extra frames, and the way down.
//!
//! Each explanation says at which boundary an echo is received. An echo is there with the probability that the cell of its sent
//! stamp leaves, and with a small probability, of the most likely size, at one of some other boundaries. What differs from the
//! best explanation in a few echoes only is not excluded: these may be held up.

use crate::estimate::{Estimate, Outcome, Reason};
use crate::search::REGULAR;

/// An echo by the time of the bus, whose zero is a boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) sent: f64,
    /// The boundary that it was received at, …
    pub(super) boundary: f64,
    /// … and that of the echo before, if that is known.
    pub(super) before: Option<f64>,
}

/// The limits of the search for explanations.
pub(super) struct Frames {
    pub(super) placed: Vec<Placed>,
    pub(super) wires: f64,
    /// The width of a stamp's cell.
    pub(super) cell: f64,
    pub(super) has_timer: bool,
    /// Whether the way down is searched; else bytes wait for the next frame downwards.
    pub(super) searches_down: bool,
    /// The allowance for boundaries: to earlier and to later times.
    pub(super) slack: [f64; 2],
    /// The number in the scenario.
    pub(super) scenario_extra: u32,
}

/// A way to explain the frames that echoes took.
#[derive(Clone, Copy, Debug)]
struct Explanation {
    period: u32,
    extra: u32,
    down: f64,
    cost: f64,
    /// The number of echoes that it explains.
    explained: f64,
}

/// All of them.
pub(super) struct Whole {
    found: Vec<Explanation>,
    best: Option<Explanation>,
    echoes: f64,
    has_timer: bool,
    is_locked: bool,
    slack: [f64; 2],
    scenario_extra: u32,
}

impl Frames {
    /// All explanations of the whole frames that echoes took.
    pub(super) fn explain(&self) -> Whole {
        let periods: Vec<u32> = if self.has_timer { self.periods() } else { vec![1] };
        let downs: Vec<f64> = match self.searches_down {
            true => (0..DOWN_STEPS).map(|i| (f64::from(i) + 0.5) / f64::from(DOWN_STEPS)).collect(),
            false => vec![f64::NAN],
        };
        let mut found = Vec::new();
        for &period in &periods {
            for &down in &downs {
                found.extend((0..=MOST_EXTRA).map(|extra| self.explanation(period, down, extra)));
            }
        }
        let best = found.iter().copied().reduce(|a, b| if b.cost < a.cost { b } else { a });
        if let Some(best) = best.filter(|_| self.searches_down) {
            self.refine(&mut found, best);
        }
        let best = found.iter().copied().reduce(|a, b| if b.cost < a.cost { b } else { a });
        let echoes = self.usable(best.map_or(1, |best| best.period));
        Whole {
            found,
            best,
            echoes,
            has_timer: self.has_timer,
            is_locked: self.is_locked(),
            slack: self.slack,
            scenario_extra: self.scenario_extra,
        }
    }

    /// Finer steps of the way down where it is likely.
    fn refine(&self, found: &mut Vec<Explanation>, best: Explanation) {
        let step = 1.0 / f64::from(DOWN_STEPS);
        let is_likely = |one: &&Explanation| {
            one.period == best.period && one.extra == best.extra && one.cost < best.cost + REGULAR
        };
        let likely = found.iter().filter(is_likely).map(|one| one.down);
        let (low, high) =
            likely.fold((best.down, best.down), |(low, high), down| (low.min(down), high.max(down)));
        for end in [low, high] {
            let finer = (-FINER..=FINER).map(|i| end + f64::from(i) / f64::from(FINER) * step);
            let finer = finer.filter(|down| (0.0..1.0).contains(down));
            found.extend(finer.map(|down| self.explanation(best.period, down, best.extra)));
        }
    }

    /// Echoes that can be compared with a timer's period.
    fn usable(&self, period: u32) -> f64 {
        self.placed.iter().filter(|echo| period == 1 || echo.before.is_some()).count() as f64
    }

    fn explanation(&self, period: u32, down: f64, extra: u32) -> Explanation {
        let echoes = self.placed.iter().filter(|echo| period == 1 || echo.before.is_some());
        let chances: Vec<f64> = echoes.map(|echo| self.chance(echo, period, down, extra)).collect();
        let total = chances.len() as f64;
        let explained: f64 = chances.iter().sum();
        let share = ((total - explained + 0.5) / (total + 1.0)).min(0.999);
        let each = chances.iter().map(|chance| -((1.0 - share) * chance + share / OTHERS).ln());
        // An echo without a boundary before it has no weight, and costs as one that is not explained well.
        let silent = (self.placed.len() as f64 - total) * OTHERS.ln();
        Explanation { period, extra, down, cost: each.sum::<f64>() + silent, explained }
    }

    /// The probability that an echo is received at its boundary. The packet of the echo before closed the extra
    /// frames before its boundary, and this one's closes at the first expiry, whole periods later, at which the bytes
    /// are in the chip.
    fn chance(&self, echo: &Placed, period: u32, down: f64, extra: u32) -> f64 {
        let (period, extra) = (f64::from(period), f64::from(extra));
        // The count may begin at any boundary if there is no timer.
        let before = echo.before.unwrap_or(echo.boundary - 1e6);
        let steps = echo.boundary - before;
        let cell = self.cell.max(EXACT);
        let reached = |x: f64, cell: f64| {
            ((steps - x) / cell + 0.5).clamp(0.0, 1.0)
                - if steps > period { ((steps - period - x) / cell + 0.5).clamp(0.0, 1.0) } else { 0.0 }
        };
        let is_whole = (steps / period).fract() == 0.0 && steps > 0.0;
        if !is_whole {
            return 0.0;
        }
        let rest = self.wires + extra - before;
        if down.is_nan() {
            // The byte waits for the next frame downwards.
            let cell = cell + self.slack[1] - self.slack[0];
            let (low, high) = (echo.sent - 0.5 * cell, echo.sent + 0.5 * cell);
            let at = low.ceil();
            let share = ((at - low) / (high - low)).clamp(0.0, 1.0);
            return share * reached(at + rest, EXACT) + (1.0 - share) * reached(at + 1.0 + rest, EXACT);
        }
        reached(echo.sent + down + rest, cell)
    }

    /// Periods that explain the distances between most boundaries.
    fn periods(&self) -> Vec<u32> {
        let steps = self.placed.iter().filter_map(|echo| Some((echo.boundary - echo.before?).round()));
        let steps: Vec<f64> = steps.collect();
        let explains = |period: &u32| {
            let is_multiple = |step: &&f64| (**step / f64::from(*period)).fract() == 0.0;
            steps.iter().filter(is_multiple).count() * 10 >= steps.len() * 8
        };
        (1..=255).filter(explains).collect()
    }

    /// Whether all echoes were sent right after the boundary of a frame.
    fn is_locked(&self) -> bool {
        let mut phases: Vec<f64> =
            self.placed.iter().skip(1).map(|echo| (echo.sent + EARLY).rem_euclid(1.0)).collect();
        phases.sort_by(f64::total_cmp);
        let at = |share: usize| phases.get(phases.len() * share / 100).copied().unwrap_or_default();
        at(95) - at(5) < LOCKED
    }
}

impl Whole {
    /// The explanations that are about as likely as the best; with other extra frames, too, those that few echoes exclude.
    fn likely(&self) -> impl Iterator<Item = &Explanation> {
        let best = self.best;
        self.found.iter().filter(move |one| {
            best.is_some_and(|best| {
                let votes = best.explained - one.explained;
                let is_other = one.extra != best.extra && one.period == best.period;
                one.cost <= best.cost + REGULAR || (is_other && votes < LEAST_VOTES)
            })
        })
    }

    /// The reason for telling nothing at all, if there is one.
    fn misfit(&self) -> Option<Reason> {
        let Some(best) = self.best else {
            let what = "the echoes are no whole number of any timer's periods apart".into();
            return Some(Reason::Excitation { what });
        };
        let share = best.explained / self.echoes.max(1.0);
        // Without a search for the way down, many of a chip's echoes take a frame less.
        let least = if best.down.is_nan() { 0.5 } else { LEAST_EXPLAINED };
        (share < least).then(|| Reason::Misfit {
            what: format!("no number of frames explains more than {:.0} % of the echoes", 100.0 * share),
        })
    }

    fn range(&self, of: impl Fn(&Explanation) -> f64) -> [f64; 2] {
        let numbers = self.likely().map(of);
        numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], number| {
            [low.min(number), high.max(number)]
        })
    }

    pub(super) fn latency(&self, frame_ms: f64) -> Outcome {
        if !self.has_timer {
            return Outcome::CannotTell(Reason::Columns { needs: "latency timer".into() });
        }
        if let Some(reason) = self.misfit() {
            return Outcome::CannotTell(reason);
        }
        let periods = self.kept_periods().unwrap_or_else(|| self.range(|one| f64::from(one.period)));
        if periods[0] < periods[1] {
            return Outcome::CannotTell(Reason::Confounded { with: "`link.adapter.extra_frames`".into() });
        }
        let value = periods[0] * frame_ms;
        Outcome::Estimate(Estimate { value, low: value, high: value, whole: false })
    }

    /// If several periods are likely, and one only with the scenario's extra frames: that one.
    pub(super) fn kept_periods(&self) -> Option<[f64; 2]> {
        let all = self.range(|one| f64::from(one.period));
        let mut kept = self.likely().filter(|one| one.extra == self.scenario_extra).map(|one| one.period);
        let first = kept.next().filter(|_| all[0] < all[1])?;
        kept.all(|period| period == first).then(|| [f64::from(first); 2])
    }

    pub(super) fn extra(&self) -> Outcome {
        if let Some(reason) = self.misfit() {
            return Outcome::CannotTell(reason);
        }
        let periods = self.range(|one| f64::from(one.period));
        if periods[0] < periods[1] {
            return Outcome::CannotTell(Reason::Confounded { with: "`link.adapter.latency_ms`".into() });
        }
        let [mut low, mut high] = self.range(|one| f64::from(one.extra));
        let downs = self.range(|one| one.down);
        if low == high && downs[0].is_finite() {
            // Boundaries a little off take the way down across the end of a frame.
            low -= f64::from(downs[0] + self.slack[0] < 0.0);
            high += f64::from(downs[1] + self.slack[1] > 1.0);
        }
        let low = low.max(0.0);
        let value = self.best.map_or(low, |best| f64::from(best.extra));
        if high - low > 1.0 {
            return Outcome::CannotTell(Reason::Flat { low, high });
        }
        Outcome::Estimate(Estimate { value, low, high, whole: true })
    }

    pub(super) fn down(&self, frame_us: f64, is_uniform: bool) -> Outcome {
        if let Some(reason) = self.misfit() {
            return Outcome::CannotTell(reason);
        }
        let [low, high] = self.range(|one| one.down);
        let value = self.best_down().unwrap_or(0.5 * (low + high));
        if high - low > WIDE {
            return Outcome::CannotTell(if self.is_locked {
                let what = "each echo was sent right after a frame's boundary, so the way down is hidden in the wait for the \
                            next; send at random times";
                Reason::Excitation { what: what.into() }
            } else {
                Reason::Flat { low: low * frame_us, high: high * frame_us }
            });
        }
        if !is_uniform {
            let with = "the jitter, whose shape does not show where the boundary is";
            return Outcome::CannotTell(Reason::Confounded { with: with.into() });
        }
        let (low, high) = ((low + self.slack[0]).max(0.0), (high + self.slack[1]).min(1.0));
        Outcome::Estimate(Estimate {
            value: value * frame_us,
            low: low * frame_us,
            high: high * frame_us,
            whole: false,
        })
    }

    /// The middle of the ways down that are as likely as the best.
    fn best_down(&self) -> Option<f64> {
        let best = self.best?;
        let is_best = |one: &&Explanation| one.cost < best.cost + 0.5 && one.extra == best.extra;
        let downs = self.found.iter().filter(is_best).map(|one| one.down);
        let (low, high) =
            downs.fold((best.down, best.down), |(low, high), down| (low.min(down), high.max(down)));
        Some(0.5 * (low + high))
    }
}

/// Boundaries at which an echo that is not explained may come.
const OTHERS: f64 = 16.0;

/// Rounding errors of times, in frames.
const EXACT: f64 = 2e-6;

/// Extra frames that are searched.
const MOST_EXTRA: u32 = 8;

/// Steps of a frame in which the way down is searched, …
const DOWN_STEPS: u32 = 200;

/// … and parts of a step in which its ends are.
const FINER: i32 = 20;

/// The number of echoes by which another number of extra frames must be excluded.
const LEAST_VOTES: f64 = 5.0;

/// The least fraction of the echoes at boundaries that an explanation must explain.
const LEAST_EXPLAINED: f64 = 0.8;

/// A way down that may be anything within this fraction of a frame is no result.
const WIDE: f64 = 0.5;

/// The lead, in frames, that an echo may seem to have.
const EARLY: f64 = 0.02;

/// Echoes sent within this share of a frame are locked to it.
const LOCKED: f64 = 0.4;
