//! Turning on the spot away from what is near, as a reflex: to the side that sensors on the other side chose when it began,
//! and no other way until it ends. A robot that could change the way would dither in corners.

use baudbot_brain::{Body, SensorKind, Signals};
use serde::Deserialize;

use crate::parameter::ParameterError;
use crate::process::{MotorBehavior, StepContext};

/// The speed of the turn.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Size of the motors' signals.
    pub turn: f64,
    /// Sensors whose heading is off the robot's by more than this do not count, in radians.
    pub field_rad: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { turn: 0.4, field_rad: 1.75 }
    }
}

/// A reflex that turns away from what infra-red sensors, or those that measure distances, see nearer.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnAway {
    pub(crate) turn: f64,
    pub(crate) eyes: Vec<Eye>,
    leftwards: bool,
}

/// A sensor that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Eye {
    pub(crate) sensor: usize,
    pub(crate) is_left: bool,
    /// An IR sensor's reading is greater the nearer something is; a sonar's is a distance.
    pub(crate) is_distance: bool,
}

impl TurnAway {
    /// A `TurnAway` for a robot with this body; an error if it has nothing that sees how near something is on both
    /// sides.
    ///
    /// # Errors
    /// See [`ParameterError`].
    pub fn new(parameters: Parameters, body: &Body) -> Result<Self, ParameterError> {
        let eyes = body.sensors.iter().enumerate().filter_map(|(sensor, described)| {
            let bearing_rad = baudbot_geometry::angle::wrap(described.mount?.heading_rad);
            let is_seeing = matches!(described.kind, SensorKind::Infrared | SensorKind::Sonar);
            let counts = is_seeing && bearing_rad != 0.0 && bearing_rad.abs() <= parameters.field_rad;
            counts.then_some(Eye {
                sensor,
                is_left: bearing_rad > 0.0,
                is_distance: described.kind == SensorKind::Sonar,
            })
        });
        let eyes: Vec<_> = eyes.collect();
        if !(eyes.iter().any(|eye| eye.is_left) && eyes.iter().any(|eye| !eye.is_left)) {
            let needed = "needs sensors of kind `ir` or `sonar` that look ahead to the left and to the right";
            return Err(ParameterError::Other(needed.to_owned()));
        }
        Ok(Self { turn: parameters.turn, eyes, leftwards: false })
    }

    /// The nearness of things on a side: a number that is greater the nearer they are.
    fn nearness(&self, context: &StepContext<'_>, is_left: bool) -> f64 {
        let eyes = self.eyes.iter().filter(|eye| eye.is_left == is_left);
        let values = eyes.filter_map(|eye| {
            let value = *context.turn.readings.get(eye.sensor)?.as_ref()?.values.first()?;
            Some(if eye.is_distance { -value } else { value })
        });
        values.fold(f64::NEG_INFINITY, f64::max)
    }
}

impl MotorBehavior for TurnAway {
    fn enter(&mut self, context: &mut StepContext<'_>) {
        self.leftwards = self.nearness(context, false) >= self.nearness(context, true);
    }

    fn step(&mut self, _: &mut StepContext<'_>) -> Option<Signals> {
        let turn = if self.leftwards { self.turn } else { -self.turn };
        Some(Signals { left: -turn, right: turn })
    }
}
