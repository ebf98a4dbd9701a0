//! Accelerometer: the acceleration of the body along its heading and to its left (§1.2.2, Fig. 1.10).
//!
//! The mass on a spring feels the change of speed V̇ along the heading, and to the side V φ̇, since the body
//! drives along a curve. It sits in the robot's centre; the floor is level, so there is no gravity in it.
//! Collisions, which take a robot's speed away at once, are not felt.

use super::Measurement;
use super::lowpass::{LowPass, time_constant_s};

/// What an accelerometer is.
#[derive(Clone, Debug, PartialEq)]
pub struct Accelerometer {
    /// No reading is larger, in m/s².
    pub range_m_s2: f64,
    /// How fast it follows, in hertz; `None`: at once.
    pub bandwidth_hz: Option<f64>,
}

impl Accelerometer {
    /// Forwards and to the left, in m/s².
    pub(super) fn read(&self, at: &Measurement<'_>, filters: &mut [LowPass; 2]) -> [f64; 2] {
        let motion = at.motion;
        let body = at.over_ground();
        let felt = [motion.acceleration_m_s2, body.forward * body.turn];
        let time_constant = time_constant_s(self.bandwidth_hz);
        let mut readings = [0.0; 2];
        for ((reading, filter), felt) in readings.iter_mut().zip(filters).zip(felt) {
            *reading = filter.follow(felt, time_constant, at.now);
        }
        readings
    }
}
