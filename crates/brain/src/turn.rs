//! The inputs of a brain's step.

use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::body::Body;

/// A brain's step: what has arrived for it, and when it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    /// Number of the tick.
    pub tick: u64,
    /// The instant of the step, by the laptop's clock, in nanoseconds of simulated time since the start.
    pub at_ns: u64,
    /// The last reading of each sensor, in the order of [`Body::sensors`]; `None` until one has arrived.
    pub readings: Vec<Option<Reading>>,
    /// The robot's body.
    pub body: Arc<Body>,
    /// A complete, valid message of the microcontroller has come since the last turn. It may have no new reading: who asks
    /// more often than sensors sample gets such answers.
    pub has_message: bool,
}

/// A reading as it came over the wire.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// One a component, in SI units, as the wire's quantisation left them.
    pub values: Vec<f64>,
    /// The instant at which it was sampled, by the microcontroller's clock, in nanoseconds; `None` if the protocol does
    /// not give it.
    pub sampled_at_ns: Option<u64>,
    /// Sequence number of the message that brought it; wraps.
    pub sequence: u32,
    /// New since the last turn; an old value is repeated with `false`.
    pub readable: bool,
}

impl Turn {
    /// The last reading of the sensor of this name; `None` if there is no such sensor, or nothing came yet.
    pub fn reading(&self, sensor: &str) -> Option<&Reading> {
        self.readings.get(self.body.sensor_index(sensor)?)?.as_ref()
    }

    /// The first value of the last reading of the sensor of this name, in SI units.
    pub fn value(&self, sensor: &str) -> Option<f64> {
        self.reading(sensor)?.values.first().copied()
    }

    /// Whether any sensor has a new reading.
    pub fn has_news(&self) -> bool {
        self.readings.iter().flatten().any(|reading| reading.readable)
    }

    /// Whether a message of the microcontroller has come since the last turn, with new readings or without.
    pub fn is_answered(&self) -> bool {
        let mut readings = self.body.sensors.iter().zip(&self.readings);
        let is_new = |reading: &Option<Reading>| reading.as_ref().is_some_and(|reading| reading.readable);
        self.has_message || readings.any(|(sensor, reading)| sensor.is_on_wire() && is_new(reading))
    }
}

impl Reading {
    /// The age of the sample at an instant of the laptop's clock, in nanoseconds; `None` if the protocol does not give
    /// it. The simulated clocks of laptop and microcontroller agree.
    pub fn age_ns(&self, at_ns: u64) -> Option<u64> {
        Some(at_ns.saturating_sub(self.sampled_at_ns?))
    }
}
