//! Errors in the files that a scenario refers to.

use std::path::Path;

/// A reason why a scenario could not be completed. The message has the place, the problem and the remedy, on one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// A field that refers to a file, or one beside it, is missing, unknown, of the wrong type, or has a value that is
    /// invalid.
    #[error("{path}: {problem}")]
    Field {
        /// The path in the scenario, for instance `arena.maps[0].m_per_unit`.
        path: String,
        /// The problem.
        problem: String,
    },
    /// A file cannot be read, or what is in it is invalid.
    #[error("{path}: {file}: {problem}")]
    File {
        /// The path in the scenario, for instance `arena.maps[0].ros`.
        path: String,
        /// The file. It is not always the one that the scenario names: a map has an image.
        file: String,
        /// The problem.
        problem: String,
    },
}

impl ImportError {
    pub(crate) fn field(path: impl Into<String>, problem: impl ToString) -> Self {
        Self::Field { path: path.into(), problem: problem.to_string() }
    }
}

/// An error in a file, whichever scenario refers to it.
#[derive(Debug)]
pub(crate) struct FileError {
    file: String,
    problem: String,
}

impl FileError {
    pub(crate) fn new(file: &Path, problem: impl ToString) -> Self {
        Self { file: file.display().to_string(), problem: one_line(&problem.to_string()) }
    }

    /// The error, once it is known which field refers to the file.
    pub(crate) fn at(self, path: impl Into<String>) -> ImportError {
        ImportError::File { path: path.into(), file: self.file, problem: self.problem }
    }
}

/// The messages of other crates go over several lines at times.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
