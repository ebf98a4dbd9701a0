//! The result of a fit: numbers with intervals, or reasons why the log does not determine them.

use std::fmt;

use baudbot_fields::printable::Printable;

use crate::search::{Best, Interval, Scale, Search, Unknown};

/// The result for one number of a fit.
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
    /// The log determines the number.
    Estimate(Estimate),
    /// The log does not determine the number.
    CannotTell(Reason),
}

impl Outcome {
    /// The same with an interval that reaches so much farther, but not below 0.
    pub(crate) fn wider(self, by: f64) -> Self {
        match self {
            Self::Estimate(one) => Self::Estimate(Estimate {
                low: (one.low - by).max(one.low.min(0.0)),
                high: one.high + by,
                ..one
            }),
            Self::CannotTell(reason) => Self::CannotTell(reason),
        }
    }
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

/// A reason why a log does not determine a number.
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
    /// The values reach the end of what is tried.
    AtEnd { low: f64, high: f64 },
    /// Another number can make up for it.
    Confounded { with: String },
    /// No frames of a bus show in the echoes.
    NoFrames { what: String },
    /// Stamps are too coarse.
    Coarse { step_us: f64, frame_us: f64 },
    /// The model does not describe what happened.
    Misfit { what: String },
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
            Self::AtEnd { low, high } => format!(
                "its interval, {} to {}, reaches the end of the range that was tried",
                significant(*low),
                significant(*high)
            ),
            Self::Confounded { with } => {
                format!("confounded with {with}, which can compensate for it in this log")
            }
            Self::NoFrames { what } => format!("no frames of the bus are found in this log: {what}"),
            Self::Coarse { step_us, frame_us } => format!(
                "all times are multiples of {} us, and a frame has {} us; log finer times",
                significant(*step_us),
                significant(*frame_us)
            ),
            Self::Misfit { what } => format!("the log does not fit the model: {what}"),
        };
        write!(f, "{}", Printable(text))
    }
}

/// A remark on a fit.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "the messages say it")]
pub enum Remark {
    /// The baud rate is that of the scenario.
    Baud { baud: f64 },
    /// All times are multiples of this.
    Stamps { step_us: f64 },
    /// The phase of the frames leaps.
    Leap { line: u64, leap_us: f64 },
    /// There are more leaps than are listed.
    MoreLeaps { more: usize },
    /// The phase of the frames wanders about its line.
    Wanders { by_us: f64 },
    /// Echoes that nothing explains.
    Strays { echoes: usize, of: usize },
    /// The jitter behind the boundaries is not uniform.
    Shape,
    /// The scenario's value of one of two numbers that make up for each other.
    Kept { field: &'static str, value: f64, tells: &'static str },
    /// A difference remains between log and model.
    Rest { of: &'static str, rms: f64, unit: &'static str, explained: f64 },
    /// The curve of a sensor in the log, which may differ from that of the scenario.
    Curve { sensor: String, points: Vec<[f64; 2]> },
    /// The two motions ask for different lags.
    Lags { ahead_ms: f64, turning_ms: f64 },
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::Baud { baud } => format!("no line `# baud: ...`; assumed to be {baud}, as in the scenario"),
            Self::Stamps { step_us } => format!("all times are multiples of {} us", significant(*step_us)),
            Self::Leap { line, leap_us } => format!(
                "line {line}: the phase of the frames leaps by {} us, as if a clock was set; each side has a phase of its own",
                significant(*leap_us)
            ),
            Self::MoreLeaps { more } => format!("{more} more leaps of the frames' phase"),
            Self::Wanders { by_us } => {
                format!("the phase of the frames wanders by {} us, and is followed", significant(*by_us))
            }
            Self::Strays { echoes, of } => format!("{echoes} of {of} echoes come at no boundary, and are left out"),
            Self::Shape => "the jitter is not uniform: `jitter_us` has the same scatter, and its interval is from twice the \
                            distance of the quartiles to the range of 99 %"
                .to_owned(),
            Self::Kept { field, value, tells } => {
                format!("`{field}` and `{tells}` compensate for each other; `{tells}` is estimated for `{field}` = {value}, as in the scenario")
            }
            Self::Rest { of, rms, unit, explained } => format!(
                "{of}: the residual is {} {unit} (RMS); the model explains {} % of the variance",
                digits(*rms, 3),
                digits(100.0 * explained, 4)
            ),
            Self::Curve { sensor, points } => {
                let point = |[x, y]: &[f64; 2]| format!("[{}, {}]", digits(*x, 4), digits(*y, 4));
                let points: Vec<_> = points.iter().map(point).collect();
                format!(
                    "the medians of this log are sensors.{sensor}.curve_m_v = [{}]; the noise is that about these",
                    points.join(", ")
                )
            }
            Self::Lags { ahead_ms, turning_ms } => format!(
                "the motion ahead asks for a lag of {} ms, and turning for {} ms, by the scenario's mass and inertia; one number is between them",
                digits(*ahead_ms, 3),
                digits(*turning_ms, 3)
            ),
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
    /// The name of the differences.
    pub title: String,
    /// The quantity along x, with its unit.
    pub x: String,
    /// The unit of the differences.
    pub unit: String,
    /// Places along x, and differences.
    pub points: Vec<(f64, f64)>,
}

/// The results of a model for a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fitted {
    /// The numbers, in the order of the fields.
    pub findings: Vec<Finding>,
    /// The differences that are left.
    pub residuals: Vec<Residuals>,
    /// The remarks on it.
    pub remarks: Vec<Remark>,
}

impl Fitted {
    /// Findings, and nothing else.
    pub(crate) fn only(findings: Vec<Finding>) -> Self {
        Self { findings, ..Self::default() }
    }
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
        Scale::Linear => reaches_end(&interval, unknown) || interval.share(unknown) > MOST_SHARE,
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
        Some(_) | None if unknown.scale == Scale::Linear && interval.share(unknown) <= MOST_SHARE => {
            Reason::AtEnd { low, high }
        }
        Some(_) | None => Reason::Flat { low, high },
    }
}

/// Whether an interval reaches an end that is none of the number itself: nothing is less than 0.
fn reaches_end(interval: &Interval, unknown: &Unknown) -> bool {
    interval.open_high || (interval.open_low && unknown.from != 0.0)
}

/// An interval that is wider than this fraction of the range that is tried is no result.
const MOST_SHARE: f64 = 0.5;

/// The same if its ends are so many times apart, of a number that cannot be 0.
const MOST_RATIO: f64 = 5.0;

/// A number searched by its logarithm that is less than so many times the least that is tried is 0.
const FLOOR: f64 = 3.0;
