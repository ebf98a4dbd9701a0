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
//! is neither kept nor late; but where a deadline is stated it is late like any other, since a real controller that
//! waits for a command cannot know why none comes.

use alloc::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::histogram::Histogram;
use crate::time::SimTime;

/// When a command must have answered the readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadline {
    /// After the cycle began, in nanoseconds. Δt if the scenario states none.
    pub within_ns: u64,
    /// What a brain gets that is late; `None` if the scenario states no deadline: then it is only counted.
    pub on_late: Option<OnLate>,
}

/// What happens when a cycle is not closed by its deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnLate {
    /// The old command stays in force.
    Hold,
    /// The motors are switched off until the next command is obeyed.
    Stop,
    /// The run ends.
    End,
}

/// How the control cycles of a robot went.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Cycles {
    /// Answered by a command that was obeyed by the deadline.
    pub kept: u64,
    /// Answered later than that, or, where a deadline is stated, not by then.
    pub late: u64,
    /// Overtaken or not answered.
    pub unanswered: u64,
    /// How long those took that were answered, in time or not.
    pub durations: Histogram,
    /// When those began that are not over yet, oldest first.
    open: VecDeque<SimTime>,
    /// When the newest began that was answered.
    answered: Option<SimTime>,
    /// Where a deadline is stated: that of a cycle which was closed after it, until that is noticed.
    overdue: Option<SimTime>,
}

impl Cycles {
    /// The share of the answered or late cycles that were kept; `None` if there were none.
    pub fn kept_share(&self) -> Option<f64> {
        let all = self.kept + self.late;
        (all > 0).then(|| self.kept as f64 / all as f64)
    }

    /// A message of readings is framed.
    pub(crate) fn open(&mut self, begun: SimTime) {
        if self.open.len() == MAX_OPEN {
            self.open.pop_front();
            self.unanswered += 1;
        }
        self.open.push_back(begun);
    }

    /// A command takes effect that answers the message whose cycle began at `begun`.
    pub(super) fn close(&mut self, deadline: &Deadline, begun: SimTime, at: SimTime) {
        if self.answered.is_some_and(|answered| answered >= begun) {
            return;
        }
        self.answered = Some(begun);
        let duration_ns = at.since(begun);
        self.durations.note(duration_ns);
        while let Some(open) = self.open.pop_front_if(|open| *open <= begun) {
            if open < begun {
                self.unanswered += 1;
            } else if duration_ns <= deadline.within_ns {
                self.kept += 1;
            } else {
                self.late += 1;
                self.overdue = deadline.on_late.map(|_| begun + deadline.within_ns);
            }
        }
    }

    /// The brain leaves the message unanswered whose cycle began at `begun`.
    pub(super) fn leave(&mut self, deadline: &Deadline, begun: SimTime) {
        if deadline.on_late.is_some() {
            return;
        }
        while self.open.pop_front_if(|open| *open <= begun).is_some() {
            self.unanswered += 1;
        }
    }

    /// Where a deadline is stated: one that is over at `now` before its cycle was, and that was not noticed before.
    pub(super) fn give_up(&mut self, deadline: &Deadline, now: SimTime) -> Option<SimTime> {
        deadline.on_late?;
        if let Some(overdue) = self.overdue.take_if(|overdue| *overdue < now) {
            return Some(overdue);
        }
        let begun = self.open.pop_front_if(|open| *open + deadline.within_ns < now)?;
        self.late += 1;
        Some(begun + deadline.within_ns)
    }
}

/// Most cycles that are under way at once: more messages than that on one cable wait in vain.
const MAX_OPEN: usize = 64;
