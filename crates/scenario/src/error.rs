//! Errors in a scenario.

use alloc::format;
use alloc::string::{String, ToString};

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use baudbot_fields::{Cause, FieldError, Fields, Path};

use super::MAX_BYTES;

/// The reason why a scenario was refused. The message has the place and the remedy. Its quotations of the text are
/// [printable](baudbot_fields::printable).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The text is not TOML; the message has line and column.
    #[error("{0}")]
    Syntax(String),
    /// A field is missing, unknown, of the wrong type, or has an invalid value.
    #[error("{path}: {problem}")]
    Field {
        /// The path, for instance `robots[2].sensors.front.range_m`.
        path: String,
        /// The problem.
        problem: String,
        /// The kind of problem.
        cause: Cause,
    },
    /// The text is too long to be a scenario.
    #[error("the scenario has {bytes} bytes, the limit is {MAX_BYTES}")]
    TooLong {
        /// The length of the text.
        bytes: u64,
    },
}

impl From<FieldError> for ScenarioError {
    fn from(FieldError { path, problem, cause }: FieldError) -> Self {
        Self::Field { path, problem, cause }
    }
}

/// The table of a file in TOML.
pub(super) struct Sheet(Value);

impl From<Value> for Sheet {
    fn from(value: Value) -> Self {
        Self(value)
    }
}

impl From<Table> for Sheet {
    fn from(table: Table) -> Self {
        Self(Value::Table(table))
    }
}

impl Fields for Sheet {
    fn read<T: DeserializeOwned>(self, path: &Path) -> Result<T, FieldError> {
        baudbot_fields::read(self.0).map_err(|error| {
            let path = match (path.as_str(), error.path.as_str()) {
                (here, "") => here.to_string(),
                ("", _) => error.path,
                (here, _) => format!("{here}.{}", error.path),
            };
            FieldError::new(path, error.problem).because(error.cause)
        })
    }
}
