//! The truth about the readings that are at the laptop, for observers: when each was sampled, and how old readings were as
//! they came. It is no part of the state: after a state was restored it is known of the readings that come from then on.

use alloc::vec::Vec;

use crate::time::SimTime;

/// The truth about the reading of a sensor that is at the laptop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heard {
    /// The instant at which it was truly sampled, as far as that is known.
    pub sampled_at: Option<SimTime>,
    /// The age of the sensor's readings whenever one came in the last tick: the one that went, and the one that came.
    pub ages: AgeSpan,
}

/// The least and the most of some ages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AgeSpan {
    least_ns: u64,
    most_ns: u64,
}

impl Default for AgeSpan {
    /// An `AgeSpan` of no ages.
    fn default() -> Self {
        Self { least_ns: u64::MAX, most_ns: 0 }
    }
}

impl AgeSpan {
    /// The span with one more age.
    #[must_use]
    pub fn and(self, age_ns: u64) -> Self {
        Self { least_ns: self.least_ns.min(age_ns), most_ns: self.most_ns.max(age_ns) }
    }

    /// The span with all ages of another one.
    #[must_use]
    pub fn join(self, other: Self) -> Self {
        Self { least_ns: self.least_ns.min(other.least_ns), most_ns: self.most_ns.max(other.most_ns) }
    }

    /// Least and most in nanoseconds; `None` of no ages.
    pub fn bounds_ns(self) -> Option<(u64, u64)> {
        (self.least_ns <= self.most_ns).then_some((self.least_ns, self.most_ns))
    }
}

/// The truth about all readings at a laptop.
#[derive(Clone, Debug, Default)]
pub(crate) struct AllHeard {
    sensors: Vec<Heard>,
    /// The instants at which the counters were sampled that become a reading with the message that comes next.
    positions: Vec<(usize, SimTime)>,
    has_news: bool,
}

impl AllHeard {
    /// The truth about the reading of a sensor, by its place.
    pub(crate) fn of(&self, sensor: usize) -> Heard {
        self.sensors.get(sensor).copied().unwrap_or_default()
    }

    /// A tick begins: nothing has come in it yet.
    #[inline]
    pub(crate) fn begin_tick(&mut self) {
        if core::mem::take(&mut self.has_news) {
            self.sensors.iter_mut().for_each(|heard| heard.ages = AgeSpan::default());
        }
    }

    /// A reading comes at `now`. On board one comes of each sensor in each step, so this is short.
    #[inline]
    pub(crate) fn take(&mut self, sensor: usize, now: SimTime, sampled_at: Option<SimTime>) {
        if sensor >= self.sensors.len() {
            self.grow(sensor);
        }
        let heard = &mut self.sensors[sensor];
        if let Some(former) = core::mem::replace(&mut heard.sampled_at, sampled_at) {
            heard.ages = heard.ages.and(now.since(former));
        }
        if let Some(sampled_at) = sampled_at {
            heard.ages = heard.ages.and(now.since(sampled_at));
        }
        self.has_news = true;
    }

    #[cold]
    fn grow(&mut self, sensor: usize) {
        self.sensors.resize(sensor + 1, Heard::default());
    }

    /// Counters come that [become a reading](Self::take_positions) with the next message.
    pub(crate) fn keep_positions(&mut self, sampled: &[(usize, SimTime)]) {
        self.positions.clear();
        self.positions.extend_from_slice(sampled);
    }

    /// Takes the positions of the wheels as readings, at `now`.
    pub(crate) fn take_positions(&mut self, now: SimTime) {
        let mut positions = core::mem::take(&mut self.positions);
        positions.drain(..).for_each(|(sensor, sampled_at)| self.take(sensor, now, Some(sampled_at)));
        // The memory of the list is kept for the next ones.
        self.positions = positions;
    }

    /// The bytes that it takes when each of so many sensors has had a reading.
    pub(crate) fn heap_bytes(&self, sensors: usize) -> usize {
        sensors * size_of::<Heard>() + self.positions.len() * size_of::<(usize, SimTime)>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_are_those_of_the_reading_that_goes_and_of_the_one_that_comes() {
        let at = |ms: u64| SimTime::from_ns(ms * 1_000_000);
        let mut all = AllHeard::default();
        all.take(1, at(20), Some(at(0)));
        assert_eq!(all.of(1).ages.bounds_ns(), Some((20_000_000, 20_000_000)), "nothing was there before");
        all.begin_tick();
        assert_eq!((all.of(1).sampled_at, all.of(1).ages.bounds_ns()), (Some(at(0)), None));
        all.take(1, at(41), Some(at(20)));
        all.take(1, at(45), None);
        assert_eq!(all.of(1).ages.bounds_ns(), Some((21_000_000, 41_000_000)));
        assert_eq!(all.of(1).sampled_at, None, "of this one it is not known");
        assert_eq!(all.of(0), Heard::default());
    }
}
