//! Brains described in TOML: repertoire, state variables, utilities, parameters.
//!
//! ```toml
//! [state_variables.front]
//! of = ["ir_left", "ir_right"]        # sensors, or parts of them: "odometer.x_m"
//! by = "max"                          # or "min", "sum" with weights, "network" with layers
//!
//! [motor.stroll]
//! kind = "wander"                     # docs/reference/brains.md lists the kinds
//! parameters = { forward = 0.4 }
//! utility = { bias = 0.2 }
//!
//! [motor.turn_away]
//! kind = "turn_away"
//! utility = { bias = -0.3, weights = { front = 3.0 } }
//! ```
//!
//! A description may have a table `[policy]` instead: a [network](crate::policy) from readings to signals.
//!
//! A description is read in two steps: [`Description::parse`] needs nothing but the text, [`Description::any_brain`] a robot's
//! body and a [`Registry`]. Each error names its path: `motor.turn_away.utility.weights.frnt: there is no state
//! variable `frnt`; there are: front`.

mod build;
mod edited;
mod export;
mod policy;
mod raw;

use baudbot_brain::{Body, Brain};
use baudbot_fields::{Cause, Writes};
use toml::{Table, Value};

use crate::composed::Composed;
use crate::registry::Registry;
pub(crate) use edited::edited;
use raw::Raw;

/// A brain as a text describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    raw: Raw,
}

/// An error in a description, with its path in the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{problem}", if path.is_empty() { String::new() } else { format!("{path}: ") })]
pub struct DescriptionError {
    /// The path of the field, such as `motor.charge.parameters`; empty if it is not one field's.
    pub path: String,
    /// The problem, and the remedy.
    pub problem: String,
    /// The kind of problem.
    pub cause: Cause,
}

impl DescriptionError {
    pub(crate) fn new(path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { path: path.into(), problem: problem.into(), cause: Cause::Value }
    }

    pub(super) fn because(self, cause: Cause) -> Self {
        Self { cause, ..self }
    }
}

impl Description {
    /// Reads a description.
    ///
    /// # Errors
    /// What is wrong with it, without any robot.
    pub fn parse(toml: &str) -> Result<Self, DescriptionError> {
        Self::with_settings(toml, &[])
    }

    /// Reads a description with some of its numbers set to others: paths such as `motor.stroll.utility.bias`, which need not
    /// stand in the text yet. Numbers in lists cannot be set. Tables on the way are made if they are not there.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), and if a path leads through something that is no table.
    pub fn with_settings(toml: &str, settings: &[(String, f64)]) -> Result<Self, DescriptionError> {
        let toml = if settings.is_empty() { toml.to_owned() } else { edited(toml, settings)? };
        let table: Result<Table, _> = toml.parse();
        let table = table.map_err(|error| DescriptionError::new("", error.to_string().trim_end()))?;
        check_finite("", &Value::Table(table.clone()))?;
        let raw: Raw = baudbot_fields::read(table)
            .map_err(|error| DescriptionError::new(error.path, error.problem).because(error.cause))?;
        raw.check()?;
        Ok(Self { raw })
    }

    /// The summary in the description.
    pub fn summary(&self) -> &str {
        &self.raw.description
    }

    /// The kinds of its processes.
    pub fn kinds(&self) -> impl Iterator<Item = &str> {
        self.raw.motor.values().chain(self.raw.cognitive.values()).map(|process| process.kind.as_str())
    }

    /// The parameters of its motor behaviours of a kind, with their names.
    pub fn parameters_of(&self, kind: &str) -> impl Iterator<Item = (&str, &Table)> {
        let of_kind = self.raw.motor.iter().filter(move |(_, process)| process.kind == kind);
        of_kind.map(|(name, process)| (name.as_str(), &process.parameters))
    }

    /// The most frequent writing. A policy answers each message, though the cable may still be taken.
    pub fn writes(&self) -> Writes {
        if self.raw.policy.is_some() { Writes::EveryTick } else { Writes::WhenFree }
    }

    /// The brain, for a robot with this body: one of processes, or a [policy](crate::policy). `seed` chooses its random numbers.
    /// It does not notice when its world is reset, as those of the [catalogue](crate::catalogue) and of programs (feature
    /// `program`) do, which start over then.
    ///
    /// # Errors
    /// If it names sensors or kinds of processes that are not there, or parameters that these do not have, or if a policy does
    /// not fit the robot.
    pub fn any_brain(
        &self,
        seed: u64,
        body: &Body,
        registry: &Registry,
    ) -> Result<Box<dyn Brain + Send>, DescriptionError> {
        match &self.raw.policy {
            Some(policy) => Ok(Box::new(policy.policy(body)?)),
            None => Ok(Box::new(build::brain(&self.raw, seed, body, registry)?)),
        }
    }

    /// The brain as one C file, for a robot with this body: what [`any_brain`](Self::any_brain) with the standard kinds decides in turns in which a
    /// message has come and the cable is free, to the bit if the compiler fuses no operations.
    ///
    /// # Errors
    /// As [`any_brain`](Self::any_brain), and if the description has something that cannot be exported, by its path.
    pub fn c_file(&self, seed: u64, body: &Body) -> Result<String, DescriptionError> {
        export::file(&self.raw, &export::Robot { body, seed })
    }

    /// The same of a description of processes.
    ///
    /// # Errors
    /// As [`any_brain`](Self::any_brain), and if it is that of a policy.
    pub fn brain(&self, seed: u64, body: &Body, registry: &Registry) -> Result<Composed, DescriptionError> {
        if self.raw.policy.is_some() {
            return Err(DescriptionError::new("policy", "is not a brain of processes, which is needed here"));
        }
        build::brain(&self.raw, seed, body, registry)
    }
}

/// TOML knows numbers that are none.
fn check_finite(path: &str, value: &Value) -> Result<(), DescriptionError> {
    let part = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    if let Some(number) = value.as_float().filter(|number| !number.is_finite()) {
        return Err(DescriptionError::new(path, format!("must be finite, is {number}")));
    }
    let mut elements = value.as_array().into_iter().flatten().enumerate();
    elements.try_for_each(|(i, one)| check_finite(&format!("{path}[{i}]"), one))?;
    let mut fields = value.as_table().into_iter().flatten();
    fields.try_for_each(|(key, one)| check_finite(&part(key), one))
}

#[cfg(test)]
mod tests;
