//! Simulated time: an integer number of nanoseconds since the start of the run.
//!
//! Integers do not drift: after an hour of 10-ms ticks the clock is exact, and a byte's arrival can be
//! compared with the end of a tick without a tolerance. Spans of time are plain `u64` nanoseconds whose
//! names end in `_ns`.

use core::fmt;
use core::ops::Add;

use serde::{Deserialize, Serialize};

/// Nanoseconds in a second.
pub const SECOND_NS: u64 = 1_000_000_000;

/// An instant of simulated time, in nanoseconds since the start of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SimTime(u64);

impl SimTime {
    /// The start of the run.
    pub const ZERO: Self = Self(0);
    /// Later than any instant of a run.
    pub const NEVER: Self = Self(u64::MAX);

    /// The instant `ns` nanoseconds after the start.
    pub const fn from_ns(ns: u64) -> Self {
        Self(ns)
    }

    /// Nanoseconds since the start.
    pub const fn as_ns(self) -> u64 {
        self.0
    }

    /// Seconds since the start, for people and for reports; the clock itself never uses them.
    pub fn as_seconds(self) -> f64 {
        self.0 as f64 / SECOND_NS as f64
    }

    /// Nanoseconds from `earlier` to this instant, 0 if `earlier` is the later one.
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }

    /// The first multiple of `period_ns` that is not before this instant; the instant itself if that is 0.
    pub const fn up_to(self, period_ns: u64) -> Self {
        match self.0.checked_next_multiple_of(period_ns) {
            Some(ns) => Self(ns),
            None => self,
        }
    }
}

impl Add<u64> for SimTime {
    type Output = Self;

    fn add(self, ns: u64) -> Self {
        Self(self.0.saturating_add(ns))
    }
}

impl fmt::Display for SimTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s", self.as_seconds())
    }
}
