//! Simulated time on the wall clock, as the server tells it with each Turn.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Which instant of the wall clock an instant of simulated time is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    /// Simulated time, in nanoseconds, and the instant that it is, in nanoseconds since 1970.
    pub(crate) sim_ns: u64,
    pub(crate) unix_ns: u64,
    /// Simulated seconds a second.
    pub(crate) factor: f64,
}

impl Clock {
    /// When it is this time, in nanoseconds since 1970.
    pub(crate) fn unix_ns(&self, sim_ns: u64) -> u64 {
        let ahead = sim_ns as i128 - i128::from(self.sim_ns);
        // Never before its instant: rounded up.
        let wall = (ahead as f64 / self.factor).ceil() as i64;
        self.unix_ns.saturating_add_signed(wall)
    }

    /// What time it is.
    pub(crate) fn sim_ns(&self, unix_ns: u64) -> u64 {
        let ahead = i128::from(unix_ns) - i128::from(self.unix_ns);
        self.sim_ns.saturating_add_signed((ahead as f64 * self.factor) as i64)
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
    fn times_go_there_and_back() {
        let clock = Clock { sim_ns: 5_000, unix_ns: 1_700_000_000_000_000_000, factor: 2.0 };
        assert_eq!(clock.unix_ns(7_000), 1_700_000_000_000_001_000);
        assert_eq!(clock.unix_ns(1_000), 1_699_999_999_999_998_000);
        assert_eq!(clock.unix_ns(5_001), 1_700_000_000_000_000_001, "not before its instant");
        assert_eq!(clock.sim_ns(1_700_000_000_000_001_000), 7_000);
        assert_eq!(clock.sim_ns(0), 0);
    }
}
