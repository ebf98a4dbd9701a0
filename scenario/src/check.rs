//! Rules for single values. Each takes the value with its path and gives it back if it is sound.

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;

use super::ScenarioError;

/// A place in the file, for error messages.
#[derive(Clone, Debug)]
pub(super) struct Path(String);

impl Path {
    pub(super) fn root() -> Self {
        Self(String::new())
    }

    pub(super) fn field(&self, name: &str) -> Self {
        Self(if self.0.is_empty() { name.into() } else { format!("{}.{name}", self.0) })
    }

    pub(super) fn index(&self, i: usize) -> Self {
        Self(format!("{}[{i}]", self.0))
    }

    pub(super) fn as_str(&self) -> &str {
        &self.0
    }

    pub(super) fn error(&self, problem: impl Into<String>) -> ScenarioError {
        ScenarioError::field(self.0.clone(), problem)
    }

    pub(super) fn finite(&self, field: &str, value: f64) -> Result<f64, ScenarioError> {
        self.rule(field, value, value.is_finite(), "must be a finite number")
    }

    pub(super) fn positive(&self, field: &str, value: f64) -> Result<f64, ScenarioError> {
        self.rule(field, value, value.is_finite() && value > 0.0, "must be positive")
    }

    /// A coordinate in metres: no arena is a million metres wide.
    pub(super) fn coordinate(&self, field: &str, value: f64) -> Result<f64, ScenarioError> {
        self.finite(field, value)?;
        self.within(field, value, -MAX_M, MAX_M)
    }

    /// A length in metres.
    pub(super) fn length(&self, field: &str, value: f64) -> Result<f64, ScenarioError> {
        self.positive(field, value)?;
        self.within(field, value, MIN_M, MAX_M)
    }

    /// A standard deviation.
    pub(super) fn sigma(&self, field: &str, value: f64) -> Result<f64, ScenarioError> {
        self.not_negative(field, value)?;
        self.within(field, value, 0.0, MAX_SIGMA)
    }

    pub(super) fn not_negative(&self, field: &str, value: f64) -> Result<f64, ScenarioError> {
        self.rule(field, value, value.is_finite() && value >= 0.0, "must not be negative")
    }

    pub(super) fn within(&self, field: &str, value: f64, min: f64, max: f64) -> Result<f64, ScenarioError> {
        self.rule(field, value, value >= min && value <= max, &format!("must be within {min} and {max}"))
    }

    pub(super) fn whole_within(
        &self,
        field: &str,
        value: u64,
        min: u64,
        max: u64,
    ) -> Result<u64, ScenarioError> {
        if (min..=max).contains(&value) {
            return Ok(value);
        }
        Err(self.field(field).error(format!("must be within {min} and {max}, is {value}")))
    }

    /// Milliseconds to nanoseconds.
    pub(super) fn ms(&self, field: &str, value: f64, min_ms: f64, max_ms: f64) -> Result<u64, ScenarioError> {
        Ok(to_ns(self.within(field, value, min_ms, max_ms)?, 1e6))
    }

    /// Microseconds to nanoseconds.
    pub(super) fn us(&self, field: &str, value: f64, max_us: f64) -> Result<u64, ScenarioError> {
        Ok(to_ns(self.within(field, value, 0.0, max_us)?, 1e3))
    }

    fn rule(&self, field: &str, value: f64, sound: bool, rule: &str) -> Result<f64, ScenarioError> {
        if sound { Ok(value) } else { Err(self.field(field).error(format!("{rule}, is {value}"))) }
    }
}

const MAX_M: f64 = 1e6;
const MIN_M: f64 = 1e-6;
const MAX_SIGMA: f64 = 1e3;

fn to_ns(value: f64, factor: f64) -> u64 {
    (value * factor + 0.5) as u64
}

/// Names that were given so far; they must be unique and fit into paths.
#[derive(Default)]
pub(super) struct Names(BTreeSet<String>);

impl Names {
    pub(super) fn take(&mut self, path: &Path, name: &str) -> Result<String, ScenarioError> {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if name.is_empty() || name.len() > 64 || !name.chars().all(fits) {
            let problem = format!("must be 1 to 64 letters, digits, `_` or `-`, is `{}`", shorten(name));
            return Err(path.error(problem));
        }
        if !self.0.insert(name.into()) {
            return Err(path.error(format!("`{name}` is taken; names must be unique")));
        }
        Ok(name.into())
    }
}

fn shorten(name: &str) -> String {
    name.chars().take(80).collect()
}
