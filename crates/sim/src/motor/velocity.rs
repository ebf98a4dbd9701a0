//! Velocity-regulated motor: Wahde 2016, Eq. (3.15), §3.2.4.
//!
//! With (2.31) and no damping the robot's speed approaches the reference with the time constant M / (2 A
//! K), where A is that of (2.26); damping α shortens it and leaves an offset, as proportional control does.
//! Euler steps of Δt are stable for 2 A K Δt / M < 2, and do not swing for < 1.
//!
//! Deviations. The notes demand encoders to measure v with, and so do scenarios; but the regulator sees the
//! wheel's true speed, without the counting. It has no lag, as in the notes. Where a robot is known to stay behind what it is
//! commanded, a measured curve has the share of v_ref that it reaches, in place of the cause.

use alloc::vec::Vec;

use baudbot_fields::number::{Number, Positive, Share, UpTo};
use baudbot_fields::{FieldError, Path};
use serde::Deserialize;

use crate::curve::{self, LeastShare};

/// The model of a velocity-regulated motor. The defaults suit ARSim's body: without damping its time constant is 0.1 s, and its top
/// speed is about the same.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct VelocityMotor {
    /// Gain K of Eq. (3.15): torque on the wheel per m/s of speed error.
    #[serde(with = "Number::<Positive>")]
    pub gain_n_s: f64,
    /// Largest torque on the wheel.
    #[serde(with = "Number::<Positive>")]
    pub max_torque_nm: f64,
    /// Commanded speed of the wheel's rim at signal 1.
    #[serde(with = "Number::<UpTo<1000>>")]
    pub full_speed_m_s: f64,
    /// Efficiency: mechanical power divided by electrical power, for the battery.
    #[serde(with = "Number::<LeastShare>")]
    pub efficiency: f64,
    /// Fraction of the commanded speed that is reached, over the magnitude of the signal: linear between the points,
    /// constant beyond the ends. Without it the commanded speed is reached. Type: list of `[signal, share]`. Default:
    /// none. Range: at most 1000 points; signals 0 to 1, increasing; shares 0.001 to 1.
    #[cfg_attr(feature = "schema", schemars(with = "curve::Points<Share, LeastShare>", length(max = 1000)))]
    #[serde(rename = "curve_signal_share")]
    pub reached: Vec<(f64, f64)>,
}

impl Default for VelocityMotor {
    fn default() -> Self {
        Self { gain_n_s: 1.5, max_torque_nm: 1.0, full_speed_m_s: 0.8, efficiency: 0.7, reached: Vec::new() }
    }
}

impl VelocityMotor {
    /// The motor whose table stands at `path`, if its curve is one.
    ///
    /// # Errors
    /// Names the first point that is out of place.
    pub fn checked(self, path: &Path) -> Result<Self, FieldError> {
        let path = path.field("curve_signal_share");
        curve::has_points(&path, &self.reached, 0)?;
        curve::check::<Share, LeastShare>(&path, &self.reached, ["signal", "share"])?;
        Ok(self)
    }

    /// Torque on the wheel, in N m, at this signal and speed of the wheel's rim: (3.15), then the limit.
    pub fn torque_nm(&self, signal: f64, rim_speed_m_s: f64) -> f64 {
        let reference = self.reference_m_s(signal);
        (self.gain_n_s * (reference - rim_speed_m_s)).clamp(-self.max_torque_nm, self.max_torque_nm)
    }

    /// The speed of the wheel's rim that it goes for at this signal, in m/s.
    pub fn reference_m_s(&self, signal: f64) -> f64 {
        let linear = self.full_speed_m_s * signal;
        if self.reached.is_empty() { linear } else { self.sagging(linear, signal) }
    }

    #[cold]
    #[inline(never)]
    fn sagging(&self, linear_m_s: f64, signal: f64) -> f64 {
        linear_m_s * curve::value(&self.reached, signal.abs())
    }

    /// Electrical power that it takes, in W: the mechanical power over the efficiency, nothing when it
    /// brakes. A motor that is held fast takes nothing by this, which is too little: its resistance is not
    /// known.
    pub fn power_w(&self, signal: f64, rim_speed_m_s: f64, wheel_radius_m: f64) -> f64 {
        let mechanical = self.torque_nm(signal, rim_speed_m_s) * rim_speed_m_s / wheel_radius_m;
        (mechanical / self.efficiency).max(0.0)
    }

    /// The torque on the wheel that is lost for each rad/s of its speed, in N m s.
    pub(crate) fn slope_nm_s(&self, wheel_radius_m: f64) -> f64 {
        self.gain_n_s * wheel_radius_m
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use baudbot_geometry::math;

    use super::VelocityMotor;

    fn motor() -> VelocityMotor {
        VelocityMotor {
            gain_n_s: 1.5,
            max_torque_nm: 1.0,
            full_speed_m_s: 0.5,
            efficiency: 0.7,
            reached: Vec::new(),
        }
    }

    /// (3.15), and the limit of §3.2.4.
    #[test]
    fn torque_is_in_proportion_to_the_missing_speed_up_to_its_limit() {
        let motor = motor();
        assert!((motor.torque_nm(0.8, 0.1) - 1.5 * 0.3).abs() < 1e-15);
        assert_eq!(motor.torque_nm(0.8, 0.4), 0.0);
        assert_eq!(motor.torque_nm(1.0, -0.5), 1.0);
        assert_eq!(motor.torque_nm(-1.0, 0.5), -1.0);
    }

    #[test]
    fn a_motor_that_sags_goes_for_the_share_of_its_curve_both_ways() {
        let motor = VelocityMotor { reached: [(0.2, 1.0), (1.0, 0.8)].into(), ..motor() };
        let found = [0.1, 0.6, 1.0, -0.6, 0.0].map(|signal| motor.reference_m_s(signal));
        for (found, expected) in found.into_iter().zip([0.05, 0.27, 0.4, -0.27, 0.0]) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
        assert!(motor.torque_nm(1.0, 0.4).abs() < 1e-15);
    }

    #[test]
    fn the_speed_approaches_the_reference_with_the_time_constant_m_over_2ak() {
        let (motor, a, mass, dt) = (motor(), 10.0, 3.0, 1e-5);
        let (mut speed, mut steps) = (0.0, 0);
        // (2.31) without damping; both wheels' rims have the robot's speed.
        while speed < 0.5 * (1.0 - math::exp(-1.0)) {
            speed += 2.0 * a * motor.torque_nm(1.0, speed) / mass * dt;
            steps += 1;
        }
        let found = f64::from(steps) * dt;
        assert!((found - mass / (2.0 * a * motor.gain_n_s)).abs() < 1e-4, "{found}");
        assert!((found - 0.1).abs() < 1e-4, "{found}");
    }

    #[test]
    fn power_is_mechanical_power_over_efficiency() {
        let motor = motor();
        // 0.3 N m at 0.3 m/s on wheels of 0.1 m: 0.9 W.
        assert!((motor.power_w(1.0, 0.3, 0.1) - 0.9 / 0.7).abs() < 1e-12);
        assert_eq!(motor.power_w(0.0, 0.3, 0.1), 0.0);
        assert_eq!(motor.power_w(1.0, 0.0, 0.1), 0.0);
    }
}
