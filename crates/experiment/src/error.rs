//! Errors in an experiment, and failures of a sweep.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use baudbot_fields::printable::Printable;

/// A reason why there is no experiment, or no end of a sweep. The message has the place and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is not TOML; the message has line and column.
    #[error("{0}")]
    Syntax(String),
    /// A field of the experiment is missing, unknown, or has an invalid value.
    #[error("{path}: {problem}")]
    Field {
        /// The path, for instance `fields[1].values`.
        path: String,
        /// The problem.
        problem: String,
    },
    /// The request cannot be met as it stands.
    #[error("{0}")]
    Refused(String),
    /// A file could not be read or written. What is in the journal is kept.
    #[error("cannot {doing} {}: {cause}", path.display())]
    File {
        /// `read`, `write` or the like.
        doing: &'static str,
        /// The path of the file.
        path: PathBuf,
        /// The system's message.
        cause: io::Error,
    },
    /// A server could not be reached, or did not do as it should. What is in the journal is kept.
    #[error("{0}")]
    Server(String),
}

impl Error {
    /// The path of the field that is wrong, if it is one.
    pub fn path(&self) -> Option<String> {
        match self {
            Self::Field { path, .. } => Some(path.clone()),
            Self::Syntax(_) | Self::Refused(_) | Self::File { .. } | Self::Server(_) => None,
        }
    }

    /// A field at this path is wrong.
    pub fn field(path: impl fmt::Display, problem: impl fmt::Display) -> Self {
        Self::Field { path: Printable(path).to_string(), problem: Printable(problem).to_string() }
    }

    pub(crate) fn file(doing: &'static str, path: &Path) -> impl Fn(io::Error) -> Self {
        move |cause| Self::File { doing, path: path.to_owned(), cause }
    }

    /// Whether the experiment or the command must be changed; else something went wrong on the way.
    pub fn is_refusal(&self) -> bool {
        matches!(self, Self::Syntax(_) | Self::Field { .. } | Self::Refused(_))
    }
}
