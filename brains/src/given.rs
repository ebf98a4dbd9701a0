//! The values that a program gets for its brain: a seed and parameters.

use std::cell::RefCell;
use std::collections::BTreeMap;

use anyhow::{anyhow, bail};
use serde_json::Value;

use crate::kinds::nearest_first;

/// The variable with the parameters, an object of JSON. `baudbot sweep`, `tune` and `run --parameter` set it.
const PARAMETERS: &str = "BAUDBOT_PARAMETERS";

/// The values that a program was started with, for its brain.
#[derive(Debug, Default)]
pub struct Given {
    /// Chooses the brain's own random numbers.
    pub seed: u64,
    parameters: BTreeMap<String, f64>,
    /// Names that the brain has asked for.
    asked: RefCell<Vec<&'static str>>,
}

impl Given {
    /// The parameters of the environment, with this seed.
    ///
    /// # Errors
    /// If those are no object of numbers.
    pub(crate) fn of_environment(seed: u64) -> anyhow::Result<Self> {
        let parameters = parse(&std::env::var(PARAMETERS).unwrap_or_default())?;
        Ok(Self { seed, parameters, ..Self::default() })
    }

    /// A parameter of the brain, or else its default. The brain asks for all that it has when it is made: a parameter that is
    /// given and that it has not asked for is an error.
    pub fn number(&self, name: &'static str, default: f64) -> f64 {
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&name) {
            asked.push(name);
        }
        self.parameters.get(name).copied().unwrap_or(default)
    }

    /// The parameters as settings of a description: paths and numbers.
    pub(crate) fn settings(&self) -> Vec<(String, f64)> {
        self.parameters.iter().map(|(path, &value)| (path.clone(), value)).collect()
    }

    /// Refuses a parameter that the brain has not asked for.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        let asked = self.asked.borrow();
        let Some(name) = self.parameters.keys().find(|name| !asked.contains(&name.as_str())) else {
            return Ok(());
        };
        if asked.is_empty() {
            bail!("there is no parameter `{name}`: the brain has none");
        }
        let known = nearest_first(name, asked.iter().copied());
        bail!("there is no parameter `{name}`; there are: {}", known.join(", "))
    }
}

/// The parameters in an object of JSON; none in an empty text.
fn parse(text: &str) -> anyhow::Result<BTreeMap<String, f64>> {
    if text.is_empty() {
        return Ok(BTreeMap::new());
    }
    let object: BTreeMap<String, Value> = serde_json::from_str(text)
        .map_err(|error| anyhow!("{PARAMETERS} is no object of JSON ({error}): {text}"))?;
    let number = |(name, value): (String, Value)| match value.as_f64() {
        Some(number) => Ok((name, number)),
        None => Err(anyhow!("parameter `{name}` must be a number, is {value}")),
    };
    object.into_iter().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(json: &str) -> Given {
        Given { parameters: parse(json).unwrap(), ..Given::default() }
    }

    #[test]
    fn a_brain_gets_its_parameters_and_what_it_does_not_know_is_refused() {
        let given = given(r#"{"speed": 0.5, "gain": 2}"#);
        assert_eq!((given.number("speed", 0.1), given.number("wanted", 0.3)), (0.5, 0.3));
        assert_eq!(
            given.check().unwrap_err().to_string(),
            "there is no parameter `gain`; there are: speed, wanted"
        );
        assert_eq!(given.number("gain", 1.0), 2.0);
        assert!(given.check().is_ok());
        let none = self::given(r#"{"sped": 1.0}"#).check().unwrap_err().to_string();
        assert_eq!(none, "there is no parameter `sped`: the brain has none");
    }

    #[test]
    fn what_is_no_object_of_numbers_is_told() {
        let error = |text: &str| parse(text).unwrap_err().to_string();
        assert!(error("[1]").starts_with("BAUDBOT_PARAMETERS is no object of JSON"), "{}", error("[1]"));
        assert_eq!(error(r#"{"a": "b"}"#), "parameter `a` must be a number, is \"b\"");
        assert!(parse("").unwrap().is_empty() && parse("{}").unwrap().is_empty());
    }
}
