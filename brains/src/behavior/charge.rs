//! Going to a charger and standing there until the battery is full.

use baudbot_brain::{Body, Signals};
use baudbot_geometry::{Point, math};
use serde::Deserialize;

use crate::parameter::ParameterError;
use crate::process::{MotorBehavior, StepContext};
use crate::senses::Source;
use crate::steering::{Helm, Steering};

/// The place of the charger, and the charge that is enough.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The charger's place, `[x, y]` in metres, in the frame of the believed pose.
    pub charger_m: [f64; 2],
    /// The robot stands within this distance, in metres.
    #[serde(default = "reached_m")]
    pub reached_m: f64,
    /// The reading that gives the charge of the battery, from 0 to 1: `SENSOR.PART`.
    #[serde(default = "battery")]
    pub battery: String,
    /// So full is enough.
    #[serde(default = "full")]
    pub full: f64,
    /// Γ of this behaviour until then, once it is there, so that the charger is not left half full.
    #[serde(default = "stay_gamma")]
    pub stay_gamma: f64,
    /// The gains and speeds of its steering.
    #[serde(default)]
    pub steering: Steering,
}

fn reached_m() -> f64 {
    0.1
}

fn battery() -> String {
    "gauge.charge".to_owned()
}

fn full() -> f64 {
    0.95
}

fn stay_gamma() -> f64 {
    5.0
}

/// A behaviour that charges the battery.
#[derive(Clone, Debug, PartialEq)]
pub struct Charge {
    /// The name in the repertoire.
    name: String,
    charger: Point,
    parameters: Parameters,
    battery: Source,
    helm: Helm,
}

impl Charge {
    /// A `Charge` for a robot with this body, by the name that the behaviour has in the repertoire; an error if no
    /// sensor measures its battery.
    ///
    /// # Errors
    /// See [`ParameterError`].
    pub fn new(name: &str, parameters: Parameters, body: &Body) -> Result<Self, ParameterError> {
        parameters.steering.check()?;
        if parameters.reached_m <= 0.0 {
            return Err(ParameterError::range("reached_m", "positive", parameters.reached_m));
        }
        if !(parameters.full > 0.0 && parameters.full <= 1.0) {
            return Err(ParameterError::range("full", "above 0 and at most 1", parameters.full));
        }
        let battery = Source::parse(&parameters.battery, body)
            .map_err(|error| ParameterError::value("battery", error))?;
        let [x, y] = parameters.charger_m;
        let helm = Helm::new(parameters.steering);
        Ok(Self { name: name.to_owned(), charger: Point::new(x, y), parameters, battery, helm })
    }
}

impl MotorBehavior for Charge {
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        let Some(estimate) = context.beliefs.pose else { return Some(Signals::default()) };
        let p = &self.parameters;
        let offset = self.charger - estimate.world_from_robot.position;
        if math::hypot(offset.x, offset.y) <= p.reached_m {
            let charge = self.battery.first(context.turn).unwrap_or(0.0);
            context.set_gamma(&self.name, if charge < p.full { p.stay_gamma } else { 0.0 });
            context.beliefs.intention = format!("charges, {:.0} %", charge * 100.0);
            context.beliefs.path.clear();
            return Some(Signals::default());
        }
        context.beliefs.intention.clear();
        context.beliefs.path = vec![self.charger];
        Some(self.helm.signals(&estimate.world_from_robot, math::atan2(offset.y, offset.x), 1.0))
    }

    fn goes_by_pose(&self) -> bool {
        true
    }
}
