//! Going where two sensors sense more, or less: Braitenberg's way of phototaxis and of chemotaxis (Section 4.4.2). It
//! compares left with right at one instant, as a tropotaxis does.

use baudbot_brain::{Body, Signals};
use serde::Deserialize;

use crate::parameter::ParameterError;
use crate::process::{MotorBehavior, StepContext};

/// The source of the stimulus, and the response to it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// Name of the sensor on the left.
    pub left: String,
    /// Name of the sensor on the right.
    pub right: String,
    /// Signal of both motors where both sense alike.
    #[serde(default = "forward")]
    pub forward: f64,
    /// The difference of the signals when one side senses all and the other nothing. Negative: away.
    #[serde(default = "gain")]
    pub gain: f64,
}

fn forward() -> f64 {
    0.4
}

fn gain() -> f64 {
    1.0
}

/// A behaviour that goes towards more of what two sensors sense.
#[derive(Clone, Debug, PartialEq)]
pub struct Taxis {
    pub(crate) forward: f64,
    pub(crate) gain: f64,
    pub(crate) sensors: [usize; 2],
}

impl Taxis {
    /// A `Taxis` for a robot with this body; an error if it has not these sensors.
    ///
    /// # Errors
    /// See [`ParameterError`].
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, ParameterError> {
        let find = |field: &str, name: &str| {
            body.sensor_index(name).ok_or_else(|| {
                let known: Vec<_> = body.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
                let problem = format_args!("there is no sensor `{name}`; there are: {}", known.join(", "));
                ParameterError::value(field, problem)
            })
        };
        let sensors = [find("left", &parameters.left)?, find("right", &parameters.right)?];
        Ok(Self { forward: parameters.forward, gain: parameters.gain, sensors })
    }
}

impl MotorBehavior for Taxis {
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let sense = |sensor: usize| context.turn.readings.get(sensor)?.as_ref()?.values.first().copied();
        let (Some(left), Some(right)) = (sense(self.sensors[0]), sense(self.sensors[1])) else {
            return Some(Signals::default());
        };
        let sum = left.abs() + right.abs();
        let difference = if sum > 0.0 { (left - right) / sum } else { 0.0 };
        let leftwards = self.gain * difference / 2.0;
        Some(Signals { left: self.forward - leftwards, right: self.forward + leftwards })
    }
}
