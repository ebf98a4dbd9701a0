//! Numbers on the command line.

/// A number, and neither infinite nor none.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|number| f64::is_finite(*number)).ok_or_else(|| "must be a number".to_owned())
}

/// Seconds since the start of a run.
pub(super) fn instant(text: &str) -> Result<f64, String> {
    let fits = |at_s: &f64| (0.0..=MOST_S).contains(at_s);
    finite(text).ok().filter(fits).ok_or_else(|| format!("must be from 0 to {MOST_S}, is {text}"))
}

/// For how long somebody waits.
pub(super) fn patience(text: &str) -> Result<f64, String> {
    let fits = |s: &f64| *s > 0.0 && *s <= MOST_S;
    finite(text).ok().filter(fits).ok_or_else(|| format!("must be above 0 and at most {MOST_S}, is {text}"))
}

/// Milliseconds of a run.
pub(super) fn span(text: &str) -> Result<f64, String> {
    let fits = |ms: &f64| *ms > 0.0 && *ms <= MOST_MS;
    finite(text).ok().filter(fits).ok_or_else(|| format!("must be above 0 and at most {MOST_MS}, is {text}"))
}

/// Longer than any run that is waited for.
const MOST_S: f64 = 1e6;

/// More than anybody sees in one picture.
const MOST_MS: f64 = 1e6;
