//! Events for the operator's log.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The default interval of an event in the log that a [`Throttle`] limits.
const INTERVAL: Duration = Duration::from_secs(1);

/// Logs an event of a world: `event!(this, info, field = value, "text")`. Each has the name of the world, and its
/// simulated time. `this` has a `name` and a `world`. Nothing is computed if it is not logged.
macro_rules! event {
    ($this:expr, $level:ident, $($rest:tt)+) => {
        tracing::$level!(
            world = &*$this.name,
            tick = $this.world.tick(),
            time_s = $this.world.time().as_seconds(),
            $($rest)+
        )
    };
}

pub(crate) use event;

/// Counts what happens often, so that it is logged seldom.
pub(crate) struct Throttle {
    interval: Duration,
    count: Mutex<Count>,
}

impl Default for Throttle {
    fn default() -> Self {
        Self::each(INTERVAL)
    }
}

#[derive(Default)]
struct Count {
    logged: Option<Instant>,
    since: u64,
}

impl Throttle {
    /// One that logs once in this time, at most.
    pub(crate) fn each(interval: Duration) -> Self {
        Self { interval, count: Mutex::default() }
    }

    /// Counts an event. If it is to be logged now: how often it has happened since it was last logged.
    pub(crate) fn note(&self, now: Instant) -> Option<u64> {
        let mut count = self.count.lock().unwrap_or_else(PoisonError::into_inner);
        count.since += 1;
        if count.logged.is_some_and(|logged| now.saturating_duration_since(logged) < self.interval) {
            return None;
        }
        count.logged = Some(now);
        Some(std::mem::take(&mut count.since))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_logged_once_a_second_with_how_often_it_happened() {
        let (throttle, start) = (Throttle::default(), Instant::now());
        let logged: Vec<_> =
            [0, 1, 999, 1000, 1500, 3000].map(|ms| throttle.note(start + Duration::from_millis(ms))).into();
        assert_eq!(logged, [Some(1), None, None, Some(3), None, Some(2)]);
    }
}
