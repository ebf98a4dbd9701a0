//! Logs of robots: tables of comma-separated values whose columns have their unit in their name.
//!
//! A log that was read is sound: its cells are numbers, in SI units; its instants increase; a row of which there was a copy
//! is there once. Where the log pauses, its [segments](Log::segments) end.
//!
//! ```text
//! # experiment: echo
//! # baud: 115200
//! sent_us,received_us
//! 12.5,936.0
//! ```

mod cells;
mod error;
mod names;
mod read;
mod times;

use std::ops::Range;

pub use error::{LogError, Problem, Warning};
pub use names::{Dimension, Name, Quantity, Unit};
pub use read::{Options, read};

/// A table of measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// The name of the file, for messages.
    pub file: String,
    /// The lines `# key: value`, in their order.
    pub notes: Vec<Note>,
    /// The columns of numbers that were kept.
    pub columns: Vec<Column>,
    /// The sensor or specimen of each row (a column `sensor` or `specimen`).
    pub labels: Option<Labels>,
    /// The line of each row in the file.
    pub lines: Vec<u64>,
    /// Rows between which the clock makes no leap: more than [`GAP`] times the median period. One if there are no times.
    pub segments: Vec<Range<usize>>,
    /// Oddities of the log that are no errors.
    pub warnings: Vec<Warning>,
}

/// A period that is so many times the median one is a gap.
pub const GAP: f64 = 5.0;

/// A line `# key: value`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The line in the file.
    pub line: u64,
    /// The key, in lower case.
    pub key: String,
    /// The value, without blanks around it.
    pub value: String,
}

/// A column of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The meaning of the numbers.
    pub name: Name,
    /// The name of the column in the file.
    pub header: String,
    /// The place of the column in the file, from 1.
    pub place: usize,
    /// The numbers in SI units, by row; NaN where a cell is empty.
    pub values: Vec<f64>,
}

/// A column of words that label the rows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Labels {
    /// The different words, in the order in which they appear.
    pub words: Vec<String>,
    /// The word of each row.
    pub of_rows: Vec<usize>,
}

impl Log {
    /// The column of a quantity.
    pub fn column(&self, quantity: Quantity) -> Option<&Column> {
        self.columns.iter().find(|column| matches!(column.name, Name::Of(of, _) if of == quantity))
    }

    /// The column of a sensor's readings, such as `compass` or `odometer.x_m`, in the unit that its name in a scenario has.
    pub fn reading(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| matches!(&column.name, Name::Reading(of) if of == name))
    }

    /// The number of a line `# key: number`, if there is one.
    ///
    /// # Errors
    /// If its value is no finite number of 0 or more.
    pub fn note(&self, key: &str) -> Result<Option<f64>, LogError> {
        let Some(note) = self.notes.iter().rev().find(|note| note.key == key) else { return Ok(None) };
        let number = note.value.parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        number.map(Some).ok_or_else(|| {
            let problem = Problem::Note { key: key.to_owned(), value: note.value.clone() };
            LogError { file: self.file.clone(), line: Some(note.line), column: None, problem: problem.into() }
        })
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// The error that this is wrong with the log as a whole.
    pub fn error(&self, problem: Problem) -> LogError {
        LogError { file: self.file.clone(), line: None, column: None, problem: problem.into() }
    }
}

#[cfg(test)]
mod tests;
