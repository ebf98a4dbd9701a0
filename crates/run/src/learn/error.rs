//! The errors of a task, an action or a reward.

use baudbot_brains::catalogue::CatalogueError;
use baudbot_import::source::SourceError;
use baudbot_scenario::ScenarioError;

use crate::assignment::AssignmentError;

/// A reason why an environment cannot be made, or cannot meet a request, on one line.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// The scenario cannot be read.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The scenario is invalid.
    #[error("{label}: {error}")]
    Scenario {
        /// The name that the scenario was asked for by.
        label: String,
        /// The error, with the path of its field.
        error: ScenarioError,
    },
    /// A brain does not fit its robot.
    #[error(transparent)]
    Assignment(#[from] AssignmentError),
    /// There is no such brain.
    #[error(transparent)]
    Brain(#[from] CatalogueError),
    /// An option, an action or a reward is wrong.
    #[error("{path}: {problem}")]
    Value {
        /// The path, such as `action[3]` or `reward.distance_m`.
        path: String,
        /// The problem, and what would be right.
        problem: String,
    },
}

impl LearnError {
    pub(crate) fn value(path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Value { path: path.into(), problem: problem.into() }
    }

    /// The path of the field that is wrong, if it is one.
    pub fn path(&self) -> Option<String> {
        match self {
            Self::Value { path, .. } => Some(path.clone()),
            Self::Scenario { error: ScenarioError::Field { path, .. }, .. } => Some(path.clone()),
            Self::Scenario { .. } | Self::Source(_) | Self::Assignment(_) | Self::Brain(_) => None,
        }
    }
}
