//! Pace: when a tick may end, that is, how long the world waits for its brains.

use std::time::{Duration, Instant};

use baudbot_sim::SimTime;

/// The paces of `docs/explanation/timing.md`; they differ only in when a tick ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Simulated time follows the wall clock.
    Timed(Timed),
    /// The world waits for every brain.
    Lockstep(Lockstep),
    /// The same as lockstep, but only as many ticks as asked for.
    Stepped(Lockstep),
    /// The world runs as fast as it can; a brain that has not answered has written nothing.
    Free,
}

impl Pace {
    /// The pace of real time.
    pub const REAL_TIME: Self = Self::scaled(1.0);

    /// The pace of `factor` simulated seconds a wall-clock second, positive and finite, with the usual lag at most.
    pub const fn scaled(factor: f64) -> Self {
        Self::Timed(Timed { factor, max_lag: Timed::MAX_LAG })
    }

    /// The rules for waiting for brains, in the paces that have them.
    pub(crate) fn lockstep(&self) -> Option<Lockstep> {
        match self {
            Self::Lockstep(lockstep) | Self::Stepped(lockstep) => Some(*lockstep),
            Self::Timed(_) | Self::Free => None,
        }
    }

    /// The watchdog of those paces.
    pub(crate) fn watchdog(&self) -> Option<Watchdog> {
        self.lockstep().map(|lockstep| lockstep.watchdog)
    }
}

/// The terms on which the world takes the answer to a Turn.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Terms {
    /// The world waits for the answer, in a tick that began at this instant.
    Waits(Instant),
    /// The world follows the wall clock.
    FollowsClock {
        /// The instant at which it gives the Turn.
        now: Instant,
        /// The instant at which the tick begins by the world's clock, which is not later.
        tick_begins: Instant,
        /// Simulated seconds a wall-clock second.
        factor: f64,
    },
    /// The world goes on at once.
    GoesOn,
}

impl Terms {
    /// The instant at which the tick began in which the answer is owed, if it is.
    pub(crate) fn owed_since(self) -> Option<Instant> {
        match self {
            Self::Waits(begun) => Some(begun),
            Self::FollowsClock { .. } | Self::GoesOn => None,
        }
    }
}

/// The rules by which a world follows the wall clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timed {
    /// Simulated seconds a wall-clock second; 1 is real time. Positive and finite.
    pub factor: f64,
    /// The longest lag of the world behind the wall clock. It makes up for that as fast as it can. A lag beyond it is
    /// skipped: the world's clock is set back by it for good.
    pub max_lag: Duration,
}

impl Timed {
    /// The usual limit: brains notice little of a tenth of a second that is simulated at once.
    pub const MAX_LAG: Duration = Duration::from_millis(100);
}

/// The rules by which a world waits for its brains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lockstep {
    /// The watchdog: the treatment of a brain that does not answer.
    pub watchdog: Watchdog,
    /// Whether brains that wait for a message are not asked until one has come, and the world goes on while a brain's answer
    /// could not have reached its robot anyway. The run has the same bits either way, and takes less time with it.
    pub lookahead: bool,
}

impl Default for Lockstep {
    fn default() -> Self {
        Watchdog::default().into()
    }
}

impl From<Watchdog> for Lockstep {
    /// The lockstep with this watchdog, and with lookahead.
    fn from(watchdog: Watchdog) -> Self {
        Self { watchdog, lookahead: true }
    }
}

/// The treatment of a brain that does not answer in lockstep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watchdog {
    /// The time that a brain may take, by the wall clock.
    pub timeout: Duration,
    /// The policy that applies then.
    pub policy: WatchdogPolicy,
}

impl Default for Watchdog {
    /// 10 s are longer than a brain in good order thinks, and short enough for a person to see that something hangs. Waiting on is
    /// the only policy with which a run is the same on any machine.
    fn default() -> Self {
        Self { timeout: Duration::from_secs(10), policy: WatchdogPolicy::Wait }
    }
}

/// The policies for a brain that did not answer in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchdogPolicy {
    /// The world waits on; for a brain that is gone, until one attaches again.
    Wait,
    /// The world goes on and does not wait for this brain again until it answers.
    GoOn,
    /// The brain is detached; the world goes on without it until it attaches again.
    Detach,
}

/// Simulated time on the wall clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    start: Instant,
    origin: SimTime,
    factor: f64,
}

impl Clock {
    /// A clock that shows `origin` at `start`.
    pub(crate) fn new(start: Instant, origin: SimTime, factor: f64) -> Self {
        Self { start, origin, factor }
    }

    /// When the clock shows `time`. The whole span since the start is scaled at once, so nothing drifts.
    pub(crate) fn instant(&self, time: SimTime) -> Instant {
        let seconds = time.since(self.origin) as f64 * 1e-9 / self.factor;
        // A run slowed down a billion times would leave what `Instant` can hold; a year ahead is as good.
        self.start + Duration::try_from_secs_f64(seconds).unwrap_or(YEAR).min(YEAR)
    }

    /// Sets the clock back by what `time` lags beyond `most`, and gives by how much; `None` if it does not.
    pub(crate) fn let_go(&mut self, now: Instant, time: SimTime, most: Duration) -> Option<Duration> {
        let lag = now.saturating_duration_since(self.instant(time));
        let beyond = lag.checked_sub(most).filter(|beyond| !beyond.is_zero())?;
        self.start += beyond;
        Some(beyond)
    }

    /// The time that the clock shows.
    pub(crate) fn time(&self, now: Instant) -> SimTime {
        let elapsed = now.saturating_duration_since(self.start).as_secs_f64();
        self.origin + (elapsed * self.factor * 1e9) as u64
    }
}

const YEAR: Duration = Duration::from_secs(365 * 24 * 3600);

/// The quality of a world's pace.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Pacing {
    pub(crate) overruns: u64,
    /// Ticks by lateness: entry 0 counts those less than 1 µs late, entry i those less than 2^i µs late.
    pub(crate) lateness_us_log2: [u64; 32],
    pub(crate) lateness_max: Duration,
    pub(crate) lateness_sum: Duration,
    pub(crate) watchdog_timeouts: u64,
    /// Wall-clock time during which the world waited for brains.
    pub(crate) waiting: Duration,
    /// The time by which the world lagged more than its pace allows, summed up, and how often it did.
    pub(crate) let_go: Duration,
    pub(crate) times_let_go: u64,
}

impl Pacing {
    /// Counts a tick, `step` of the wall clock long, that ended `late` after its instant.
    pub(crate) fn note_lateness(&mut self, late: Duration, step: Duration) {
        self.overruns += u64::from(late >= step);
        let bits = u64::BITS - (late.as_micros() as u64).leading_zeros();
        self.lateness_us_log2[(bits as usize).min(self.lateness_us_log2.len() - 1)] += 1;
        self.lateness_max = self.lateness_max.max(late);
        self.lateness_sum += late;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_scales_the_way_from_its_start_and_back() {
        let start = Instant::now();
        let clock = Clock::new(start, SimTime::from_ns(5_000_000_000), 10.0);
        let time = SimTime::from_ns(25_000_000_000);
        assert_eq!(clock.instant(time), start + Duration::from_secs(2));
        assert_eq!(clock.time(start + Duration::from_secs(2)), time);
        assert_eq!(clock.time(start - Duration::from_secs(1)), SimTime::from_ns(5_000_000_000));
        let crawling = Clock::new(start, SimTime::ZERO, 1e-300);
        assert_eq!(crawling.instant(time), start + YEAR);
    }

    #[test]
    fn a_clock_lets_go_what_is_beyond_the_lag_that_is_allowed() {
        let start = Instant::now();
        let mut clock = Clock::new(start, SimTime::ZERO, 2.0);
        let (time, most) = (SimTime::from_ns(10_000_000_000), Duration::from_millis(100));
        let due = start + Duration::from_secs(5);
        for on_time in [start, due, due + most] {
            assert_eq!(clock.let_go(on_time, time, most), None);
        }
        assert_eq!(clock.instant(time), due);
        let late = due + Duration::from_secs(10);
        assert_eq!(clock.let_go(late, time, most), Some(Duration::from_millis(9900)));
        assert_eq!(clock.instant(time), late - most, "a tenth of a second is worked off");
        assert_eq!(clock.let_go(late, time, most), None);
    }

    #[test]
    fn lateness_is_counted_by_powers_of_two() {
        let mut pacing = Pacing::default();
        for us in [0, 1, 2, 3, 4, 1000, 20_000] {
            pacing.note_lateness(Duration::from_micros(us), Duration::from_millis(10));
        }
        assert_eq!(pacing.lateness_us_log2[..4], [1, 1, 2, 1]);
        assert_eq!(pacing.lateness_us_log2[10], 1);
        assert_eq!(pacing.overruns, 1);
        assert_eq!(pacing.lateness_max, Duration::from_millis(20));
        assert_eq!(pacing.lateness_sum, Duration::from_micros(21_010));
    }
}
