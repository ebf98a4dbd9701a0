//! What happens often is told seldom.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Counts what happens, and says when it is time to tell of it.
#[derive(Default)]
pub(crate) struct Seldom(Mutex<Told>);

#[derive(Default)]
struct Told {
    last: Option<Instant>,
    since: u64,
}

impl Seldom {
    /// It has happened. How often since it was last told, if it is to be told now.
    pub(crate) fn note(&self, now: Instant) -> Option<u64> {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        told.since += 1;
        if told.last.is_some_and(|last| now.saturating_duration_since(last) < INTERVAL) {
            return None;
        }
        told.last = Some(now);
        Some(std::mem::take(&mut told.since))
    }
}

const INTERVAL: Duration = Duration::from_secs(1);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_told_once_a_second_and_how_often() {
        let (seldom, start) = (Seldom::default(), Instant::now());
        let told: Vec<_> =
            [0, 1, 999, 1000, 1500, 3000].map(|ms| seldom.note(start + Duration::from_millis(ms))).into();
        assert_eq!(told, [Some(1), None, None, Some(3), None, Some(2)]);
    }
}
