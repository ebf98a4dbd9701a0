//! The fields of the motors' table.

use alloc::vec::Vec;

use baudbot_sim::motor::Servo;

/// The fields that every kind of motor has.
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawMotors {
    pub(super) kind: MotorKind,
    pub(super) signal_bits: Option<u64>,
    pub(super) noise_sigma: f64,
    pub(super) noise_spread: f64,
    pub(super) timeout_ms: Option<f64>,
    pub(super) dead_time_ms: f64,
}

pub(super) const COMMON_FIELDS: [&str; 6] =
    ["kind", "signal_bits", "noise_sigma", "noise_spread", "timeout_ms", "dead_time_ms"];

#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum MotorKind {
    #[default]
    Dc,
    Velocity,
    Servo,
    Stepper,
}

/// The defaults are ARSim's motor, made for a robot of a few kg.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawDcMotor {
    pub(super) voltage_v: f64,
    pub(super) torque_constant_nm_a: f64,
    pub(super) emf_constant_v_s: f64,
    pub(super) resistance_ohm: f64,
    pub(super) coulomb_friction_nm: f64,
    pub(super) viscous_friction_nm_s: f64,
    pub(super) gear_ratio: f64,
    pub(super) gear_efficiency: f64,
    pub(super) max_torque_nm: f64,
    pub(super) unlimited_signals: bool,
    pub(super) track_factor: f64,
}

impl Default for RawDcMotor {
    fn default() -> Self {
        Self {
            voltage_v: 12.0,
            torque_constant_nm_a: 0.0333,
            emf_constant_v_s: 0.0333,
            resistance_ohm: 0.62,
            coulomb_friction_nm: 0.008,
            viscous_friction_nm_s: 0.02,
            gear_ratio: 2.0,
            gear_efficiency: 1.0,
            max_torque_nm: 1.0,
            unlimited_signals: false,
            track_factor: 1.0,
        }
    }
}

/// The defaults suit ARSim's body: without damping its time constant is 0.1 s, and its top speed is about
/// the same.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawVelocityMotor {
    pub(super) gain_n_s: f64,
    pub(super) max_torque_nm: f64,
    pub(super) full_speed_m_s: f64,
    pub(super) efficiency: f64,
    pub(super) curve_signal_share: Vec<(f64, f64)>,
}

impl Default for RawVelocityMotor {
    fn default() -> Self {
        Self {
            gain_n_s: 1.5,
            max_torque_nm: 1.0,
            full_speed_m_s: 0.8,
            efficiency: 0.7,
            curve_signal_share: Vec::new(),
        }
    }
}

/// The defaults are the Parallax 900-00008.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawServo {
    pub(super) curve_us_rpm: Vec<(f64, f64)>,
    pub(super) neutral_us: f64,
    pub(super) half_range_us: f64,
    pub(super) dead_band_us: f64,
    pub(super) trim_us: f64,
    pub(super) lag_ms: f64,
    pub(super) frame_ms: f64,
    pub(super) idle_w: f64,
    pub(super) running_w: f64,
}

impl Default for RawServo {
    /// Times and dead band are guesses; 15 mA standing still and up to 200 mA turning, at 6 V.
    fn default() -> Self {
        Self {
            curve_us_rpm: Servo::parallax_curve(),
            neutral_us: 1500.0,
            half_range_us: 200.0,
            dead_band_us: 5.0,
            trim_us: 0.0,
            lag_ms: 60.0,
            frame_ms: 20.0,
            idle_w: 0.09,
            running_w: 1.2,
        }
    }
}

/// The defaults are the e-puck's (e-puck.org, mechanics); acceleration and power are guesses.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawStepper {
    pub(super) steps_per_turn: f64,
    pub(super) full_rate_steps_s: f64,
    pub(super) max_rate_steps_s: Option<f64>,
    pub(super) max_acceleration_steps_s2: f64,
    pub(super) holding_w: f64,
    pub(super) timer_hz: Option<f64>,
    pub(super) hold_ms: Option<f64>,
}

impl Default for RawStepper {
    fn default() -> Self {
        Self {
            steps_per_turn: 1000.0,
            full_rate_steps_s: 1000.0,
            max_rate_steps_s: None,
            max_acceleration_steps_s2: 4000.0,
            holding_w: 0.5,
            timer_hz: None,
            hold_ms: None,
        }
    }
}
