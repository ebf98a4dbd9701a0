//! Gyroscope: the turn rate.
//!
//! Deviation: the notes (§1.2.2) say that a gyroscope measures angular acceleration. A rate gyroscope measures
//! angular velocity.

use super::Measurement;
use super::lowpass::{LowPass, time_constant_s};

/// What a gyroscope is.
#[derive(Clone, Debug, PartialEq)]
pub struct Gyroscope {
    /// No reading is larger, in rad/s.
    pub range_rad_s: f64,
    /// How fast it follows, in hertz; `None`: at once.
    pub bandwidth_hz: Option<f64>,
}

impl Gyroscope {
    /// Turn rate in rad/s, positive to the left.
    pub(super) fn read(&self, at: &Measurement<'_>, filter: &mut LowPass) -> f64 {
        filter.follow(at.over_ground().turn, time_constant_s(self.bandwidth_hz), at.now)
    }
}
