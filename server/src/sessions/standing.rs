//! The robots with brains, for a world that is there again after its server was gone.

use super::Sessions;
use super::slot::{Slot, SlotState, Vacancy};

/// The world waits for a brain, ...
const AWAITED: u8 = 0;
/// ... goes on without one, ...
const EXCUSED: u8 = 1;
/// ... or has one.
const HELD: u8 = 2;

impl Sessions {
    /// A number for each robot, which [`resume`](Self::resume) knows. `coming_back`: robots whose brain a server has lost, and that
    /// has not come back yet.
    pub(crate) fn standing(&self, coming_back: &[bool]) -> impl Iterator<Item = u8> {
        self.slots.iter().zip(coming_back).map(|(slot, comes_back)| match slot.state {
            SlotState::Vacant(Vacancy::Excused) => EXCUSED,
            SlotState::Vacant(Vacancy::Awaited | Vacancy::LeftOpen) if !comes_back => AWAITED,
            SlotState::Held { .. } | SlotState::Vacant(Vacancy::Awaited | Vacancy::LeftOpen) => HELD,
        })
    }

    /// The robots have no brains, but those that had none before go on without one as before.
    pub(crate) fn resume(&mut self, standing: &[u8]) {
        for (slot, standing) in self.slots.iter_mut().zip(standing) {
            *slot = if *standing == EXCUSED { Slot::excused() } else { Slot::default() };
        }
    }

    /// The robots that had a brain.
    pub(crate) fn held(&self, standing: &[u8]) -> Vec<bool> {
        (0..self.slots.len()).map(|robot| standing.get(robot) == Some(&HELD)).collect()
    }
}
