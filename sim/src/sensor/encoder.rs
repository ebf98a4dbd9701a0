//! Wheel encoders: counts of a digital optical encoder on each wheel (§1.2.2, Fig. 1.6, right: quadrature,
//! so the direction is known).

use baudbot_geometry::math;

use super::Measurement;

/// A quadrature encoder on each wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct Encoders {
    /// Counts a turn of the wheel.
    pub counts_per_turn: u32,
}

impl Encoders {
    /// Counts since the start, left and right; whole numbers, negative backwards. A count is made when a
    /// mark passes, so the value is rounded down. The wire wraps it as a counter register does.
    pub(super) fn read(&self, at: &Measurement<'_>) -> [f64; 2] {
        let counts_per_m =
            f64::from(self.counts_per_turn) / (core::f64::consts::TAU * at.drive.wheel_radius_m);
        let travel = at.motion.travel_m;
        [math::floor(travel.left * counts_per_m), math::floor(travel.right * counts_per_m)]
    }
}
