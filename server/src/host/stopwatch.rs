//! Adds up wall-clock time.

use std::time::{Duration, Instant};

/// Adds up the time during which something is so.
#[derive(Default)]
pub(super) struct Stopwatch {
    since: Option<Instant>,
    sum: Duration,
}

impl Stopwatch {
    pub(super) fn set(&mut self, running: bool, now: Instant) {
        match (running, self.since) {
            (true, None) => self.since = Some(now),
            (false, Some(since)) => {
                self.sum += now - since;
                self.since = None;
            }
            _ => {}
        }
    }

    pub(super) fn elapsed(&self) -> Duration {
        self.sum + self.since.map_or(Duration::ZERO, |since| since.elapsed())
    }
}
