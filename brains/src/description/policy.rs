//! The table `[policy]` of a description: a network that is the whole brain.

use baudbot_brain::Body;
use serde::Deserialize;

use super::DescriptionError;
use super::raw::{Raw, RawDecision};
use crate::network::Network;
use crate::policy::{Policy, input_names};

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPolicy {
    /// The version of the format; absent in files from before there was one.
    version: Option<u32>,
    layers: Vec<Vec<Vec<f64>>>,
    offset: Option<Vec<f64>>,
    scale: Option<Vec<f64>>,
    #[serde(default)]
    ages: bool,
    max_age_s: Option<f64>,
    /// The sensors of the robot that the policy was learnt on; absent in files of earlier versions.
    sensors: Option<Vec<RawSensor>>,
}

/// A sensor whose values are inputs.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSensor {
    name: String,
    /// The number of its values.
    values: usize,
}

/// The version of the format.
const VERSION: u32 = 1;

impl RawPolicy {
    /// Checks the parts that need no robot.
    pub(super) fn check(&self, whole: &Raw) -> Result<(), DescriptionError> {
        let others = [
            ("motor", whole.motor.is_empty()),
            ("cognitive", whole.cognitive.is_empty()),
            ("state_variables", whole.state_variables.is_empty()),
            ("internal", whole.internal.is_empty()),
            ("actuators", whole.actuators.is_empty()),
            ("decision", whole.decision == RawDecision::default()),
        ];
        if let Some((table, _)) = others.into_iter().find(|(_, is_empty)| !is_empty) {
            return Err(DescriptionError::new(table, "beside a policy there are no processes; leave it out"));
        }
        if let Some(version) = self.version.filter(|version| *version != VERSION) {
            let text = format!("is {version}; this version of baudbot reads {VERSION}");
            return Err(problem("version", text));
        }
        match self.max_age_s {
            Some(_) if !self.ages => Err(problem("max_age_s", "counts only with ages = true")),
            Some(max_s) if !(max_s > 0.0 && max_s < 1e9) => {
                Err(problem("max_age_s", format!("must be above 0 and below 1e9, is {max_s}")))
            }
            _ => Ok(()),
        }
    }

    /// The policy for a robot with this body.
    pub(super) fn policy(&self, body: &Body) -> Result<Policy, DescriptionError> {
        self.check_sensors(body)?;
        let names = input_names(body, self.ages);
        let per_input = |field: &str, given: &Option<Vec<f64>>, default: f64| match given {
            Some(numbers) if numbers.len() != names.len() => {
                Err(problem(field, format!("has {} numbers, and {}", numbers.len(), inputs(body, &names))))
            }
            given => Ok(given.clone().unwrap_or_else(|| vec![default; names.len()])),
        };
        let (offset, scale) =
            (per_input("offset", &self.offset, 0.0)?, per_input("scale", &self.scale, 1.0)?);
        let network = Network { layers: self.layers.clone() };
        if let Some(misfit) = network.misfit(names.len()) {
            let more = misfit.place.starts_with("[0]").then(|| format!("; {}", inputs(body, &names)));
            let field = format!("layers{}", misfit.place);
            return Err(problem(&field, misfit.problem + &more.unwrap_or_default()));
        }
        let wheels = ["left", "right"].into_iter();
        let signals: Vec<_> = wheels.chain(body.actuators.iter().map(|other| other.name.as_str())).collect();
        let answers = self.layers.last().map_or(0, Vec::len);
        if answers != signals.len() {
            let (robot, count, names) = (&body.name, signals.len(), signals.join(", "));
            let said = format!("has {answers} neurons, and robot `{robot}` takes {count} signals: {names}");
            return Err(problem(&format!("layers[{}]", self.layers.len() - 1), said));
        }
        Ok(Policy::new(body, network, offset, scale, self.ages.then(|| self.max_age_s.unwrap_or(MAX_AGE_S))))
    }
}

impl RawPolicy {
    /// Refuses a robot with other sensors than those with which the policy was learnt.
    fn check_sensors(&self, body: &Body) -> Result<(), DescriptionError> {
        let Some(learnt) = &self.sensors else { return Ok(()) };
        let robot = format!("robot `{}`", body.name);
        let there = body.sensors.iter().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>();
        for (i, RawSensor { name, values }) in learnt.iter().enumerate() {
            let field = format!("sensors[{i}]");
            let Some(sensor) = body.sensors.iter().find(|sensor| sensor.name == *name) else {
                let said = format!("{robot} has no `{name}`, with which the policy was learnt; it has: ");
                return Err(problem(&field, said + &there.join(", ")));
            };
            if sensor.values() != *values {
                let own = sensor.values();
                let said = format!(
                    "`{name}` had {values} values where the policy was learnt; that of {robot} has {own}"
                );
                return Err(problem(&field, said));
            }
        }
        let learnt: Vec<_> = learnt.iter().map(|sensor| sensor.name.as_str()).collect();
        if let Some(other) = there.iter().find(|name| !learnt.contains(name)) {
            let said = format!("{robot} has a `{other}`, without which the policy was learnt");
            return Err(problem("sensors", said));
        }
        if there != learnt {
            let said = format!("{robot} has them in another order: {}", there.join(", "));
            return Err(problem("sensors", said));
        }
        Ok(())
    }
}

/// The number of inputs, and the first of their names.
fn inputs(body: &Body, names: &[String]) -> String {
    let (shown, count) = (names[..names.len().min(SHOWN)].join(", "), names.len());
    let more = if count > SHOWN { ", …" } else { "" };
    format!("robot `{}` gives {count} inputs: {shown}{more}", body.name)
}

fn problem(field: &str, problem: impl Into<String>) -> DescriptionError {
    DescriptionError::new(format!("policy.{field}"), problem)
}

/// Ages above it are given as it, unless the description has another, in seconds. That of environments.
const MAX_AGE_S: f64 = 1.0;

/// The most inputs that an error names: a laser has hundreds.
const SHOWN: usize = 32;
