//! The notes on files that are sound.

use std::fmt;

/// Something about a file that went into a scenario which the scenario's author should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Whether it is hardly what is wanted.
    pub weight: Weight,
    /// The path in the scenario, for instance `arena.maps[0].unknown`.
    pub path: String,
    /// The path of the file from the scenario's folder.
    pub file: String,
    /// The consequence, and what can be done.
    pub text: String,
}

/// The importance of a note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// The value is allowed, and hardly intended.
    Warning,
    /// The value was requested, and the note shows the result.
    Remark,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.path, self.file, self.text)
    }
}
