//! A wire's edges in stretches: pulses that are too short to be shown one by one are summed up.
//!
//! Pulses whose period is shorter than a limit are a run. Within a run, some that are alike, as those of a timer are, become one
//! stretch with their period and duty; so do others, as the bits of a UART, without. A stretch lasts from one rise to another, so
//! that its duty is exact.

use alloc::vec::Vec;

use baudbot_board::Level;

/// A part of a wire's signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stretch {
    /// The wire has this level from an instant on.
    Level {
        /// In nanoseconds.
        at_ns: u64,
        /// The wire's level.
        level: Level,
    },
    /// The wire goes high and low many times.
    Pulses(Pulses),
}

/// Pulses, from the rise of the first to the rise behind the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulses {
    /// The rise of the first, in nanoseconds.
    pub from_ns: u64,
    /// The rise behind the last, in nanoseconds.
    pub until_ns: u64,
    /// The number of pulses.
    pub count: u32,
    /// The time for which the wire was high in all, in nanoseconds.
    pub high_ns: u64,
    /// Whether they are alike, in their period and in how long they are high.
    pub is_even: bool,
}

impl Stretch {
    /// The instant at which it begins, in nanoseconds.
    pub const fn at_ns(&self) -> u64 {
        match *self {
            Self::Level { at_ns, .. } => at_ns,
            Self::Pulses(Pulses { from_ns, .. }) => from_ns,
        }
    }
}

impl Pulses {
    /// The share of time in which the wire is high, from 0 to 1.
    pub fn duty(&self) -> f64 {
        self.high_ns as f64 / self.long_ns().max(1) as f64
    }

    /// Pulses per second.
    pub fn frequency_hz(&self) -> f64 {
        f64::from(self.count) * 1e9 / self.long_ns().max(1) as f64
    }

    fn long_ns(&self) -> u64 {
        self.until_ns.saturating_sub(self.from_ns)
    }

    /// Takes in pulses that follow on these and are alike. Returns whether it has done so.
    pub fn join(&mut self, next: &Self) -> bool {
        let alike = self.is_even == next.is_even && (!self.is_even || self.mean().is_like(next.mean()));
        let joins = alike && self.until_ns == next.from_ns;
        if joins {
            self.until_ns = next.until_ns;
            self.count = self.count.saturating_add(next.count);
            self.high_ns = self.high_ns.saturating_add(next.high_ns);
        }
        joins
    }

    fn mean(&self) -> Period {
        let count = u64::from(self.count.max(1));
        Period { from_ns: self.from_ns, high_ns: self.high_ns / count, long_ns: self.long_ns() / count }
    }
}

/// Adds a stretch to others, to the last of them if it goes on with that.
pub fn add(stretches: &mut Vec<Stretch>, next: Stretch) {
    if let (Some(Stretch::Pulses(last)), Stretch::Pulses(next)) = (stretches.last_mut(), &next)
        && last.join(next)
    {
        return;
    }
    stretches.push(next);
}

/// Makes stretches of the edges of a wire.
#[derive(Clone, Debug)]
pub struct Condenser {
    finest_ns: u64,
    /// Rises and falls, in turns, from a rise on, that are not reported yet.
    run: Vec<(u64, bool)>,
}

impl Condenser {
    /// Pulses with a period below this, in nanoseconds, are summed up; with 0 none are.
    pub const fn new(finest_ns: u64) -> Self {
        Self { finest_ns, run: Vec::new() }
    }

    /// The wire has another level from an instant on. Gives the stretches of the time before.
    pub fn take(&mut self, at_ns: u64, level: Level, out: &mut Vec<Stretch>) {
        let last = self.run.last().map(|(_, high)| *high);
        let goes_on = match level {
            Level::High => last != Some(true) && self.is_near(at_ns),
            Level::Low => last == Some(true),
            Level::Open | Level::Short => false,
        };
        if !goes_on {
            self.finish(out);
        }
        if goes_on || level == Level::High {
            self.run.push((at_ns, level == Level::High));
        } else {
            add(out, Stretch::Level { at_ns, level });
        }
    }

    /// Gives the stretches that are known by `now_ns`, before which no more edges come.
    pub fn settle(&mut self, now_ns: u64, out: &mut Vec<Stretch>) {
        if !self.is_near(now_ns) {
            self.finish(out);
        } else if self.run.len() > 2 * LEAST_EVEN {
            let last_rise = (self.run.len() - 1) / 2 * 2;
            let rest = self.run.split_off(last_rise);
            let mut told = core::mem::replace(&mut self.run, rest);
            told.extend(self.run.first());
            tell(&told, out);
        }
    }

    /// Gives the remaining stretches.
    pub fn finish(&mut self, out: &mut Vec<Stretch>) {
        tell(&self.run, out);
        // The rest behind the last rise is no whole period.
        let whole = self.run.len().saturating_sub(1) / 2 * 2;
        for &(at_ns, high) in self.run.iter().skip(whole) {
            add(out, Stretch::Level { at_ns, level: level(high) });
        }
        self.run.clear();
    }

    /// Whether the run goes on at an instant.
    fn is_near(&self, at_ns: u64) -> bool {
        let rise = self.run.iter().rev().find(|(_, high)| *high);
        rise.is_some_and(|(rise_ns, _)| at_ns.saturating_sub(*rise_ns) < self.finest_ns)
    }
}

/// The time from one rise to the next.
#[derive(Clone, Copy, Debug)]
struct Period {
    from_ns: u64,
    high_ns: u64,
    long_ns: u64,
}

impl Period {
    fn is_like(self, other: Self) -> bool {
        let far = self.long_ns / UNLIKE + 1;
        self.long_ns.abs_diff(other.long_ns) <= far && self.high_ns.abs_diff(other.high_ns) <= far
    }
}

/// Gives the whole periods of a run.
fn tell(run: &[(u64, bool)], out: &mut Vec<Stretch>) {
    let period = |edges: &[(u64, bool)]| {
        let [rise, fall, next] = [edges[0].0, edges[1].0, edges[2].0];
        Period { from_ns: rise, high_ns: fall - rise, long_ns: next - rise }
    };
    let periods: Vec<Period> = run.windows(3).step_by(2).map(period).collect();
    let mut uneven: Vec<Period> = Vec::new();
    let mut rest = &periods[..];
    while let Some(first) = rest.first() {
        let alike = rest.iter().take_while(|period| period.is_like(*first)).count();
        let (streak, others) = rest.split_at(alike);
        rest = others;
        if alike < LEAST_EVEN {
            uneven.extend(streak);
            continue;
        }
        tell_uneven(&uneven, out);
        uneven.clear();
        together(streak, true).into_iter().for_each(|pulses| add(out, pulses));
    }
    tell_uneven(&uneven, out);
}

fn tell_uneven(periods: &[Period], out: &mut Vec<Stretch>) {
    if periods.len() >= LEAST_UNEVEN {
        return together(periods, false).into_iter().for_each(|pulses| add(out, pulses));
    }
    for &Period { from_ns, high_ns, .. } in periods {
        add(out, Stretch::Level { at_ns: from_ns, level: Level::High });
        add(out, Stretch::Level { at_ns: from_ns + high_ns, level: Level::Low });
    }
}

fn together(periods: &[Period], is_even: bool) -> Option<Stretch> {
    let (first, last) = (periods.first()?, periods.last()?);
    Some(Stretch::Pulses(Pulses {
        from_ns: first.from_ns,
        until_ns: last.from_ns + last.long_ns,
        count: periods.len() as u32,
        high_ns: periods.iter().map(|period| period.high_ns).sum(),
        is_even,
    }))
}

const fn level(high: bool) -> Level {
    if high { Level::High } else { Level::Low }
}

/// The number of equal pulses from which on they are summed up.
const LEAST_EVEN: usize = 4;

/// The number of unequal pulses from which on they are summed up.
const LEAST_UNEVEN: usize = 3;

/// Pulses are alike if they differ by less than this part of a period.
const UNLIKE: u64 = 50;

#[cfg(test)]
mod tests {
    use super::*;

    fn condensed(edges: &[(u64, Level)], finest_ns: u64) -> Vec<Stretch> {
        let (mut condenser, mut out) = (Condenser::new(finest_ns), Vec::new());
        edges.iter().for_each(|&(at_ns, level)| condenser.take(at_ns, level, &mut out));
        condenser.finish(&mut out);
        out
    }

    fn wave(from_ns: u64, high_ns: u64, long_ns: u64, count: u64) -> Vec<(u64, Level)> {
        let pulse = |i| [(from_ns + i * long_ns, Level::High), (from_ns + i * long_ns + high_ns, Level::Low)];
        (0..count).flat_map(pulse).collect()
    }

    fn at(at_ns: u64, level: Level) -> Stretch {
        Stretch::Level { at_ns, level }
    }

    #[test]
    fn slow_pulses_are_told_edge_by_edge() {
        let edges = wave(100, 10, 1000, 5);
        let all: Vec<_> = edges.iter().map(|&(at_ns, level)| at(at_ns, level)).collect();
        assert_eq!(condensed(&edges, 1000), all);
        assert_eq!(condensed(&edges, 0), all);
    }

    #[test]
    fn fast_pulses_are_a_stretch_whose_duty_and_frequency_are_exact() {
        let edges = wave(5000, 250, 1000, 400);
        let told = condensed(&edges, 2000);
        let pulses =
            Pulses { from_ns: 5000, until_ns: 404_000, count: 399, high_ns: 399 * 250, is_even: true };
        assert_eq!(
            told,
            [Stretch::Pulses(pulses), at(404_000, Level::High), at(404_250, Level::Low)],
            "the last period is not over"
        );
        assert_eq!((pulses.duty(), pulses.frequency_hz()), (0.25, 1e6));
    }

    #[test]
    fn another_duty_is_another_stretch_and_what_is_not_alike_has_none() {
        let mut edges = wave(0, 250, 1000, 20);
        edges.extend(wave(20_000, 600, 1000, 20));
        // Bits of a character.
        edges.extend((0..6).flat_map(|i| wave(40_000 + i * 700, 100 + 50 * i, 700, 1)));
        let told = condensed(&edges, 2000);
        let summary: Vec<_> = told
            .iter()
            .filter_map(|stretch| match stretch {
                Stretch::Pulses(pulses) => Some((pulses.from_ns, pulses.until_ns, pulses.is_even)),
                Stretch::Level { .. } => None,
            })
            .collect();
        assert_eq!(summary, [(0, 20_000, true), (20_000, 40_000, true), (40_000, 43_500, false)]);
    }

    #[test]
    fn pulses_that_go_on_are_told_bit_by_bit_and_joined() {
        let (mut condenser, mut out) = (Condenser::new(2000), Vec::new());
        for (i, (at_ns, level)) in wave(0, 250, 1000, 400).into_iter().enumerate() {
            condenser.take(at_ns, level, &mut out);
            if i % 30 == 0 {
                condenser.settle(at_ns, &mut out);
            }
        }
        assert!(
            matches!(out[..], [Stretch::Pulses(Pulses { from_ns: 0, until_ns, .. })] if until_ns > 380_000),
            "{out:?}"
        );
        condenser.settle(401_500, &mut out);
        assert_eq!(out.last(), Some(&at(399_250, Level::Low)), "they are over");
        assert_eq!(out.len(), 3, "{out:?}");
    }

    #[test]
    fn an_open_wire_ends_a_run_and_no_order_of_levels_is_a_problem() {
        let mut edges = wave(0, 250, 1000, 8);
        edges.extend([(8000, Level::Open), (8100, Level::Short), (8200, Level::Low), (8300, Level::Low)]);
        let told = condensed(&edges, 2000);
        assert!(matches!(told[0], Stretch::Pulses(Pulses { until_ns: 7000, .. })), "{told:?}");
        assert_eq!(
            told[3..],
            [at(8000, Level::Open), at(8100, Level::Short), at(8200, Level::Low), at(8300, Level::Low)]
        );
        let twice = [(0, Level::High), (5, Level::High), (9, Level::Low), (9, Level::Low)];
        assert_eq!(condensed(&twice, 2000).len(), 4);
    }
}
