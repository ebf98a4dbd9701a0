//! Driving along a wall at a distance, by what sensors on that side see.

use baudbot_brain::{Body, SensorKind, Signals};
use serde::Deserialize;

use crate::parameter::ParameterError;
use crate::process::{MotorBehavior, StepContext};

/// The parameters: the side, the distance and the gain.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// The side of the wall: `left` or `right`.
    pub side: Side,
    /// Name of a sensor that looks to that side.
    pub sensor: String,
    /// The reading that is held. Of an IR sensor it is greater the nearer the wall is, of a sonar it is metres.
    pub reading: f64,
    /// Signal of both motors on the way.
    pub forward: f64,
    /// The difference of the signals for a reading that is off by 1.
    pub gain: f64,
    /// The signals of the wheels never differ by more than this.
    pub limit: f64,
}

/// A side of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The side to the left of the heading.
    #[default]
    Left,
    /// The side to the right of the heading.
    Right,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { side: Side::Left, sensor: String::new(), reading: 0.3, forward: 0.4, gain: 0.5, limit: 0.3 }
    }
}

/// A behaviour that follows a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct FollowWall {
    pub(crate) parameters: Parameters,
    pub(crate) sensor: usize,
    pub(crate) is_distance: bool,
}

impl FollowWall {
    /// A `FollowWall` for a robot with this body; an error if it has no such sensor.
    ///
    /// # Errors
    /// See [`ParameterError`].
    pub fn new(parameters: Parameters, body: &Body) -> Result<Self, ParameterError> {
        let Some(sensor) = body.sensor_index(&parameters.sensor) else {
            let known: Vec<_> = body.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
            let problem =
                format_args!("there is no `{}`; there are: {}", parameters.sensor, known.join(", "));
            return Err(ParameterError::value("sensor", problem));
        };
        if parameters.limit < 0.0 {
            let problem = format_args!("must not be negative, is {}", parameters.limit);
            return Err(ParameterError::value("limit", problem));
        }
        let is_distance = body.sensors[sensor].kind != SensorKind::Infrared;
        Ok(Self { parameters, sensor, is_distance })
    }
}

impl MotorBehavior for FollowWall {
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let p = &self.parameters;
        let reading = context.turn.readings.get(self.sensor).and_then(Option::as_ref);
        let Some(reading) = reading.and_then(|reading| reading.values.first().copied()) else {
            return Some(Signals::default());
        };
        // Positive: too far from the wall.
        let far = if self.is_distance { reading - p.reading } else { p.reading - reading };
        let towards = (p.gain * far).clamp(-p.limit, p.limit) / 2.0;
        let leftwards = if p.side == Side::Left { towards } else { -towards };
        Some(Signals { left: p.forward - leftwards, right: p.forward + leftwards })
    }
}
