//! From the motors' table to [`Motors`].

use baudbot_wire::Encoding;
use toml::Table;

use super::context::Period;
use super::error::Sheet;
use super::sensors::take;
use baudbot_fields::number::{Between, Millis, Number, Share, Whole};
use baudbot_fields::{FieldError, Fields, Path};
use baudbot_sim::motor::{MotorNoise, Motors, Servo, VelocityMotor};
use baudbot_sim::sensor::{Device, Sensor};

type Result<T> = core::result::Result<T, FieldError>;

/// The fields that every kind of motor has.
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawMotors {
    /// The kind of motor.
    pub(super) kind: MotorKind,
    /// Bits of a signal on the wire, saturating at ±1 ([Signed](wire.md#encodings)). Without it a signal is
    /// sent as an exact 64-bit number.
    pub(super) signal_bits: Option<Number<Whole<2, 32, u8>>>,
    /// Standard deviation of a factor with mean 1 on each motor's signal, drawn once per tick.
    pub(super) noise_sigma: Number<Share>,
    /// Standard deviation of another factor with mean 1 on each motor's signal, drawn once per run: every motor is
    /// slightly different.
    pub(super) noise_spread: Number<Share>,
    /// The motors stop if no command arrives for this long. Without it the last command stays in effect.
    pub(super) timeout_ms: Option<Number<Millis<Period>>>,
    /// Delay from the instant at which the microcontroller obeys a command until the command reaches the motors.
    pub(super) dead_time_ms: Number<Millis<Between<0, 1000>>>,
}

const COMMON: [&str; 6] =
    ["kind", "signal_bits", "noise_sigma", "noise_spread", "timeout_ms", "dead_time_ms"];

#[derive(Clone, Copy, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub(super) enum MotorKind {
    #[default]
    Dc,
    Velocity,
    Servo,
    Stepper,
}

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

/// The motors that this table describes.
pub(super) fn motors(path: &Path, mut table: Table) -> Result<ParsedMotors> {
    let common: RawMotors = Sheet::from(take(&mut table, &COMMON)).read(path)?;
    let motors = motor(path, common.kind, table.into())?;
    let (track_factor, is_unlimited) = match &motors {
        Motors::Dc(motor) => (motor.track_factor, motor.unlimited_signals),
        Motors::Velocity(_) | Motors::Servo(_) | Motors::Stepper(_) => (1.0, false),
    };
    let noise = MotorNoise { sigma: common.noise_sigma.get(), spread: common.noise_spread.get() };
    let encoding = match common.signal_bits {
        None => Encoding::Float64,
        Some(_) if is_unlimited => {
            return Err(path.field("unlimited_signals").error("needs signals without `signal_bits`"));
        }
        Some(bits) => Encoding::Signed { bits: bits.get(), limit: 1.0 },
    };
    Ok(ParsedMotors {
        motors,
        noise,
        track_factor,
        encoding,
        signal_limit: (!is_unlimited).then_some(1.0),
        timeout_ns: common.timeout_ms.map(Number::get),
        dead_time_ns: common.dead_time_ms.get(),
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

fn motor(path: &Path, kind: MotorKind, fields: Sheet) -> Result<Motors> {
    Ok(match kind {
        MotorKind::Dc => Motors::Dc(fields.read(path)?),
        MotorKind::Velocity => Motors::Velocity(fields.read::<VelocityMotor>(path)?.checked(path)?),
        MotorKind::Servo => Motors::Servo(fields.read::<Servo>(path)?.checked(path)?),
        MotorKind::Stepper => Motors::Stepper(fields.read(path)?),
    })
}
