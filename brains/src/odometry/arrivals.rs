//! The age of a sensor's readings on arrival, and their intervals.

use crate::awaited::Awaited;

/// The arrival times and ages of a sensor's readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Arrivals {
    sensor: String,
    /// The instant at which the last reading came.
    heard_ns: Option<u64>,
    /// The age on arrival, as far as its protocol gives it.
    age_ns: u64,
    /// The intervals before the last, and before its predecessor.
    intervals_ns: [Option<u64>; 2],
}

impl Arrivals {
    /// A reading of the sensor of this name that was sampled at one instant has come at another.
    pub(super) fn note(&mut self, sensor: &str, sampled_ns: u64, at_ns: u64) {
        if self.sensor != sensor {
            *self = Self { sensor: sensor.to_owned(), ..Self::default() };
        }
        if let Some(before_ns) = self.heard_ns {
            self.intervals_ns = [Some(at_ns.saturating_sub(before_ns)), self.intervals_ns[0]];
        }
        self.heard_ns = Some(at_ns);
        self.age_ns = at_ns.saturating_sub(sampled_ns);
    }

    /// The time from one to the next, in nanoseconds; one that was lost does not count. 0 before that is known.
    fn interval_ns(&self) -> u64 {
        self.intervals_ns.iter().flatten().min().copied().unwrap_or_default()
    }

    /// The instant at which the last reading came, in nanoseconds; 0 if none has.
    pub(super) fn heard_ns(&self) -> u64 {
        self.heard_ns.unwrap_or_default()
    }

    /// The age of the last one when the next comes, in nanoseconds.
    pub(super) fn lag_ns(&self) -> u64 {
        self.age_ns.saturating_add(self.interval_ns())
    }

    /// The time after the last one, in nanoseconds, before which the next is not overdue.
    pub(super) fn patience_ns(&self) -> u64 {
        PATIENCE.saturating_mul(self.interval_ns())
    }

    /// The sensor as one that is waited for, and since when.
    pub(super) fn awaited(&self) -> Awaited {
        Awaited { sensor: self.sensor.clone(), since_ns: self.heard_ns() }
    }
}

/// A cable may lose a message or two.
const PATIENCE: u64 = 3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_on_the_way_makes_no_reading_older() {
        let mut arrivals = Arrivals::default();
        assert_eq!((arrivals.lag_ns(), arrivals.patience_ns()), (0, 0));
        for (sampled_ns, at_ns) in [(0, 200), (80, 280), (160, 360)] {
            arrivals.note("odometer", sampled_ns, at_ns);
        }
        assert_eq!((arrivals.lag_ns(), arrivals.patience_ns()), (280, 240));
        arrivals.note("odometer", 320, 520);
        assert_eq!((arrivals.lag_ns(), arrivals.patience_ns()), (280, 240), "one was lost");
        assert_eq!(arrivals.awaited().to_string(), "waits for `odometer` since 0.00 s");
        arrivals.note("wheels", 1_000_000_000, 1_500_000_000);
        assert_eq!(arrivals.lag_ns(), 500_000_000, "another one");
    }
}
