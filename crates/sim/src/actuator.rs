//! Actuators besides the wheels: a servo that turns a sensor, a lamp, a loudspeaker, a dispenser of scent.

use alloc::string::String;

use serde::{Deserialize, Serialize};

use baudbot_fields::number::{Between, Number, Positive, UpTo};

use crate::motor::PositionalServo;

/// The kind and the limits of an actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Unique on its robot.
    pub name: String,
    /// Its kind.
    pub kind: ActuatorKind,
}

/// The kinds of actuator that there are. Each takes one signal; the firmware holds it within [−1, 1].
#[derive(Clone, Debug, PartialEq)]
pub enum ActuatorKind {
    /// A positional servo in the robot's centre that turns what is mounted on it: −1 and 1 reach the ends of its
    /// range.
    Turret(PositionalServo),
    /// A lamp over the robot's centre: 1 is full brightness, 0 and less is dark.
    Lamp(Lamp),
    /// A loudspeaker in the robot's centre: 1 is full loudness, 0 and less is silence.
    Speaker(Speaker),
    /// A dispenser in the robot's centre that lays a trail: 1 is the full rate, 0 and less is none.
    Dispenser(Dispenser),
}

/// What a lamp is.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Lamp {
    /// Luminous intensity at signal 1, the same in all directions, in candela.
    #[serde(with = "Number::<Positive>")]
    pub intensity_cd: f64,
    /// Height above the floor.
    #[serde(default, with = "Number::<Between<0, 1000>>")]
    pub height_m: f64,
}

/// What a loudspeaker is.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Speaker {
    /// Loudness at signal 1, at a distance of 1 m.
    #[serde(with = "Number::<UpTo<1_000_000_000>>")]
    pub level: f64,
    /// Frequency of its tone. Without it the speaker makes a noise, which every microphone hears whatever its band.
    pub frequency_hz: Option<Number<UpTo<1_000_000>>>,
}

/// What a dispenser is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dispenser {
    /// The field that it writes to, by its place in the surroundings.
    pub field: usize,
    /// Amount that it lays down at signal 1, in the field's unit times m², each second.
    pub rate_per_s: f64,
}

/// State of an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ActuatorState {
    /// The signal in force.
    pub signal: f64,
    /// Of a turret: the signal when its present pulse began.
    pub pulse: f64,
    /// The angle of a turret, in radians, positive to the left.
    pub angle_rad: f64,
}

impl ActuatorState {
    pub(crate) fn is_sound(&self) -> bool {
        crate::sound::numbers([self.signal, self.pulse, self.angle_rad])
    }
}

impl Actuator {
    /// The scenario's name for its kind.
    pub fn kind(&self) -> &'static str {
        match self.kind {
            ActuatorKind::Turret(_) => "turret",
            ActuatorKind::Lamp { .. } => "lamp",
            ActuatorKind::Speaker { .. } => "speaker",
            ActuatorKind::Dispenser { .. } => "dispenser",
        }
    }
}
