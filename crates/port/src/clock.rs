//! Simulated time on the wall clock, by the server's value of each Turn.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The relation of simulated time to the wall clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    /// Simulated time, in nanoseconds, and the instant that it is, in nanoseconds since 1970.
    pub(crate) sim_ns: u64,
    pub(crate) unix_ns: u64,
    /// Simulated seconds a second.
    pub(crate) factor: f64,
}

impl Clock {
    /// The instant at which it is this time, in nanoseconds since 1970.
    pub(crate) fn unix_ns(&self, sim_ns: u64) -> u64 {
        let ahead = sim_ns as i128 - i128::from(self.sim_ns);
        // Never before its instant: rounded up.
        let wall = (ahead as f64 / self.factor).ceil() as i64;
        self.unix_ns.saturating_add_signed(wall)
    }

    /// The simulated time at an instant.
    pub(crate) fn sim_ns(&self, unix_ns: u64) -> u64 {
        let ahead = i128::from(unix_ns) - i128::from(self.unix_ns);
        self.sim_ns.saturating_add_signed((ahead as f64 * self.factor) as i64)
    }
}

/// The lead of this machine's clock over the server's: the least that Turns seem to be late. A small lead is ignored,
/// since a Turn takes as long.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ahead {
    /// The least of the last stretch of Turns, and of this one, in nanoseconds.
    least_ns: [Option<i64>; 2],
    turns: u32,
}

/// Turns of a stretch.
const STRETCH: u32 = 1000;

/// Turns may take so long; what is more is a difference of the clocks.
const NEARLY_NS: i64 = 20_000_000;

impl Ahead {
    /// A Turn has come so late. Gives how far the clock is ahead.
    pub(crate) fn note(&mut self, late_ns: i64) -> i64 {
        if self.turns == STRETCH {
            self.least_ns = [self.least_ns[1], None];
            self.turns = 0;
        }
        self.turns += 1;
        let least = self.least_ns[1].map_or(late_ns, |least| least.min(late_ns));
        self.least_ns[1] = Some(least);
        let least = self.least_ns[0].map_or(least, |last| last.min(least));
        if (0..NEARLY_NS).contains(&least) { 0 } else { least }
    }
}

/// Now, in nanoseconds since 1970.
pub(crate) fn now_unix_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or(Duration::ZERO).as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_another_is_found_and_one_that_is_the_same_is_left() {
        let mut same = Ahead::default();
        assert!((0..5000).all(|i| same.note(100_000 + 1000 * (i % 7)) == 0));
        let mut behind = Ahead::default();
        assert_eq!(
            [-2_999_000_000, -3_000_000_000, -2_000_000_000].map(|late| behind.note(late))[2],
            -3_000_000_000
        );
        let mut stepped = Ahead::default();
        (0..10).for_each(|_| assert_eq!(stepped.note(0), 0));
        let last = (0..2000).map(|_| stepped.note(5_000_000_000)).last();
        assert_eq!(last, Some(5_000_000_000), "a clock that was set is found again");
    }

    #[test]
    fn times_go_there_and_back() {
        let clock = Clock { sim_ns: 5_000, unix_ns: 1_700_000_000_000_000_000, factor: 2.0 };
        assert_eq!(clock.unix_ns(7_000), 1_700_000_000_000_001_000);
        assert_eq!(clock.unix_ns(1_000), 1_699_999_999_999_998_000);
        assert_eq!(clock.unix_ns(5_001), 1_700_000_000_000_000_001, "not before its instant");
        assert_eq!(clock.sim_ns(1_700_000_000_000_001_000), 7_000);
        assert_eq!(clock.sim_ns(0), 0);
    }
}
