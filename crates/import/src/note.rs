//! The notes on files that are sound.

use std::fmt;

/// Something about a file that went into a scenario which the scenario's author should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Whether it is hardly what is wanted.
    pub weight: Weight,
    /// The path in the scenario, for instance `arena.maps[0].unknown`.
    pub path: String,
    /// The file, as the scenario's folder has it.
    pub file: String,
    /// The consequence, and what can be done.
    pub text: String,
}

/// The importance of a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// It is allowed, and hardly what is wanted.
    Warning,
    /// It was asked for, and shows what became of it.
    Remark,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.path, self.file, self.text)
    }
}
