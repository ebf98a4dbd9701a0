//! The errors of a log, by file, line and column.

use std::fmt;

use baudbot_fields::printable::Printable;
use thiserror::Error;

use super::names::{Dimension, Quantity};

/// A problem with a log.
#[derive(Debug, Error)]
pub struct LogError {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: Option<u64>,
    /// The place of the cell in its line, from 1, and the column's name.
    pub column: Option<(usize, String)>,
    /// The problem.
    #[source]
    pub problem: Box<Problem>,
}

impl fmt::Display for LogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = self.file.clone();
        if let Some(line) = self.line {
            text += &format!(":{line}");
        }
        if let Some((place, name)) = &self.column {
            text += &format!(":{place}");
            if !name.is_empty() {
                text += &format!(" ({name})");
            }
        }
        write!(f, "{}", Printable(format!("{text}: {}", self.problem)))
    }
}

/// The problems that logs have.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum Problem {
    #[error("cannot be read: {0}")]
    Io(std::io::Error),
    #[error("is empty; a log begins with a line of column names, such as `sent_us,received_us`")]
    Empty,
    #[error("has column names, but no rows")]
    NoRows,
    #[error(
        "the first line has no names, but numbers; put a line of column names before it, such as `distance_mm,value_v` or \
         `sent_us,received_us`"
    )]
    NoNames,
    #[error(
        "the first line has no name that is understood: {names}; columns are called `time_s`, `distance_mm`, `value_v` and the like \
         (`baudbot fit --list`), with commas, semicolons or tabs between them; --columns time_s=COLUMN gives the meaning of others"
    )]
    NothingKnown { names: String },
    #[error(
        "is a log of CARMEN, and no table; make one of its lines: FLASER has the pose and the odometer's at its end (`x_m`, `y_m`, `heading_rad`, \
         `odometer.x_m`, `odometer.y_m`, `odometer.heading_rad`, `time_s`), ODOM the odometer's alone, which has no information about its errors"
    )]
    Carmen,
    #[error(
        "is not text: byte 0x{byte:02x}; a log is a table of comma-separated values, or a recording in MCAP"
    )]
    Binary { byte: u8 },
    #[error("the line is longer than {most} bytes; this is not a table")]
    LongLine { most: usize },
    #[error("has {cells} cells, and the line of names has {columns}{}", comma_hint(*.cells, *.columns))]
    Cells { cells: usize, columns: usize },
    #[error("the quotation mark is not closed on this line")]
    Quote,
    #[error("the column has no name; name it or delete it")]
    NoName,
    #[error("is the second column of this meaning; column {first} is the first")]
    Twice { first: usize },
    #[error("names no unit; write {}", .dimension.example(*.quantity))]
    NoUnit { quantity: Quantity, dimension: Dimension },
    #[error("`{unit}` is not a known unit; write {}", .dimension.example(*.quantity))]
    UnknownUnit { unit: String, quantity: Quantity, dimension: Dimension },
    #[error("`{cell}` is not a number")]
    NotANumber { cell: String },
    #[error("`{cell}` has a decimal comma; write decimal points")]
    DecimalComma { cell: String },
    #[error("`{cell}` is not finite; leave the cell empty where nothing was measured")]
    NotFinite { cell: String },
    #[error("has no time; each row needs one")]
    NoTime,
    #[error(
        "the clock goes back by {back_s} s from line {before}; cut the log there, or give times of one clock"
    )]
    ClockBack { before: u64, back_s: f64 },
    #[error("has the time of line {before}, but other numbers; give finer times, or keep one of the rows")]
    RepeatedTime { before: u64 },
    #[error("the log has rows of several robots ({names}); choose one with --robot")]
    Robots { names: String },
    #[error("the log has no rows of the robot `{name}`; it has: {names}")]
    NoRobot { name: String, names: String },
    #[error("the log has no column `{name}`; it has: {names}")]
    NoColumn { name: String, names: String },
    #[error("`{name}` is not a name that a column can have here; {known}")]
    Target { name: String, known: String },
    #[error("the line `# {key}: {value}` must have a number of 0 or more as its value")]
    Note { key: String, value: String },
    #[error("more than {most} numbers; cut the log, or leave out columns that are not needed")]
    TooMany { most: usize },
}

/// The hint that so many cells may come from decimal commas.
fn comma_hint(cells: usize, columns: usize) -> &'static str {
    if cells >= 2 * columns - 1 && columns > 1 {
        "; if its numbers have decimal commas, write decimal points, or separate the cells by `;`"
    } else {
        ""
    }
}

/// Columns that a warning lists.
const MOST_IGNORED: usize = 12;

/// Something odd about a log that does not hinder reading.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum Warning {
    /// The clock leaps.
    Gap { line: u64, gap_s: f64, median_s: f64 },
    /// There are more gaps than are listed.
    MoreGaps { more: usize },
    /// Rows that are copies of those before them were left out.
    Copies { rows: usize, line: u64 },
    /// Columns that are not understood were left out.
    Ignored { columns: Vec<String> },
    /// Cells are empty.
    Missing { column: String, cells: usize, line: u64 },
    /// Headings that are more than a turn, as degrees are.
    Degrees { line: u64, heading: f64 },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::Gap { line, gap_s, median_s } => format!(
                "line {line}: a gap of {gap_s:.6} s, where the median period is {median_s:.6} s; the log is split there"
            ),
            Self::MoreGaps { more } => format!("{more} more gaps"),
            Self::Copies { rows, line } => {
                format!("line {line}: {rows} rows are copies of those before them and are left out")
            }
            Self::Ignored { columns } => {
                let first = columns.iter().take(MOST_IGNORED).cloned().collect::<Vec<_>>().join(", ");
                let more = columns.len().saturating_sub(MOST_IGNORED);
                let more = if more > 0 { format!(" and {more} more") } else { String::new() };
                format!("columns not understood, and not used: {first}{more}")
            }
            Self::Missing { column, cells, line } => {
                format!("line {line}: {cells} cells of `{column}` are empty and are left out")
            }
            Self::Degrees { line, heading } => format!(
                "line {line}: a heading of {heading:.4} rad is more than a turn; if these are degrees, name the column `heading_deg`"
            ),
        };
        write!(f, "{}", Printable(text))
    }
}
