//! The messages while an experiment runs, a line of text each.

use std::fmt;

/// A message that a person may want to have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Told {
    /// Something that is as it should be.
    Note(String),
    /// Something that may be wrong.
    Warning(String),
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Note(text) => write!(f, "note: {text}"),
            Self::Warning(text) => write!(f, "warning: {text}"),
        }
    }
}
