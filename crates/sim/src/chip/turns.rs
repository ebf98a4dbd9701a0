//! Rounds of a program's main loop as they are shown: one by one, or together if they are short.

use alloc::vec::Vec;

use baudbot_board::RoundsOver;

/// Rounds of the program's main loop that follow on each other and are over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// The instant at which the first begins, in nanoseconds.
    pub from_ns: u64,
    /// The instant at which the last is over, in nanoseconds.
    pub until_ns: u64,
    /// The number of rounds.
    pub count: u32,
    /// The sum of their durations, in periods of the chip's clock source.
    pub cycles: u64,
    /// Whether they are short, so that they are summed up.
    pub are_short: bool,
}

impl Turns {
    /// The length of a round, or the mean of several, in periods of the chip's clock source.
    pub fn mean_cycles(&self) -> f64 {
        self.cycles as f64 / f64::from(self.count.max(1))
    }

    /// Takes in rounds that follow on these, if both are short. Returns whether it has done so.
    pub fn join(&mut self, next: &Self) -> bool {
        let joins = self.are_short && next.are_short && self.until_ns == next.from_ns;
        if joins {
            self.until_ns = next.until_ns;
            self.count = self.count.saturating_add(next.count);
            self.cycles = self.cycles.saturating_add(next.cycles);
        }
        joins
    }
}

/// Makes them of the begins of rounds, as these come.
#[derive(Clone, Debug)]
pub(super) struct Rounds {
    finest_ns: u64,
    /// The loop and the instant of the last begin, if it is known.
    last: Option<(u32, u64)>,
}

impl Rounds {
    /// Rounds that are shorter than this, in nanoseconds, are summed up.
    pub(super) const fn new(finest_ns: u64) -> Self {
        Self { finest_ns, last: None }
    }

    /// A round begins. Gives those before it.
    pub(super) fn take(&mut self, at_ns: u64, over: &RoundsOver, out: &mut Vec<Turns>) {
        let before = self.last.replace((over.head, at_ns));
        let Some(from_ns) = before.filter(|(head, _)| *head == over.head).map(|(_, from_ns)| from_ns) else {
            // Another loop was taken for the main one: its rounds have been reported.
            return;
        };
        let &RoundsOver { short, short_cycles, cycles, since_ns, .. } = over;
        if short > 0 {
            let (count, cycles) = (short, short_cycles.into());
            out.push(Turns { from_ns, until_ns: since_ns, count, cycles, are_short: true });
        }
        let are_short = cycles < SHORTEST || at_ns.saturating_sub(since_ns) < self.finest_ns;
        add(out, Turns { from_ns: since_ns, until_ns: at_ns, count: 1, cycles, are_short });
    }

    /// Nothing is known of the last begin.
    pub(super) fn forget(&mut self) {
        self.last = None;
    }
}

/// Adds rounds to others, to the last of them if they go on with those.
fn add(all: &mut Vec<Turns>, next: Turns) {
    if !all.last_mut().is_some_and(|last| last.join(&next)) {
        all.push(next);
    }
}

/// The length below which the beginnings of rounds are not reported, in periods of the clock source.
const SHORTEST: u64 = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    fn over(head: u32, short: (u32, u32), cycles: u64, since_ns: u64) -> RoundsOver {
        RoundsOver { head, short: short.0, short_cycles: short.1, cycles, since_ns }
    }

    fn told(finest_ns: u64, begins: &[(u64, RoundsOver)]) -> Vec<(u64, u64, u32, u64, bool)> {
        let (mut rounds, mut all) = (Rounds::new(finest_ns), Vec::new());
        for (at_ns, over) in begins {
            let mut out = Vec::new();
            rounds.take(*at_ns, over, &mut out);
            out.into_iter().for_each(|turns| add(&mut all, turns));
        }
        all.iter().map(|it| (it.from_ns, it.until_ns, it.count, it.cycles, it.are_short)).collect()
    }

    #[test]
    fn a_long_round_is_told_by_itself_and_those_that_poll_before_it_together() {
        // 16 MHz: a cycle of 62.5 ns.
        let begins = [
            (100_000, over(7, (0, 0), 12, 99_250)),
            (163_000, over(7, (83, 996), 12, 162_250)),
            (226_000, over(7, (83, 996), 12, 225_250)),
            (1_000_000, over(7, (40, 480), 11_904, 256_000)),
            (1_063_000, over(7, (83, 996), 12, 1_062_250)),
        ];
        let expected = [
            (100_000, 256_000, 84 + 84 + 40, 1008 + 1008 + 480, true),
            (256_000, 1_000_000, 1, 11_904, false),
            (1_000_000, 1_063_000, 84, 1008, true),
        ];
        assert_eq!(told(0, &begins), expected);
        assert_eq!(told(2_000_000, &begins), [(100_000, 1_063_000, 293, 15_408, true)]);
    }

    #[test]
    fn another_main_loop_begins_anew() {
        let begins = [
            (100, over(7, (0, 0), 1600, 0)),
            (200, over(7, (0, 0), 1600, 100)),
            (900, over(3, (0, 0), 9000, 50)),
            (1900, over(3, (0, 0), 16_000, 900)),
        ];
        assert_eq!(told(0, &begins), [(100, 200, 1, 1600, false), (900, 1900, 1, 16_000, false)]);
    }
}
