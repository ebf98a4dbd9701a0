//! Parameters of brains and processes: as data, for command lines and help, and what can be wrong with them.

use std::fmt::Display;
use std::ops::RangeInclusive;

use baudbot_fields::{Cause, Misread};
use thiserror::Error;

/// One parameter of a brain whose parameters are a `P`.
pub(crate) struct Parameter<P> {
    pub(crate) name: &'static str,
    /// The meaning of the parameter, with its unit.
    pub(crate) meaning: &'static str,
    /// The values that make sense.
    pub(crate) range: RangeInclusive<f64>,
    pub(crate) field: fn(&mut P) -> &mut f64,
}

/// A length for a body of this radius, in metres, that is so many metres for one of 0.4 m: the default of what follows the body.
pub(crate) fn for_body(length_m: f64, radius_m: f64) -> f64 {
    length_m * (radius_m / 0.2)
}

/// Motor signals. 1 is full voltage; some motors take more, and then nothing limits them.
pub(crate) const SIGNAL: RangeInclusive<f64> = -10.0..=10.0;

/// Probabilities, and other parts of a whole.
pub(crate) const PROBABILITY: RangeInclusive<f64> = 0.0..=1.0;

/// A reason why parameters are invalid, or not for this robot.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ParameterError {
    /// A number that the parameter cannot be.
    #[error("{parameter}: must be {allowed}, is {found}")]
    Range {
        /// The parameter.
        parameter: String,
        /// The permitted values.
        allowed: String,
        /// The number given.
        found: f64,
    },
    /// Another invalid value.
    #[error("{parameter}: {problem}")]
    Value {
        /// The parameter.
        parameter: String,
        /// The problem, or the remedy.
        problem: String,
    },
    /// The parameters cannot be read.
    #[error(transparent)]
    Misread(#[from] Misread),
    /// The parameters cannot be used, or the robot has not what they ask for.
    #[error("{0}")]
    Other(String),
}

impl ParameterError {
    pub(crate) fn range(parameter: impl Display, allowed: impl Display, found: f64) -> Self {
        Self::Range { parameter: parameter.to_string(), allowed: allowed.to_string(), found }
    }

    /// The kind of problem.
    pub(crate) fn cause(&self) -> Cause {
        match self {
            Self::Misread(misread) => misread.cause.clone(),
            Self::Range { .. } | Self::Value { .. } | Self::Other(_) => Cause::Value,
        }
    }

    pub(crate) fn value(parameter: impl Display, problem: impl Display) -> Self {
        Self::Value { parameter: parameter.to_string(), problem: problem.to_string() }
    }
}

/// All of these numbers must be finite and above 0.
pub(crate) fn check_positive<N: Display>(
    named: impl IntoIterator<Item = (N, f64)>,
) -> Result<(), ParameterError> {
    let mut named = named.into_iter();
    let wrong = named.find(|(_, value)| !(value.is_finite() && *value > 0.0));
    wrong.map_or(Ok(()), |(name, value)| Err(ParameterError::range(name, "positive", value)))
}

/// All of these numbers must be finite and 0 or above.
pub(crate) fn check_not_negative<N: Display>(
    named: impl IntoIterator<Item = (N, f64)>,
) -> Result<(), ParameterError> {
    let mut named = named.into_iter();
    let wrong = named.find(|(_, value)| !(value.is_finite() && *value >= 0.0));
    wrong.map_or(Ok(()), |(name, value)| {
        Err(ParameterError::Value {
            parameter: name.to_string(),
            problem: format!("must not be negative, is {value}"),
        })
    })
}
