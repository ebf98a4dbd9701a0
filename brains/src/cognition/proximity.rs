//! *Proximity detection* as a cognitive process (Section 6.1): whether something is close ahead that the laser may look over.
//! Other processes find that among the brain's beliefs; and a behaviour that is named gets a large Γ as long as it is so.
//!
//! *Deviation*: the notes assume such a process, and state only that its sensors should be mounted at another height than the
//! laser.

use baudbot_brain::Body;
use serde::Deserialize;

use crate::parameter::{ParameterError, check_positive};
use crate::process::{CognitiveProcess, StepContext};
use crate::proximity_sensors::{self, Near, ProximitySensors};
use crate::registry::BuildContext;

/// The distances and readings at which something is near, and the behaviour that is raised then.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The distance from a sonar, in metres, within which an object on the robot's way is near; by default three
    /// quarters of the body's radius.
    pub near_m: Option<f64>,
    /// An infra-red reading from which on something is near.
    #[serde(default = "near_reading")]
    pub near_reading: f64,
    /// Name of a motor behaviour that gets the Γ.
    pub raise: Option<String>,
    /// Γ while something is near.
    #[serde(default = "gamma")]
    pub gamma: f64,
}

fn near_reading() -> f64 {
    0.4
}

fn gamma() -> f64 {
    5.0
}

/// A process that knows what is close ahead.
#[derive(Clone, Debug)]
pub struct DetectProximity {
    proximity: ProximitySensors,
    raise: Option<(String, f64)>,
}

impl DetectProximity {
    /// A `DetectProximity` for a robot with this body.
    ///
    /// # Errors
    /// If a parameter is invalid, or no infra-red sensor or sonar looks ahead.
    pub fn new(parameters: Parameters, context: &BuildContext<'_>) -> Result<Self, ParameterError> {
        let Parameters { near_m, near_reading, raise, gamma } = parameters;
        let near_m = near_m.unwrap_or_else(|| proximity_sensors::near_m(context.body.radius_m));
        check_positive([("near_m", near_m), ("near_reading", near_reading)])?;
        if !gamma.is_finite() {
            return Err(ParameterError::range("gamma", "finite", gamma));
        }
        if let Some(name) = &raise {
            context.check_raised("raise", name)?;
        }
        let proximity = ProximitySensors::new(context.body, Near { near_m, near_reading });
        if proximity.is_empty() {
            return Err(lacks(context.body));
        }
        Ok(Self { proximity, raise: raise.map(|name| (name, gamma)) })
    }
}

fn lacks(body: &Body) -> ParameterError {
    let problem = format!("robot `{}` has no sensor of kind `ir` or `sonar` that looks ahead", body.name);
    ParameterError::Other(problem)
}

impl CognitiveProcess for DetectProximity {
    fn step(&mut self, context: &mut StepContext<'_>) {
        self.proximity.feel(context.turn);
        context.beliefs.near = self.proximity.is_near();
        if let Some((name, gamma)) = self.raise.as_ref().filter(|_| context.beliefs.near) {
            context.set_gamma(name, *gamma);
        }
    }

    fn enter(&mut self, _: &mut StepContext<'_>) {
        self.proximity.forget();
    }

    fn leave(&mut self, context: &mut StepContext<'_>) {
        context.beliefs.near = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::Beliefs;
    use crate::test_body::{body, turn};

    fn made(toml: &str, body: &Body) -> Result<DetectProximity, String> {
        let context =
            BuildContext { name: "proximity", body, seed: 1, motors: &["stand", "go"], by_utility: true };
        let parameters = toml::from_str(toml).map_err(|error| error.message().to_owned())?;
        DetectProximity::new(parameters, &context).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_near_is_believed_and_raises_a_behaviour_until_it_is_gone() {
        let body = body(&[("ir", "ir", 0.3), ("sonar", "sonar", 0.0), ("behind", "ir", 3.0)]);
        let mut process = made("raise = \"stand\"\ngamma = 7", &body).unwrap();
        let mut beliefs = Beliefs::default();
        for (values, near) in [
            ([Some([0.1]), Some([1.0]), Some([0.9])], false),
            ([Some([0.5]), None, None], true),
            ([None, None, None], true),
            ([Some([0.1]), Some([0.1]), None], true),
            ([None, Some([0.6]), None], false),
        ] {
            let values = values.each_ref().map(|value| value.as_ref().map(<[f64; 1]>::as_slice));
            let turn = turn(&body, 0, &values);
            let mut gammas = Vec::new();
            let mut context = StepContext {
                turn: &turn,
                dt_s: 0.1,
                state: &[],
                beliefs: &mut beliefs,
                gammas: &mut gammas,
            };
            process.step(&mut context);
            assert_eq!(context.beliefs.near, near, "{values:?}");
            assert_eq!(gammas, if near { vec![("stand".to_owned(), 7.0)] } else { vec![] });
        }
        let turn = turn(&body, 0, &[Some(&[0.9]), None, None]);
        let mut context = StepContext {
            turn: &turn,
            dt_s: 0.1,
            state: &[],
            beliefs: &mut beliefs,
            gammas: &mut Vec::new(),
        };
        process.step(&mut context);
        process.leave(&mut context);
        assert!(!context.beliefs.near, "nobody knows any more");
        process.enter(&mut context);
        assert!(!process.proximity.is_near(), "what was then is not now");
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let ahead = body(&[("ir", "ir", 0.3)]);
        let refused = |toml: &str| made(toml, &ahead).err().unwrap_or_default();
        assert_eq!(refused(""), "");
        assert_eq!(refused("near_m = 0"), "near_m: must be positive, is 0");
        assert_eq!(refused("gamma = nan"), "gamma: must be finite, is NaN");
        assert_eq!(
            refused("raise = \"stop\""),
            "raise: there is no motor behaviour `stop`; there are: stand, go"
        );
        let behind = body(&[("ir", "ir", 3.0), ("laser", "laser", 0.0)]);
        let refused = made("", &behind).err().unwrap();
        assert_eq!(refused, "robot `alice` has no sensor of kind `ir` or `sonar` that looks ahead");
    }
}
