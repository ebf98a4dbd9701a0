//! What a fit finds: numbers with intervals, or why the log cannot tell them.

use std::fmt;

use baudbot_fields::printable::Printable;

use crate::search::{Best, Interval, Scale, Search};

/// What is known of one number after a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The field, as a path below the robot: `link.adapter.jitter_us`. What is no field has a space in its name.
    pub path: String,
    /// Whether it is a field of a scenario; otherwise it is a number that is known besides.
    pub is_field: bool,
    /// The number, or why there is none.
    pub outcome: Outcome,
}

/// A number, or why there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The log tells it.
    Estimate(Estimate),
    /// It does not.
    CannotTell(Reason),
}

/// A number with its interval, in the unit of its field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The most likely value.
    pub value: f64,
    /// The ends of the 95 % interval.
    pub low: f64,
    /// See `low`.
    pub high: f64,
    /// Whether it is a whole number.
    pub whole: bool,
}

/// Why a log cannot tell a number.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum Reason {
    /// Columns that are needed.
    Columns { needs: String },
    /// Rows that can be used.
    TooFew { what: String, rows: usize, least: usize },
    /// A spread needs several specimens.
    Specimens { there_are: usize },
    /// Nothing happens that it would show in.
    Excitation { what: String },
    /// All values from one to the other explain the log about as well.
    Flat { low: f64, high: f64 },
    /// Another number can make up for it.
    Confounded { with: String },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::Columns { needs } => format!("the log has no {needs}"),
            Self::TooFew { what, rows, least } => format!("the log has {rows} {what}; {least} are needed"),
            Self::Specimens { there_are } => format!(
                "a spread over specimens needs at least 3 of them (a column `specimen` or `sensor`); the log has {there_are}"
            ),
            Self::Excitation { what } => what.clone(),
            Self::Flat { low, high } => format!(
                "all values from {} to {} explain the log about equally well",
                significant(*low),
                significant(*high)
            ),
            Self::Confounded { with } => {
                format!("confounded with {with}, which can make up for it in this log")
            }
        };
        write!(f, "{}", Printable(text))
    }
}

/// A number with four significant digits.
pub fn significant(number: f64) -> String {
    digits(number, 4)
}

/// A number with so many significant digits, without needless zeros.
pub fn digits(number: f64, digits: usize) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    let text = format!("{number:.*e}", digits.saturating_sub(1));
    let rounded: f64 = text.parse().unwrap_or(number);
    let magnitude = rounded.abs().log10().floor();
    if (-5.0..9.0).contains(&magnitude) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Differences between a log and the numbers that were fitted to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Residuals {
    /// What they are differences of.
    pub title: String,
    /// The quantity along x, with its unit.
    pub x: String,
    /// The unit of the differences.
    pub unit: String,
    /// Places along x, and differences.
    pub points: Vec<(f64, f64)>,
}

/// What a model found in a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fitted {
    /// The numbers, in the order of the fields.
    pub findings: Vec<Finding>,
    /// The differences that are left.
    pub residuals: Vec<Residuals>,
}

/// The finding of one number of a search; `names` are those of all its numbers, and `unit` is how much of the number's
/// unit in the search the unit of the field is.
pub(crate) fn found(
    search: &Search<'_>,
    best: &mut Best,
    (i, names): (usize, &[String]),
    unit: f64,
) -> Outcome {
    let interval = search.interval(best, i);
    let unknown = &search.unknowns[i];
    let lost = match unknown.scale {
        Scale::Linear => (interval.open_low && interval.open_high) || interval.share(unknown) > MOST_SHARE,
        Scale::Log => interval.open_high,
        Scale::Positive => {
            interval.open_low || interval.open_high || interval.high > MOST_RATIO * interval.low
        }
    };
    if lost {
        return Outcome::CannotTell(lost_by(search, &interval, (i, names), unit));
    }
    let zero = interval.open_low && unknown.scale == Scale::Log;
    let (low, high) = (if zero { 0.0 } else { interval.low }, interval.high);
    let value = best.values[i];
    let value = if zero && value < FLOOR * unknown.from { 0.0 } else { value };
    Outcome::Estimate(Estimate { value: value / unit, low: low / unit, high: high / unit, whole: false })
}

fn lost_by(search: &Search<'_>, interval: &Interval, (i, names): (usize, &[String]), unit: f64) -> Reason {
    let unknown = &search.unknowns[i];
    let (low, high) = (interval.low / unit, interval.high / unit);
    match interval.partner {
        Some((partner, moved)) if moved > 0.3 * interval.share(unknown).max(0.1) && partner < names.len() => {
            Reason::Confounded { with: names[partner].clone() }
        }
        Some(_) | None => Reason::Flat { low, high },
    }
}

/// An interval that is wider than this share of what is tried tells nothing.
const MOST_SHARE: f64 = 0.5;

/// The same if its ends are so many times apart, of a number that cannot be 0.
const MOST_RATIO: f64 = 5.0;

/// A number searched by its logarithm that is less than so many times the least that is tried is 0.
const FLOOR: f64 = 3.0;
