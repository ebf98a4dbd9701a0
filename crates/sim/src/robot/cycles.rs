//! Control cycles: from the readings that the microcontroller frames to the command that answers them.
//!
//! A cycle belongs to one message of readings. It begins when the microcontroller begins to frame it, less the time
//! that reading the sensors in it took, as if they had been read just before: what the cycle costs, not what it waits
//! for. It ends when a command is obeyed that the brain wrote in the step in which it had that message; with motors
//! that are servos, at the pulse with which they take it up. So it is the sum of the boxes of Fig. 3.2, with the
//! waiting for adapters, for the wire and for the brain's step between them.
//!
//! *Choices.* The notes ask that the sum of the boxes be shorter than Δt, so that is the deadline unless the scenario
//! states another. A message that a newer one overtook before the brain's step, or that the brain chose not to answer,
//! is neither kept nor late. Where a deadline is stated it is late like any other if no command takes effect by then,
//! since a real controller that waits for a command cannot know why none comes; a command that answers a newer message
//! will do.

use alloc::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::writes::Exceptions;
use crate::histogram::Histogram;
use crate::model::Deadline;
use crate::time::SimTime;

/// The control cycles of a robot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Cycles {
    /// The number of cycles that were answered by a command that took effect by the deadline.
    pub kept: u64,
    /// The number of cycles that were answered later than that, or, where a deadline is stated, not by then.
    pub late: u64,
    /// Overtaken or not answered.
    pub unanswered: u64,
    /// The brain's deviations from its stated writing.
    #[serde(skip)]
    pub exceptions: Exceptions,
    /// The durations of the answered cycles, in time or not.
    pub durations: Histogram,
    /// The cycles that are not over yet, oldest first.
    open: VecDeque<Open>,
    /// The instant at which the newest began that was answered.
    answered: Option<SimTime>,
}

/// A cycle that is not over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Open {
    begun: SimTime,
    /// The cycle has been counted as late, and is only waited for.
    is_late: bool,
    /// The instant at which the command takes effect that closes the cycle, and whether that answers this very message.
    closed: Option<(SimTime, bool)>,
}

impl Cycles {
    /// Whether the counts and durations are possible.
    pub(crate) fn are_sound(&self) -> bool {
        let counts = [self.kept, self.late, self.unanswered].into_iter().all(crate::sound::count);
        counts && self.durations.is_sound() && self.open.len() <= MAX_OPEN
    }

    /// The share of the answered or late cycles that were kept; `None` if there were none.
    pub fn kept_share(&self) -> Option<f64> {
        let all = self.kept + self.late;
        (all > 0).then(|| self.kept as f64 / all as f64)
    }

    /// The number of cycles that are neither kept nor late nor unanswered yet.
    pub fn under_way(&self) -> u64 {
        self.open.iter().filter(|open| !open.is_late).count() as u64
    }

    /// Whether a command has been obeyed whose cycle is still to be counted.
    pub(crate) fn is_closing(&self) -> bool {
        self.open.front().is_some_and(|open| open.closed.is_some())
    }

    /// A message of readings is framed.
    pub(super) fn open(&mut self, begun: SimTime) {
        if self.open.len() == MAX_OPEN
            && let Some(oldest) = self.open.pop_front()
        {
            self.unanswered += u64::from(!oldest.is_late);
        }
        self.open.push_back(Open { begun, is_late: false, closed: None });
    }

    /// A command is obeyed that answers the message whose cycle began at `begun`, and takes effect at `at`. Whether it is the
    /// first that answers it.
    pub(super) fn close(&mut self, deadline: &Deadline, begun: SimTime, at: SimTime) -> bool {
        if self.answered.is_some_and(|answered| answered >= begun) {
            return false;
        }
        self.answered = Some(begun);
        let mut is_known = false;
        for open in self.open.iter_mut().take_while(|open| open.begun <= begun) {
            let is_it = open.begun == begun && !is_known;
            is_known |= is_it;
            open.closed = open.closed.or(Some((at, is_it)));
        }
        if !is_known {
            // The cycle had been given up before its answer came.
            self.unanswered = self.unanswered.saturating_sub(1);
            self.count(deadline, at.since(begun));
        }
        true
    }

    fn count(&mut self, deadline: &Deadline, duration_ns: u64) {
        self.durations.note(duration_ns);
        if duration_ns <= deadline.within_ns {
            self.kept += 1;
        } else {
            self.late += 1;
        }
    }

    /// The brain leaves the message unanswered whose cycle began at `begun`.
    pub(super) fn leave(&mut self, deadline: &Deadline, begun: SimTime) {
        if deadline.on_late.is_some() {
            return;
        }
        let open = &mut self.open;
        while open.pop_front_if(|open| open.begun <= begun && open.closed.is_none()).is_some() {
            self.unanswered += 1;
        }
    }

    /// Counts what is over at `now`. Where a deadline is stated, returns the instant of the first that has passed
    /// unnoticed: ask again until there is none.
    pub(super) fn settle(&mut self, deadline: &Deadline, now: SimTime) -> Option<SimTime> {
        while let Some(Open { begun, is_late, closed: Some((at, is_it)) }) = self.open.front().copied() {
            let due = begun + deadline.within_ns;
            let misses = deadline.on_late.is_some() && at > due;
            if misses && !is_late && due < now {
                self.front_is_late();
                return Some(due);
            }
            if at > now {
                break;
            }
            self.open.pop_front();
            match (is_it, is_late) {
                (true, true) => self.durations.note(at.since(begun)),
                (true, false) => self.count(deadline, at.since(begun)),
                (false, true) => {}
                (false, false) => self.unanswered += 1,
            }
        }
        self.give_up(deadline, now)
    }

    fn front_is_late(&mut self) {
        self.late += 1;
        if let Some(front) = self.open.front_mut() {
            front.is_late = true;
        }
    }

    /// The deadline of the first cycle that is over it at `now`, if one is stated.
    fn give_up(&mut self, deadline: &Deadline, now: SimTime) -> Option<SimTime> {
        deadline.on_late?;
        let is_over = |open: &Open| {
            let due = open.begun + deadline.within_ns;
            !open.is_late && due < now && open.closed.is_none_or(|(at, _)| at > due)
        };
        let open = self.open.iter_mut().find(|open| is_over(open))?;
        open.is_late = true;
        self.late += 1;
        Some(open.begun + deadline.within_ns)
    }
}

/// Most cycles that are under way at once. A brain that is farther behind than that answers nothing that is known here.
const MAX_OPEN: usize = 1024;

#[cfg(test)]
mod tests {
    use super::*;

    fn all(counts: [u64; 3]) -> Cycles {
        let [kept, late, unanswered] = counts;
        Cycles { kept, late, unanswered, ..Cycles::default() }
    }

    #[test]
    fn cycles_are_sound_unless_a_count_is_too_large_or_too_many_are_open() {
        assert!(all([1, 2, 3]).are_sound());
        for counts in [[u64::MAX, 0, 0], [0, u64::MAX, 0], [0, 0, u64::MAX]] {
            assert!(!all(counts).are_sound(), "{counts:?}");
        }
        let mut full = Cycles::default();
        (0..=MAX_OPEN as u64).for_each(|ns| full.open(SimTime::from_ns(ns)));
        assert!(full.are_sound() && full.unanswered == 1);
        let one = *full.open.front().unwrap();
        full.open.push_back(one);
        assert!(!full.are_sound());
    }
}
