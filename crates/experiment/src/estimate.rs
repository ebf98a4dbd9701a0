//! The expected duration, and the question whether that is meant.

use std::time::Duration;

use crate::error::Error;

/// The expected duration of a sweep or a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Runs that are missing.
    pub runs: u64,
    /// The time by the wall clock.
    pub time: Duration,
}

impl Estimate {
    /// An `Estimate` from runs that took so long, one after the other; others will be done so many at a time.
    pub(crate) fn new(missing: u64, pilots: u64, took: Duration, jobs: usize) -> Self {
        let each_s = took.as_secs_f64() / pilots.max(1) as f64;
        let seconds = each_s * missing as f64 / jobs.max(1) as f64;
        Self { runs: missing, time: Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX) }
    }

    /// Refuses long work that has not been confirmed. `at_most` stands before the number.
    pub(crate) fn refuse_long(self, at_most: &str) -> Result<(), Error> {
        if self.runs <= MOST_RUNS && self.time <= LONGEST {
            return Ok(());
        }
        Err(Error::Refused(format!(
            "{at_most}{} runs would take about {} here; confirm with --yes",
            self.runs,
            span(self.time)
        )))
    }
}

/// A time for people, no more exact than a guess.
pub fn span(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 90.0 * 60.0 => format!("{:.0} min", s / 60.0),
        s if s < 48.0 * 3600.0 => format!("{:.1} h", s / 3600.0),
        s if s < 700.0 * 86_400.0 => format!("{:.0} days", s / 86_400.0),
        s => format!("{:.0} years", s / (365.25 * 86_400.0)),
    }
}

/// More runs than these must be confirmed.
const MOST_RUNS: u64 = 10_000;
/// Work that takes longer must be confirmed.
const LONGEST: Duration = Duration::from_secs(3600);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_runs_or_an_hour_must_be_confirmed() {
        let refused = |runs, took_s| {
            let estimate = Estimate::new(runs, 2, Duration::from_secs(took_s), 4);
            estimate.refuse_long("at most ").map_err(|error| error.to_string())
        };
        assert_eq!(refused(10_000, 0), Ok(()));
        let error = refused(10_001, 2).unwrap_err();
        assert!(error.starts_with("at most 10001 runs would take about 42 min here"), "{error}");
        assert_eq!(refused(1440, 20), Ok(()));
        let error = refused(1500, 20).unwrap_err();
        assert!(error.contains("1500 runs") && error.contains("about 62 min"), "{error}");
    }
}
