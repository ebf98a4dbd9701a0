//! Values on the command line: parsers of numbers, and the errors of values that an option cannot have.

use std::fmt::{self, Display, Formatter};
use std::ops::RangeInclusive;
use std::time::Duration;

use crate::escapes::EscapeError;

/// A reason why a value does not fit its option. clap, or an [`OptionError`], names the option before it.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum ValueError {
    /// The value has another form, which is described.
    #[error("{0}")]
    Form(&'static str),
    /// The value has another form, and is shown.
    #[error("must be {form}, is `{text}`")]
    Text { form: &'static str, text: String },
    /// The value has another form than an example, and is shown.
    #[error("must be {form}; is `{text}`")]
    Example { form: &'static str, text: String },
    /// A number that is too small or too large.
    #[error("must be {bounds}, is {text}")]
    Number { bounds: Bounds, text: String },
    /// The factor of a pace.
    #[error("the factor must be a positive number, is `{0}`")]
    Factor(String),
    /// Bytes with an escape that is none.
    #[error(transparent)]
    Escape(#[from] EscapeError),
}

/// The numbers that an option takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Bounds {
    Between(f64, f64),
    /// Zero is not among them.
    Above0,
    /// Zero is not among them, and nothing above this.
    Above0AtMost(f64),
    AtLeast0,
    Whole(i128, i128),
}

impl Display for Bounds {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Between(least, most) => write!(f, "from {least} to {most}"),
            Self::Above0 => f.write_str("above 0"),
            Self::Above0AtMost(most) => write!(f, "above 0 and at most {most}"),
            Self::AtLeast0 => f.write_str("0 or more"),
            // Nobody counts so far: the upper bound is that of the machine.
            Self::Whole(least, most) if *most == i128::from(u64::MAX) => write!(f, "{least} or more"),
            Self::Whole(least, most) => write!(f, "from {least} to {most}"),
        }
    }
}

impl Bounds {
    fn has(self, number: f64) -> bool {
        match self {
            Self::Between(least, most) => (least..=most).contains(&number),
            Self::Above0 => number > 0.0,
            Self::Above0AtMost(most) => number > 0.0 && number <= most,
            Self::AtLeast0 => number >= 0.0,
            Self::Whole(least, most) => (least as f64..=most as f64).contains(&number),
        }
    }

    /// The number, if it is within these bounds.
    pub(super) fn checked(self, number: f64) -> Result<f64, ValueError> {
        let error = || ValueError::Number { bounds: self, text: number.to_string() };
        if self.has(number) { Ok(number) } else { Err(error()) }
    }

    /// Parses a number within these bounds.
    pub(super) fn parsed(self, text: &str) -> Result<f64, ValueError> {
        let error = || ValueError::Number { bounds: self, text: text.to_owned() };
        finite(text).ok().filter(|number| self.has(*number)).ok_or_else(error)
    }
}

/// A value that an option cannot have, with the option's name.
#[derive(Debug, thiserror::Error)]
#[error("{option}: {error}")]
pub(crate) struct OptionError {
    pub(super) option: &'static str,
    pub(super) error: ValueError,
}

/// A parser of whole numbers. clap's own has the words of Rust in its errors.
pub(super) fn whole<T>(
    range: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, ValueError> + Clone + Send + Sync + 'static
where
    T: Copy + Into<i128> + TryFrom<i128> + Send + Sync + 'static,
{
    let (least, most) = ((*range.start()).into(), (*range.end()).into());
    move |text| {
        let number: i128 = text.parse().map_err(|_| ValueError::Form("must be a whole number"))?;
        let fits = (least..=most).contains(&number);
        let error = || ValueError::Number { bounds: Bounds::Whole(least, most), text: number.to_string() };
        T::try_from(number).ok().filter(|_| fits).ok_or_else(error)
    }
}

/// A number, and neither infinite nor none.
pub(super) fn finite(text: &str) -> Result<f64, ValueError> {
    let number: Option<f64> = text.parse().ok().filter(|number| f64::is_finite(*number));
    number.ok_or(ValueError::Form("must be a number"))
}

/// Seconds since the start of a run.
pub(super) fn instant(text: &str) -> Result<f64, ValueError> {
    Bounds::Between(0.0, MOST_S).parsed(text)
}

/// The time for which somebody waits.
pub(super) fn patience(text: &str) -> Result<f64, ValueError> {
    Bounds::Above0AtMost(MOST_S).parsed(text)
}

/// A time by the wall clock: a number of seconds, or with `s`, `m` or `h`.
pub(super) fn wall_time(text: &str) -> Result<Duration, ValueError> {
    let text = text.trim();
    let (number, unit_s) = match text.strip_suffix(['s', 'm', 'h']) {
        Some(number) if text.ends_with('m') => (number, 60.0),
        Some(number) if text.ends_with('h') => (number, 3600.0),
        Some(number) => (number, 1.0),
        None => (text, 1.0),
    };
    Ok(Duration::from_secs_f64(Bounds::Above0AtMost(MOST_S).parsed(number)? * unit_s))
}

/// Milliseconds of a run.
pub(super) fn span(text: &str) -> Result<f64, ValueError> {
    Bounds::Above0AtMost(MOST_MS).parsed(text)
}

/// Longer than any run that is waited for.
const MOST_S: f64 = 1e6;

/// More than anybody sees in one picture.
const MOST_MS: f64 = 1e6;
