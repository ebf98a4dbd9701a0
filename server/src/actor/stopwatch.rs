//! A stopwatch for wall-clock time.

use std::time::{Duration, Instant};

use crate::clock;

/// Adds up the time during which it runs.
#[derive(Default)]
pub(super) struct Stopwatch {
    since: Option<Instant>,
    sum: Duration,
}

impl Stopwatch {
    /// Lets it run, or stops it.
    pub(super) fn set(&mut self, running: bool, now: Instant) {
        match (running, self.since) {
            (true, None) => self.since = Some(now),
            (false, Some(since)) => {
                self.sum += now - since;
                self.since = None;
            }
            (true, Some(_)) | (false, None) => {}
        }
    }

    pub(super) fn elapsed(&self) -> Duration {
        self.elapsed_at(clock::now())
    }

    /// The reading at this instant.
    pub(super) fn elapsed_at(&self, now: Instant) -> Duration {
        self.sum + self.since.map_or(Duration::ZERO, |since| now.saturating_duration_since(since))
    }
}
