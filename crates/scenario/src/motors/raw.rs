//! The fields of the motors' table.

use alloc::vec::Vec;

use baudbot_sim::motor::Servo;

/// The fields that every kind of motor has.
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct RawMotors {
    /// The kind of motor.
    pub(crate) kind: MotorKind,
    /// Bits of a signal on the wire, saturating at ±1 ([Signed](wire.md#encodings)). Without it a signal is
    /// sent as an exact 64-bit number. Range: 2 to 32.
    pub(crate) signal_bits: Option<u64>,
    /// Standard deviation of a factor with mean 1 on each motor's signal, drawn once a tick. Range: 0 to 1.
    pub(crate) noise_sigma: f64,
    /// The same, drawn once a run: every motor is slightly different. Range: 0 to 1.
    pub(crate) noise_spread: f64,
    /// The motors stop if no command arrives for this long. Without it they keep obeying the last one. Range:
    /// 0.01 to 10^7.
    pub(crate) timeout_ms: Option<f64>,
    /// How much later than the microcontroller obeys it a command reaches the motors. Range: 0 to 1000.
    pub(crate) dead_time_ms: f64,
}

pub(crate) const COMMON_FIELDS: [&str; 6] =
    ["kind", "signal_bits", "noise_sigma", "noise_spread", "timeout_ms", "dead_time_ms"];

#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub(crate) enum MotorKind {
    #[default]
    Dc,
    Velocity,
    Servo,
    Stepper,
}

/// The defaults are ARSim's motor, made for a robot of a few kg.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct RawDcMotor {
    /// Voltage at motor signal 1. Range: positive.
    pub(crate) voltage_v: f64,
    /// c_t of Eq. (1.8), N m / A. Range: positive.
    pub(crate) torque_constant_nm_a: f64,
    /// c_e of Eq. (1.8), V s / rad. Range: not negative.
    pub(crate) emf_constant_v_s: f64,
    /// R of Eq. (1.8). Range: positive.
    pub(crate) resistance_ohm: f64,
    /// c_C of Eq. (1.9), at the motor's shaft. Range: not negative.
    pub(crate) coulomb_friction_nm: f64,
    /// c_v of Eq. (1.9), at the motor's shaft. Range: not negative.
    pub(crate) viscous_friction_nm_s: f64,
    /// G of Eq. (1.10): turns of the shaft a turn of the wheel. Range: positive.
    pub(crate) gear_ratio: f64,
    /// Share of the torque that the gear box transmits. Range: above 0, at most 1.
    pub(crate) gear_efficiency: f64,
    /// Largest torque on the wheel. Range: positive.
    pub(crate) max_torque_nm: f64,
    /// ARSim's quirk: a command may exceed ±1. Without it such a command is rejected. Range: only without
    /// `signal_bits`.
    pub(crate) unlimited_signals: bool,
    /// ARSim's quirk at 0.5: the share of the half track that counts for the wheel speeds in the motor model.
    /// Range: 0 to 1.
    pub(crate) track_factor: f64,
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct RawVelocityMotor {
    /// K of Eq. (3.15): torque on the wheel for each m/s of speed error. Range: positive.
    pub(crate) gain_n_s: f64,
    /// Largest torque on the wheel. Range: positive.
    pub(crate) max_torque_nm: f64,
    /// Commanded speed of the wheel's rim at signal 1. Range: above 0, at most 1000.
    pub(crate) full_speed_m_s: f64,
    /// Mechanical power per electrical power, for the battery. Range: 0.001 to 1.
    pub(crate) efficiency: f64,
    /// Share of the commanded speed that is reached, over the size of the signal: linear between the points,
    /// constant beyond the ends. Without it all of it is reached. Type: list of `[signal, share]`. Default:
    /// none. Range: at most 1000 points; signals 0 to 1, increasing; shares 0.001 to 1.
    pub(crate) curve_signal_share: Vec<(f64, f64)>,
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct RawServo {
    /// Turns a minute over the pulse width in µs: linear between the points, constant beyond the ends. Type:
    /// list of `[width, speed]`. Default: the Parallax's: ±48 a minute, flat beyond 1.4 and 1.6 ms. Range: 1 to
    /// 1000 points; widths 0 to 10^6, increasing; speeds −10^6 to 10^6.
    pub(crate) curve_us_rpm: Vec<(f64, f64)>,
    /// Width at signal 0. Range: 0 to 10^6.
    pub(crate) neutral_us: f64,
    /// How much wider the pulse is at signal 1. Range: above 0, at most 10^6.
    pub(crate) half_range_us: f64,
    /// Pulses this close to the servo's own neutral width stop it. Range: 0 to 10^6.
    pub(crate) dead_band_us: f64,
    /// How far the servo's own neutral width, adjusted by a screw, is above `neutral_us`. Range: −10^6 to 10^6.
    pub(crate) trim_us: f64,
    /// Time constant of its speed. Range: 0 to 10^6.
    pub(crate) lag_ms: f64,
    /// Time between two pulses. A command takes effect with the next one; with 0, immediately. Range: 0 to
    /// 1000.
    pub(crate) frame_ms: f64,
    /// Electrical power at standstill. Range: not negative.
    pub(crate) idle_w: f64,
    /// Electrical power while turning. Range: not negative.
    pub(crate) running_w: f64,
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct RawStepper {
    /// Steps per turn of the wheel, including the gear box. Range: 1 to 10^9.
    pub(crate) steps_per_turn: f64,
    /// Pulses a second at signal 1. Range: above 0, at most 10^9.
    pub(crate) full_rate_steps_s: f64,
    /// With more pulses a second the rotor stalls. Default: `full_rate_steps_s`. Range: above 0, at most 10^9.
    pub(crate) max_rate_steps_s: Option<f64>,
    /// How fast the rotor's rate can change. Range: above 0, at most 10^9.
    pub(crate) max_acceleration_steps_s2: f64,
    /// Electrical power of its coils while they are on, turning or not. Range: not negative.
    pub(crate) holding_w: f64,
    /// Rate of the timer that makes the pulses. The speed asked for is rounded to whole steps a second, v, and
    /// a pulse comes every ⌊timer_hz / v⌋ ticks of the timer: with 10,000, 950 steps/s become 1000 and 800
    /// become 833.3. Without it any rate can be made. Range: above 0, at most 10^9.
    pub(crate) timer_hz: Option<f64>,
    /// The coils are switched off so long after a step, which saves power below 1 / `hold_ms` steps/s. Without
    /// it they are always on. Range: 0 to 10^6.
    pub(crate) hold_ms: Option<f64>,
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
