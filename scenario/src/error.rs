//! What can be wrong with a scenario.

use alloc::format;
use alloc::string::{String, ToString};

use serde::de::DeserializeOwned;

use super::MAX_BYTES;
use baudbot_sim::printable::Printable;

/// Why a scenario was refused. The message says where and how to mend it. What it quotes of the text is
/// [printable](baudbot_sim::printable).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The text is not TOML; the message has line and column.
    #[error("{0}")]
    Syntax(String),
    /// A field is missing, unknown, of the wrong type, or has a value that makes no sense.
    #[error("{path}: {problem}")]
    Field {
        /// Where, for instance `robots[2].sensors.front.range_m`.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// The text is too long to be a scenario.
    #[error("the scenario has {bytes} bytes, the limit is {MAX_BYTES}")]
    TooLong {
        /// Its length.
        bytes: u64,
    },
}

impl ScenarioError {
    pub(super) fn field(path: impl Into<String>, problem: impl Into<String>) -> Self {
        let path = Some(path.into()).filter(|path| !path.is_empty());
        let path = path.unwrap_or_else(|| "scenario".into());
        Self::Field { path: Printable(path).to_string(), problem: Printable(problem.into()).to_string() }
    }
}

/// Deserialises what stands at `prefix` of the file; errors name the full path.
pub(super) fn deserialize<T: DeserializeOwned>(prefix: &str, value: toml::Value) -> Result<T, ScenarioError> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let inner = error.path().to_string();
        let path = match (prefix, inner.as_str()) {
            (_, ".") => prefix.to_string(),
            ("", _) => inner,
            _ => format!("{prefix}.{inner}"),
        };
        ScenarioError::field(path, error.inner().message())
    })
}
