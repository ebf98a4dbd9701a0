//! Overload: whether worlds that follow the wall clock keep their pace.
//!
//! A world that lags by more than its pace allows lets time go (`Timed::max_lag`). Once in a while that happens on any machine. If it
//! happens in each of some seconds, one after the other, the processors have too much to do, and one more world would harm those that
//! run. A world whose ticks alone take longer than they last lags whatever its neighbours do, and is no sign of that.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::time::Instant;

/// In which seconds worlds have let time go.
#[derive(Default)]
pub(super) struct Overload(Mutex<Streak>);

/// Seconds, one after the other, in each of which that happened.
#[derive(Clone, Copy, Default)]
struct Streak {
    /// The start of the first, and the last.
    start: Option<(Instant, u64)>,
    seconds: u64,
}

impl Overload {
    /// A world has let time go.
    pub(super) fn note(&self, now: Instant) {
        let mut streak = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        streak.note(now);
    }

    /// The number of successive seconds with an overload in each.
    pub(super) fn seconds(&self, now: Instant) -> u64 {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).seconds(now)
    }
}

impl Streak {
    fn note(&mut self, now: Instant) {
        let Some((start, last)) = self.start else {
            (self.start, self.seconds) = (Some((now, 0)), 1);
            return;
        };
        let second = now.saturating_duration_since(start).as_secs();
        match second.saturating_sub(last) {
            0 => {}
            1 => (self.start, self.seconds) = (Some((start, second)), self.seconds + 1),
            _ => (self.start, self.seconds) = (Some((now, 0)), 1),
        }
    }

    fn seconds(&self, now: Instant) -> u64 {
        let Some((start, last)) = self.start else { return 0 };
        let second = now.saturating_duration_since(start).as_secs();
        if second.saturating_sub(last) <= 1 { self.seconds } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn only_what_goes_on_is_an_overload() {
        let (overload, start) = (Overload::default(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        assert_eq!(overload.seconds(at(0)), 0);
        for ms in [0, 1, 999] {
            overload.note(at(ms));
        }
        assert_eq!(overload.seconds(at(999)), 1, "many times in a second");
        overload.note(at(1500));
        overload.note(at(2100));
        assert_eq!(overload.seconds(at(2999)), 3);
        assert_eq!(overload.seconds(at(3999)), 3, "the second is not over in which it may go on");
        assert_eq!(overload.seconds(at(4000)), 0);
        overload.note(at(5000));
        assert_eq!(overload.seconds(at(5001)), 1, "it begins anew");
    }
}
