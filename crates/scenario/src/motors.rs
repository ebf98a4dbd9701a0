//! From the motors' table to [`Motors`].

mod raw;

use alloc::format;
use alloc::vec::Vec;

use baudbot_wire::Encoding;
use toml::Table;

use super::error::Sheet;
use baudbot_fields::{FieldError, Fields, Path};
use baudbot_sim::motor::{DcMotor, MotorNoise, Motors, Servo, Stepper, VelocityMotor};
use baudbot_sim::sensor::{Device, Sensor};
use raw::{COMMON_FIELDS, MotorKind};
pub(super) use raw::{RawDcMotor, RawMotors, RawServo, RawStepper, RawVelocityMotor};

type Result<T> = core::result::Result<T, FieldError>;

/// The contents of the motors' table.
pub(super) struct ParsedMotors {
    pub(super) motors: Motors,
    pub(super) noise: MotorNoise,
    pub(super) track_factor: f64,
    pub(super) encoding: Encoding,
    pub(super) signal_limit: Option<f64>,
    /// How long motors keep running without a command, in nanoseconds.
    pub(super) timeout_ns: Option<u64>,
    /// How much later commands reach the motors, in nanoseconds.
    pub(super) dead_time_ns: u64,
}

/// What ARSim's DC motors do and others do not.
struct Quirks {
    track_factor: f64,
    unlimited_signals: bool,
}

const NO_QUIRKS: Quirks = Quirks { track_factor: 1.0, unlimited_signals: false };

/// Most points of a curve.
const MAX_POINTS: usize = 1000;

/// The motors that this table describes.
pub(super) fn motors(path: &Path, mut table: Table) -> Result<ParsedMotors> {
    let mut common = Table::new();
    for field in COMMON_FIELDS {
        if let Some(value) = table.remove(field) {
            common.insert(field.into(), value);
        }
    }
    let common: RawMotors = Sheet::from(common).read(path)?;
    let (motors, quirks) = motor(path, common.kind, table.into())?;
    Ok(ParsedMotors {
        motors,
        noise: MotorNoise {
            sigma: path.within("noise_sigma", common.noise_sigma, 0.0, 1.0)?,
            spread: path.within("noise_spread", common.noise_spread, 0.0, 1.0)?,
        },
        track_factor: quirks.track_factor,
        encoding: encoding(path, common.signal_bits, quirks.unlimited_signals)?,
        signal_limit: (!quirks.unlimited_signals).then_some(1.0),
        timeout_ns: common.timeout_ms.map(|ms| path.ms("timeout_ms", ms, 0.01, 1e7)).transpose()?,
        dead_time_ns: path.ms("dead_time_ms", common.dead_time_ms, 0.0, MAX_DEAD_TIME_MS)?,
    })
}

/// Only steppers have steps to count.
pub(super) fn can_be_counted(path: &Path, motors: &Motors, sensors: &[Sensor]) -> Result<()> {
    let counter = sensors.iter().find(|sensor| matches!(sensor.device, Device::StepCounter(_)));
    match (counter, motors) {
        (None, _) | (_, Motors::Stepper(_)) => Ok(()),
        (Some(counter), Motors::Dc(_) | Motors::Velocity(_) | Motors::Servo(_)) => {
            let problem = "counts the steps of stepper motors; motors = { kind = \"stepper\" }";
            Err(path.field(&counter.name).field("kind").error(problem))
        }
    }
}

/// A regulator needs to know how fast its wheel turns (§3.2.4).
pub(super) fn can_be_regulated(path: &Path, motors: &Motors, sensors: &[Sensor]) -> Result<()> {
    let has_encoders = sensors.iter().any(|sensor| matches!(sensor.device, Device::Encoders(_)));
    if matches!(motors, Motors::Velocity(_)) && !has_encoders {
        let problem = "a velocity-regulated motor needs encoders to measure its speed with; \
                       give the robot a sensor of kind = \"encoders\"";
        return Err(path.field("kind").error(problem));
    }
    Ok(())
}

fn motor(path: &Path, kind: MotorKind, fields: Sheet) -> Result<(Motors, Quirks)> {
    Ok(match kind {
        MotorKind::Dc => {
            let raw: RawDcMotor = fields.read(path)?;
            let quirks = Quirks {
                track_factor: path.within("track_factor", raw.track_factor, 0.0, 1.0)?,
                unlimited_signals: raw.unlimited_signals,
            };
            (Motors::Dc(dc(path, &raw)?), quirks)
        }
        MotorKind::Velocity => (Motors::Velocity(velocity(path, fields.read(path)?)?), NO_QUIRKS),
        MotorKind::Servo => (Motors::Servo(servo(path, fields.read(path)?)?), NO_QUIRKS),
        MotorKind::Stepper => (Motors::Stepper(stepper(path, &fields.read(path)?)?), NO_QUIRKS),
    })
}

fn dc(path: &Path, raw: &RawDcMotor) -> Result<DcMotor> {
    Ok(DcMotor {
        voltage_v: path.positive("voltage_v", raw.voltage_v)?,
        torque_constant_nm_a: path.positive("torque_constant_nm_a", raw.torque_constant_nm_a)?,
        emf_constant_v_s: path.not_negative("emf_constant_v_s", raw.emf_constant_v_s)?,
        resistance_ohm: path.positive("resistance_ohm", raw.resistance_ohm)?,
        coulomb_friction_nm: path.not_negative("coulomb_friction_nm", raw.coulomb_friction_nm)?,
        viscous_friction_nm_s: path.not_negative("viscous_friction_nm_s", raw.viscous_friction_nm_s)?,
        gear_ratio: path.positive("gear_ratio", raw.gear_ratio)?,
        gear_efficiency: path.within("gear_efficiency", raw.gear_efficiency, f64::MIN_POSITIVE, 1.0)?,
        max_torque_nm: path.positive("max_torque_nm", raw.max_torque_nm)?,
    })
}

fn velocity(path: &Path, raw: RawVelocityMotor) -> Result<VelocityMotor> {
    Ok(VelocityMotor {
        gain_n_s: path.positive("gain_n_s", raw.gain_n_s)?,
        max_torque_nm: path.positive("max_torque_nm", raw.max_torque_nm)?,
        full_speed_m_s: path.within(
            "full_speed_m_s",
            raw.full_speed_m_s,
            f64::MIN_POSITIVE,
            MAX_SPEED_M_S,
        )?,
        efficiency: path.within("efficiency", raw.efficiency, MIN_EFFICIENCY, 1.0)?,
        reached: reached(&path.field("curve_signal_share"), raw.curve_signal_share)?,
    })
}

fn reached(path: &Path, points: Vec<(f64, f64)>) -> Result<Vec<(f64, f64)>> {
    has_points(path, &points, 0)?;
    for (i, &(signal, share)) in points.iter().enumerate() {
        let path = path.index(i);
        path.within("signal", signal, 0.0, 1.0)?;
        path.within("share", share, MIN_REACHED, 1.0)?;
    }
    increases(path, &points, "signals")?;
    Ok(points)
}

fn servo(path: &Path, raw: RawServo) -> Result<Servo> {
    let curve = curve(&path.field("curve_us_rpm"), raw.curve_us_rpm)?;
    Ok(Servo {
        curve,
        neutral_us: path.within("neutral_us", raw.neutral_us, 0.0, MAX_PULSE_US)?,
        half_range_us: path.within("half_range_us", raw.half_range_us, f64::MIN_POSITIVE, MAX_PULSE_US)?,
        dead_band_us: path.within("dead_band_us", raw.dead_band_us, 0.0, MAX_PULSE_US)?,
        trim_us: path.within("trim_us", raw.trim_us, -MAX_PULSE_US, MAX_PULSE_US)?,
        lag_s: path.within("lag_ms", raw.lag_ms, 0.0, 1e6)? / 1e3,
        frame_ns: path.ms("frame_ms", raw.frame_ms, 0.0, 1e3)?,
        idle_w: path.not_negative("idle_w", raw.idle_w)?,
        running_w: path.not_negative("running_w", raw.running_w)?,
    })
}

fn curve(path: &Path, points: Vec<(f64, f64)>) -> Result<Vec<(f64, f64)>> {
    has_points(path, &points, 1)?;
    for (i, &(pulse_us, rpm)) in points.iter().enumerate() {
        let path = path.index(i);
        path.within("pulse_us", pulse_us, 0.0, MAX_PULSE_US)?;
        path.within("rpm", rpm, -MAX_RPM, MAX_RPM)?;
    }
    increases(path, &points, "pulses")?;
    Ok(points)
}

fn has_points(path: &Path, points: &[(f64, f64)], least: usize) -> Result<()> {
    if (least..=MAX_POINTS).contains(&points.len()) {
        return Ok(());
    }
    let problem = format!("a curve has {least} to {MAX_POINTS} points; this one has {}", points.len());
    Err(path.error(problem))
}

fn increases(path: &Path, points: &[(f64, f64)], what: &str) -> Result<()> {
    let Some(i) = points.windows(2).position(|pair| pair[0].0 >= pair[1].0) else { return Ok(()) };
    let (before, after) = (points[i].0, points[i + 1].0);
    Err(path.index(i + 1).error(format!("{what} must increase, and {after} follows {before}")))
}

fn stepper(path: &Path, raw: &RawStepper) -> Result<Stepper> {
    let rate = |field, value| path.within(field, value, f64::MIN_POSITIVE, MAX_RATE);
    let full_rate_steps_s = rate("full_rate_steps_s", raw.full_rate_steps_s)?;
    Ok(Stepper {
        steps_per_turn: path.within("steps_per_turn", raw.steps_per_turn, 1.0, 1e9)?,
        full_rate_steps_s,
        max_rate_steps_s: rate("max_rate_steps_s", raw.max_rate_steps_s.unwrap_or(full_rate_steps_s))?,
        max_acceleration_steps_s2: rate("max_acceleration_steps_s2", raw.max_acceleration_steps_s2)?,
        holding_w: path.not_negative("holding_w", raw.holding_w)?,
        timer_hz: raw.timer_hz.map(|hz| rate("timer_hz", hz)).transpose()?,
        hold_s: raw.hold_ms.map(|ms| path.within("hold_ms", ms, 0.0, 1e6)).transpose()?.map(|ms| ms / 1e3),
    })
}

fn encoding(path: &Path, bits: Option<u64>, unlimited_signals: bool) -> Result<Encoding> {
    let Some(bits) = bits else { return Ok(Encoding::Float64) };
    if unlimited_signals {
        return Err(path.field("unlimited_signals").error("needs signals without `signal_bits`"));
    }
    let bits = path.whole_within("signal_bits", bits, 2, 32)? as u8;
    Ok(Encoding::Signed { bits, limit: 1.0 })
}

/// A motor that would outrun everything is a mistake in a unit.
const MAX_SPEED_M_S: f64 = 1e3;
const MAX_RPM: f64 = 1e6;
const MAX_RATE: f64 = 1e9;

/// No motors are as slow to obey as that.
const MAX_DEAD_TIME_MS: f64 = 1e3;

/// No pulse is longer than a second.
const MAX_PULSE_US: f64 = 1e6;

const MIN_EFFICIENCY: f64 = 1e-3;

/// A motor that reaches less than that of its speed does not turn.
const MIN_REACHED: f64 = 1e-3;
