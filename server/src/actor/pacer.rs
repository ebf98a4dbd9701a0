//! The pace of a world: the clock that it follows, and how well it does.

use std::time::{Duration, Instant};

use super::WorldActor;
use super::stopwatch::Stopwatch;
use crate::clock;
use crate::log::event;
use crate::pace::{Clock, Pace, Pacing, Terms, Timed};

/// The pace of a world and what is measured of it.
pub(super) struct Pacer {
    pub(super) pace: Pace,
    pub(super) paused: bool,
    /// Set while simulated time follows the wall clock.
    pub(super) clock: Option<Clock>,
    pub(super) statistics: Pacing,
    /// Since when the world waits for brains, in lockstep.
    pub(super) waiting_since: Instant,
    pub(super) running: Stopwatch,
    /// The reading of `running` then. The time of waiting is a part of that, also if a brain goes meanwhile and
    /// another comes much later.
    waited_from: Duration,
    /// Whether the lag of the world has been logged.
    has_told_lag: bool,
}

impl Pacer {
    pub(super) fn new(pace: Pace, paused: bool) -> Self {
        Self {
            pace,
            paused,
            clock: None,
            statistics: Pacing::default(),
            waiting_since: clock::now(),
            running: Stopwatch::default(),
            waited_from: Duration::ZERO,
            has_told_lag: false,
        }
    }

    /// Forgets what was measured: another run begins.
    pub(super) fn reset_statistics(&mut self) {
        self.statistics = Pacing::default();
        self.running = Stopwatch::default();
        self.waited_from = Duration::ZERO;
    }

    /// The world waits for brains from now on.
    pub(super) fn wait_from(&mut self, now: Instant) {
        self.waiting_since = now;
        self.waited_from = self.running.elapsed_at(now);
    }

    /// Adds how long it has waited.
    pub(super) fn note_wait(&mut self, now: Instant) {
        self.statistics.waiting += self.running.elapsed_at(now).saturating_sub(self.waited_from);
    }
}

impl WorldActor {
    /// Skips a lag beyond that of the pace, before a tick, if simulated time follows the wall clock.
    pub(super) fn follow_clock(&mut self, now: Instant) {
        let Pace::Timed(Timed { factor, max_lag }) = self.pacer.pace else { return };
        let time = self.world.time();
        let clock = self.pacer.clock.get_or_insert_with(|| Clock::new(now, time, factor));
        let Some(beyond) = clock.let_go(now, time, max_lag) else { return };
        let statistics = &mut self.pacer.statistics;
        statistics.let_go += beyond;
        statistics.times_let_go += 1;
        if self.could_keep_pace(factor) {
            self.charges.limits().note_lag(now);
        }
        let limits = self.charges.limits();
        if !std::mem::replace(&mut self.pacer.has_told_lag, true) {
            let let_go_s = beyond.as_secs_f64();
            limits.lag_in_all(now);
            event!(
                self,
                warn,
                let_go_s,
                "the world fell behind the wall clock and skipped the lag; further lags are logged once a minute for all worlds"
            );
        } else if let Some(times) = limits.lag_in_all(now) {
            tracing::warn!(
                times,
                "worlds fell behind the wall clock and skipped the lags; their statuses and summaries have the amounts"
            );
        }
    }

    /// Whether the world could keep this pace if it had a processor for itself.
    fn could_keep_pace(&self, factor: f64) -> bool {
        let step = self.world.scenario().step_ns as f64 * 1e-9 / factor;
        // An `OnTick` may take any time.
        self.on_tick.is_none() && self.schedule.tick_takes().is_some_and(|takes| takes.as_secs_f64() < step)
    }

    /// The terms on which the world takes the answers to Turns that it gives now.
    pub(super) fn terms(&self, now: Instant) -> Terms {
        match self.pacer.pace {
            Pace::Lockstep(_) | Pace::Stepped(_) => Terms::Waits(now),
            Pace::Timed(Timed { factor, .. }) => {
                let clock = self.pacer.clock.as_ref();
                let tick_begins = clock.map_or(now, |clock| clock.instant(self.world.time()));
                Terms::FollowsClock { now, tick_begins, factor }
            }
            Pace::Free => Terms::GoesOn,
        }
    }

    /// Measures a tick that ends: how late it is, or how long brains were waited for.
    pub(super) fn note_end_of_tick(&mut self, now: Instant) {
        if self.pacer.clock.is_some() {
            self.note_lateness(now);
        } else if self.pacer.pace.watchdog().is_some() && !self.sessions.is_any_overtaken() {
            self.pacer.note_wait(now);
        }
    }

    /// Measures how late a tick ends by the wall clock, if the world follows it.
    pub(super) fn note_lateness(&mut self, now: Instant) {
        let Some(clock) = &self.pacer.clock else { return };
        let due = clock.instant(self.tick_end());
        let step = due - clock.instant(self.world.time());
        self.pacer.statistics.note_lateness(now.saturating_duration_since(due), step);
    }

    pub(super) fn set_pace(&mut self, pace: Pace) {
        // Turns that are open stay open from lockstep to lockstep.
        if self.pacer.pace.watchdog().is_none() || pace.watchdog().is_none() {
            for session in self.sessions.overtaken_sessions() {
                let steps = self.sessions.take_overtaken(session);
                self.settle(&steps);
            }
            self.sessions.void_turns(&self.world);
        }
        self.pacer.pace = pace;
        self.recording.set_pace(pace);
        self.pacer.clock = None;
        self.end_stepping();
        self.pacer.wait_from(clock::now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_waited_is_a_part_of_the_time_in_which_the_world_runs() {
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        let mut pacer = Pacer::new(Pace::Free, false);
        pacer.running.set(true, at(0));
        pacer.wait_from(at(1));
        // The brain is killed, and another comes after a while.
        pacer.running.set(false, at(2));
        pacer.running.set(true, at(8));
        pacer.note_wait(at(9));
        assert_eq!(pacer.statistics.waiting, Duration::from_secs(2));
        assert_eq!(pacer.running.elapsed_at(at(9)), Duration::from_secs(3));
    }
}
