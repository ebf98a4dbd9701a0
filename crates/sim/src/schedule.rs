//! The times of something that repeats.

use serde::{Deserialize, Serialize};

use crate::time::SimTime;

/// Due at `phase`, `phase + period`, `phase + 2 period`, …
///
/// One concept serves sensors and frames alike. A Khepera's eight IR sensors, of which one is read every
/// 2.5 ms (§3.2.1), are eight schedules of period 20 ms and phases 0, 2.5, 5, … 17.5 ms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    period_ns: u64,
    phase_ns: u64,
}

impl Schedule {
    /// A schedule with this period, in nanoseconds, and first due at `phase_ns`. A period of 0 is taken as
    /// 1 ns, so that every schedule makes progress; scenario files refuse it earlier, with its name.
    pub fn new(period_ns: u64, phase_ns: u64) -> Self {
        Self { period_ns: period_ns.max(1), phase_ns }
    }

    /// Nanoseconds between two due instants.
    pub fn period_ns(&self) -> u64 {
        self.period_ns
    }

    /// The first due instant, in nanoseconds after the start.
    pub fn phase_ns(&self) -> u64 {
        self.phase_ns
    }

    /// The same with its first due instant so many nanoseconds later.
    pub fn later_by(&self, ns: u64) -> Self {
        Self { phase_ns: self.phase_ns.saturating_add(ns), ..*self }
    }

    /// The same with its first due instant so many nanoseconds earlier, at the start of the run at the earliest.
    pub fn earlier_by(&self, ns: u64) -> Self {
        Self { phase_ns: self.phase_ns.saturating_sub(ns), ..*self }
    }

    /// The schedule at the start of a run.
    pub fn start(&self) -> Due {
        Due { next: SimTime::from_ns(self.phase_ns), missed: 0 }
    }
}

/// The state of a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Due {
    /// The next due instant.
    pub next: SimTime,
    /// The number of missed instants.
    pub missed: u64,
}

impl Due {
    pub(crate) fn is_sound(&self) -> bool {
        crate::sound::count(self.missed)
    }

    /// Served at `now`, which is at or after `next`. What fell due meanwhile is missed, not made up for; returns how
    /// much.
    #[inline]
    pub fn serve(&mut self, schedule: &Schedule, now: SimTime) -> u64 {
        let late_ns = now.since(self.next);
        // Seldom is a division needed.
        let missed = if late_ns < schedule.period_ns { 0 } else { late_ns / schedule.period_ns };
        self.missed += missed;
        self.next = self.next + (missed + 1) * schedule.period_ns;
        missed
    }
}

#[cfg(test)]
mod tests {
    use super::Schedule;
    use crate::time::SimTime;

    #[test]
    fn a_late_service_misses_what_fell_due_meanwhile() {
        let schedule = Schedule::new(10, 3);
        let mut due = schedule.start();
        assert_eq!(due.next, SimTime::from_ns(3));
        due.serve(&schedule, SimTime::from_ns(3));
        assert_eq!((due.next, due.missed), (SimTime::from_ns(13), 0));
        due.serve(&schedule, SimTime::from_ns(22));
        assert_eq!((due.next, due.missed), (SimTime::from_ns(23), 0));
        due.serve(&schedule, SimTime::from_ns(47));
        assert_eq!((due.next, due.missed), (SimTime::from_ns(53), 2));
    }
}
