//! The reasons for which a brain waits, as text for observers.

use std::fmt;

/// A sensor for whose reading a brain waits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Awaited {
    /// The sensor's name.
    pub sensor: String,
    /// The instant at which the sensor's last reading came, in nanoseconds; 0 if none has.
    pub since_ns: u64,
}

impl fmt::Display for Awaited {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "waits for `{}` since {:.2} s", self.sensor, self.since_ns as f64 * 1e-9)
    }
}
