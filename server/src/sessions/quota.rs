//! The quota: the number of Steps of a brain that a world takes in a tick.
//!
//! A brain of a world that does not wait for answers may send Steps without end. Steps beyond the quota are discarded
//! and counted, and the server keeps reading the stream, so that other streams on the connection do not wait for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Sessions;
use super::slot::Slot;

/// Steps of one stream that the world takes in a tick, where it does not wait for them.
pub(crate) const STEPS_A_TICK: usize = 64;

/// The Steps of a session.
#[derive(Default)]
pub(super) struct Quota {
    /// The number of Steps that the world has taken in this tick.
    taken: usize,
    /// The number of Steps that were dropped, here or before the world saw them.
    lost: Arc<AtomicU64>,
}

impl Quota {
    /// The counter of Steps that were thrown away.
    pub(super) fn lost(&self) -> &Arc<AtomicU64> {
        &self.lost
    }

    fn take(&mut self) -> bool {
        let takes = self.taken < STEPS_A_TICK;
        if takes {
            self.taken += 1;
        } else {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        takes
    }
}

impl Sessions {
    /// Whether the world takes another Step of this brain in this tick. A Step that it does not take is counted.
    pub(crate) fn takes_step(&mut self, number: u64) -> bool {
        self.by_number.get_mut(&number).is_some_and(|session| session.quota.take())
    }

    /// The tick is over.
    pub(crate) fn reset_quotas(&mut self) {
        for session in self.by_number.values_mut() {
            session.quota.taken = 0;
        }
    }

    /// Steps for all robots that were thrown away.
    pub(crate) fn all_lost_steps(&self) -> u64 {
        self.slots.iter().map(|slot| self.lost_steps(slot)).sum()
    }

    /// Steps for a robot that were thrown away.
    pub(super) fn lost_steps(&self, slot: &Slot) -> u64 {
        let session = slot.session().and_then(|number| self.by_number.get(&number));
        slot.lost_steps + session.map_or(0, |session| session.quota.lost.load(Ordering::Relaxed))
    }
}
