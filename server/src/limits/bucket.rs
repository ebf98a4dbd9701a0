//! A token bucket: how often something may happen.
//!
//! In place of a count it keeps the instant at which the bucket is full again (the generic cell rate algorithm): each event moves that
//! by the time that one event is worth, and may not move it farther ahead than a full bucket is worth.

use std::time::{Duration, Instant};

/// Events so far, as the instant from which on there were none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bucket {
    full_at: Option<Instant>,
}

impl Bucket {
    /// Takes an event out of a bucket of `burst` that gets `per_s` a second.
    ///
    /// # Errors
    /// How long it takes until there is one.
    pub(super) fn take(&mut self, now: Instant, per_s: u32, burst: u32) -> Result<(), Duration> {
        let one = Duration::from_secs(1) / per_s.max(1);
        let full_at = self.full_at.map_or(now, |at| at.max(now)) + one;
        let ahead = full_at - now;
        match ahead.checked_sub(one.saturating_mul(burst.max(1))) {
            Some(wait) if !wait.is_zero() => Err(wait),
            Some(_) | None => {
                self.full_at = Some(full_at);
                Ok(())
            }
        }
    }

    /// Takes so many events at once, whether they are there or not: later ones wait for longer.
    pub(super) fn charge(&mut self, now: Instant, per_s: u32, events: u32) {
        let one = Duration::from_secs(1) / per_s.max(1);
        self.full_at = Some(self.full_at.map_or(now, |at| at.max(now)) + one.saturating_mul(events));
    }

    /// Whether there is an event to be taken.
    pub(super) fn has_one(&self, now: Instant, per_s: u32, burst: u32) -> bool {
        let mut copy = *self;
        copy.take(now, per_s, burst).is_ok()
    }

    /// Whether it is as if nothing had ever been taken.
    pub(super) fn is_full(&self, now: Instant) -> bool {
        self.full_at.is_none_or(|at| at <= now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_goes_through_and_then_so_many_a_second() {
        let (mut bucket, start) = (Bucket::default(), Instant::now());
        let ms = |ms| start + Duration::from_millis(ms);
        assert_eq!((0..30).filter(|_| bucket.take(start, 10, 20).is_ok()).count(), 20);
        assert_eq!(bucket.take(start, 10, 20), Err(Duration::from_millis(100)));
        assert_eq!(
            bucket.take(ms(40), 10, 20),
            Err(Duration::from_millis(60)),
            "what was refused takes nothing"
        );
        assert_eq!(bucket.take(ms(100), 10, 20), Ok(()));
        assert!(bucket.take(ms(100), 10, 20).is_err());
        let in_a_second = (100..1100).filter(|&at| bucket.take(ms(at), 10, 20).is_ok()).count();
        assert_eq!(in_a_second, 9);
        assert!(!bucket.is_full(ms(2000)) && bucket.is_full(ms(4000)));
    }

    #[test]
    fn what_is_charged_afterwards_is_waited_for() {
        let (mut bucket, start) = (Bucket::default(), Instant::now());
        bucket.charge(start, 10, 35);
        assert!(!bucket.has_one(start, 10, 20), "35 are more than 20");
        assert_eq!(bucket.take(start, 10, 20), Err(Duration::from_millis(1600)));
        assert!(bucket.has_one(start + Duration::from_millis(1600), 10, 20));
    }
}
