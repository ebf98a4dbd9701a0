//! A robot's slot: its place for a brain.

use crate::endpoint::Until;
use crate::measures::Answering;
use crate::thinking::Thought;

/// A robot's place for a brain, and what was counted of the brains that have held it.
#[derive(Clone, Debug, Default)]
pub(super) struct Slot {
    pub(super) state: SlotState,
    pub(super) lost_deliveries: u64,
    /// The lost Steps of sessions that are over.
    pub(super) lost_steps: u64,
    /// The answering of sessions that are over.
    pub(super) answering: Answering,
    /// The thinking times of its brains, if anything was measured.
    pub(super) thought: Option<Box<Thought>>,
}

/// Whether a brain holds a robot, and what that means for a world in lockstep.
///
/// ```text
///   Vacant(Awaited) ──attach──▶ Held ──detach──▶ Vacant(Awaited | LeftOpen)   watchdog policy `wait`
///          │                                     Vacant(Excused)              other policies, other paces
///          └──StartWorld──▶ Vacant(Excused) ──attach──▶ Held
/// ```
///
/// A robot that a program of the user's own drives begins as Vacant(Excused).
#[derive(Clone, Copy, Debug)]
pub(super) enum SlotState {
    Vacant(Vacancy),
    Held {
        session: u64,
        /// The brain has answered, and waits for a message.
        until: Option<Until>,
    },
}

/// The behaviour of a world in lockstep towards a robot without a brain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Vacancy {
    /// The world goes on without a brain for the robot.
    Excused,
    /// The world begins no tick until a brain holds the robot.
    Awaited,
    /// Nor does it end the present tick: the last brain has left a Turn of this tick unanswered.
    LeftOpen,
}

impl Default for SlotState {
    fn default() -> Self {
        Self::Vacant(Vacancy::Awaited)
    }
}

impl Slot {
    /// One whose robot needs no brain.
    pub(super) fn excused() -> Self {
        Self { state: SlotState::Vacant(Vacancy::Excused), ..Self::default() }
    }

    pub(super) fn session(&self) -> Option<u64> {
        match self.state {
            SlotState::Held { session, .. } => Some(session),
            SlotState::Vacant(_) => None,
        }
    }

    /// The condition that its brain waits for, if there is one.
    pub(super) fn until(&self) -> Option<Until> {
        match self.state {
            SlotState::Held { until, .. } => until,
            SlotState::Vacant(_) => None,
        }
    }

    /// Notes what the brain waits for that holds it.
    pub(super) fn set_until(&mut self, new: Option<Until>) {
        if let SlotState::Held { until, .. } = &mut self.state {
            *until = new;
        }
    }

    pub(super) fn vacancy(&self) -> Option<Vacancy> {
        match self.state {
            SlotState::Vacant(vacancy) => Some(vacancy),
            SlotState::Held { .. } => None,
        }
    }

    /// The tick is over, or void: no Turn of it is open any more.
    pub(super) fn forget_open_turn(&mut self) {
        if self.vacancy() == Some(Vacancy::LeftOpen) {
            self.state = SlotState::Vacant(Vacancy::Awaited);
        }
    }
}
