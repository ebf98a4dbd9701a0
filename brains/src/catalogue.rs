//! All brains by name, and the text that describes one: `NAME[:PARAMETER=NUMBER,…]`.

use std::ops::RangeInclusive;

use baudbot_client::{Body, Brain};
use thiserror::Error;

use crate::chance::Chance;
use crate::parameter::Parameter;
use crate::{Avoid, Constant, Navigate, Wander, avoid, constant, navigate, wander};

/// A kind of brain.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it is called.
    pub name: &'static str,
    /// What it does, in a line.
    pub summary: &'static str,
    /// What can be set.
    pub parameters: Vec<Setting>,
}

/// A parameter of a kind of brain.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// What it is called.
    pub name: &'static str,
    /// What it means, with its unit.
    pub meaning: &'static str,
    /// Its value if it is not set.
    pub default: f64,
    /// The values that it can be set to.
    pub range: RangeInclusive<f64>,
}

/// Why a text describes no brain for a body.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CatalogueError {
    /// There is no such brain.
    #[error("no brain `{name}`; there are: {}", known.join(", "))]
    Brain {
        /// The name given.
        name: String,
        /// Those that exist, the nearest first.
        known: Vec<&'static str>,
    },
    /// The brain has no such parameter.
    #[error("brain `{brain}` has no parameter `{name}`; it has: {}", known.join(", "))]
    Parameter {
        /// Name of the brain.
        brain: &'static str,
        /// The name given.
        name: String,
        /// Those that it has, the nearest first.
        known: Vec<&'static str>,
    },
    /// A setting without a value.
    #[error("brain `{brain}`: `{found}` sets no parameter; write NAME=NUMBER")]
    Setting {
        /// Name of the brain.
        brain: &'static str,
        /// The text given.
        found: String,
    },
    /// A value that is no number.
    #[error("brain `{brain}`: {parameter} must be a number, not `{found}`")]
    Number {
        /// Name of the brain.
        brain: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// The text given.
        found: String,
    },
    /// A number that makes no sense.
    #[error("brain `{brain}`: {parameter} must be from {} to {}, not {found}", range.start(), range.end())]
    Range {
        /// Name of the brain.
        brain: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// The numbers that make sense.
        range: RangeInclusive<f64>,
        /// The number given.
        found: f64,
    },
    /// The robot has not the sensors that the brain needs.
    #[error("brain `{brain}` needs {needed}, but robot `{robot}` has only: {}", found.join(", "))]
    Sensor {
        /// Name of the brain.
        brain: &'static str,
        /// Name of the robot.
        robot: String,
        /// What it needs.
        needed: &'static str,
        /// Names of the sensors that there are.
        found: Vec<String>,
    },
}

/// Makes the brain that `description` describes, such as `wander` or `constant:left=0.5,right=-0.5`, for a
/// robot with this body. If a parameter is set twice, the last counts.
///
/// # Errors
/// Says what is wrong with the description and what would be right, or which sensor the body lacks.
pub fn brain(description: &str, seed: u64, body: &Body) -> Result<Box<dyn Brain + Send>, CatalogueError> {
    let (name, settings) = description.split_once(':').unwrap_or((description, ""));
    let chance = || Chance::new(seed, &format!("{}/{name}", body.name));
    let lacks = |brain, needed| CatalogueError::Sensor {
        brain,
        robot: body.name.clone(),
        needed,
        found: body.sensors.iter().map(|sensor| sensor.name.clone()).collect(),
    };
    Ok(match name {
        CONSTANT => Box::new(Constant::new(set(CONSTANT, constant::PARAMETERS, settings)?)),
        WANDER => Box::new(Wander::new(set(WANDER, wander::PARAMETERS, settings)?, chance())),
        NAVIGATE => {
            let parameters = set(NAVIGATE, navigate::PARAMETERS, settings)?;
            let odometer = body.sensor(navigate::ODOMETER).filter(|sensor| sensor.components.len() >= 2);
            odometer.ok_or_else(|| lacks(NAVIGATE, "a sensor `odometer` with x_m and y_m"))?;
            Box::new(Navigate::new(parameters))
        }
        AVOID => {
            let parameters = set(AVOID, avoid::PARAMETERS, settings)?;
            let avoid = Avoid::new(parameters, chance(), body);
            Box::new(avoid.ok_or_else(|| lacks(AVOID, "a sensor of kind `ir` that looks ahead"))?)
        }
        _ => {
            let known = nearest_first(name, catalogue().into_iter().map(|entry| entry.name));
            return Err(CatalogueError::Brain { name: name.to_owned(), known });
        }
    })
}

/// All kinds of brains, for help texts.
pub fn catalogue() -> Vec<Entry> {
    vec![
        entry(AVOID, "wanders without running into what its infra-red sensors see", avoid::PARAMETERS),
        entry(CONSTANT, "sends the same signals in every step", constant::PARAMETERS),
        entry(NAVIGATE, "drives a distance by its odometer and stops", navigate::PARAMETERS),
        entry(WANDER, "drives on and turns now and then, blindly and at random", wander::PARAMETERS),
    ]
}

fn entry<P: Default>(name: &'static str, summary: &'static str, parameters: &[Parameter<P>]) -> Entry {
    let mut defaults = P::default();
    let setting = |parameter: &Parameter<P>| Setting {
        name: parameter.name,
        meaning: parameter.meaning,
        default: *(parameter.field)(&mut defaults),
        range: parameter.range.clone(),
    };
    Entry { name, summary, parameters: parameters.iter().map(setting).collect() }
}

/// The default parameters with the changes that `settings` makes.
fn set<P: Default>(brain: &'static str, known: &[Parameter<P>], settings: &str) -> Result<P, CatalogueError> {
    let mut parameters = P::default();
    for setting in settings.split(',').map(str::trim).filter(|setting| !setting.is_empty()) {
        let no_setting = || CatalogueError::Setting { brain, found: setting.to_owned() };
        let (name, value) = setting.split_once('=').ok_or_else(no_setting)?;
        let (name, value) = (name.trim(), value.trim());
        let Some(parameter) = known.iter().find(|parameter| parameter.name == name) else {
            let known = nearest_first(name, known.iter().map(|parameter| parameter.name));
            return Err(CatalogueError::Parameter { brain, name: name.to_owned(), known });
        };
        let parameter_name = parameter.name;
        let no_number =
            |_| CatalogueError::Number { brain, parameter: parameter_name, found: value.to_owned() };
        let found = value.parse().map_err(no_number)?;
        if !parameter.range.contains(&found) {
            let range = parameter.range.clone();
            return Err(CatalogueError::Range { brain, parameter: parameter_name, range, found });
        }
        *(parameter.field)(&mut parameters) = found;
    }
    Ok(parameters)
}

/// Names, those first that are most like `name`: that have the fewest letters to be put in, left out or changed.
pub fn nearest_first<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut known: Vec<_> = known.collect();
    known.sort_by_key(|candidate| distance(name, candidate));
    known
}

/// How many letters must be put in, left out or changed to make `b` of `a` (Levenshtein's distance).
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.chars().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.chars().count()]
}

const AVOID: &str = "avoid";
const CONSTANT: &str = "constant";
const NAVIGATE: &str = "navigate";
const WANDER: &str = "wander";

#[cfg(test)]
mod tests {
    use baudbot_client::Action;

    use super::*;
    use crate::test_body::{body, turn};

    fn error(description: &str) -> String {
        match brain(description, 1, &body(&[("ir_rear", "ir", 3.1)])) {
            Ok(_) => panic!("{description} is a brain"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn parameters_are_set() {
        let body = body(&[]);
        let mut constant = brain("constant: left = 0.5, right=-0.25,", 1, &body).unwrap();
        assert_eq!(constant.step(&turn(&body, 0, &[])), Action::drive(0.5, -0.25));
        let mut wander = brain("wander:forward=0.1", 1, &body).unwrap();
        assert_eq!(wander.step(&turn(&body, 0, &[])), Action::drive(0.1, 0.1));
    }

    #[test]
    fn what_is_wrong_is_said_with_what_would_be_right() {
        assert_eq!(error("wonder"), "no brain `wonder`; there are: wander, avoid, constant, navigate");
        assert_eq!(error(""), "no brain ``; there are: avoid, wander, constant, navigate");
        assert_eq!(
            error("constant:rigth=1"),
            "brain `constant` has no parameter `rigth`; it has: right, left"
        );
        assert_eq!(error("constant:left"), "brain `constant`: `left` sets no parameter; write NAME=NUMBER");
        assert_eq!(error("constant:left=full"), "brain `constant`: left must be a number, not `full`");
        assert_eq!(
            error("wander:turn_probability=3"),
            "brain `wander`: turn_probability must be from 0 to 1, not 3"
        );
        assert_eq!(error("wander:turn=NaN"), "brain `wander`: turn must be from -10 to 10, not NaN");
    }

    #[test]
    fn a_missing_sensor_is_named() {
        assert_eq!(
            error("navigate"),
            "brain `navigate` needs a sensor `odometer` with x_m and y_m, but robot `alice` has only: ir_rear"
        );
        assert!(
            error("avoid").starts_with("brain `avoid` needs a sensor of kind `ir` that looks ahead, but")
        );
    }

    #[test]
    fn every_default_is_within_its_range_and_every_brain_can_be_made() {
        let body = body(&[("odometer", "odometer", 0.0), ("eye", "ir", 0.0)]);
        for entry in catalogue() {
            for setting in &entry.parameters {
                assert!(setting.range.contains(&setting.default), "{}: {setting:?}", entry.name);
                let same = format!("{}:{}={}", entry.name, setting.name, setting.default);
                assert!(brain(&same, 1, &body).is_ok(), "{same}");
            }
        }
    }

    #[test]
    fn distances() {
        let found = [("", "abc"), ("abc", "abc"), ("abd", "abc"), ("bc", "abc"), ("kitten", "sitting")];
        assert_eq!(found.map(|(a, b)| distance(a, b)), [3, 0, 1, 1, 3]);
    }
}
