//! How much a brain may say: what is beyond is thrown away and counted, and its stream is read on. Nobody else on the
//! connection waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{Seat, Sessions};

impl Sessions {
    /// Whether the world takes another Step of this brain in this tick. One that it does not take is counted.
    pub(crate) fn takes_step(&mut self, number: u64) -> bool {
        let Some(session) = self.by_number.get_mut(&number) else { return false };
        let takes = session.steps < STEPS_A_TICK;
        if takes {
            session.steps += 1;
        } else {
            session.lost_steps.fetch_add(1, Ordering::Relaxed);
        }
        takes
    }

    /// The tick is over.
    pub(crate) fn forget_steps(&mut self) {
        for session in self.by_number.values_mut() {
            session.steps = 0;
        }
    }

    /// Where those are counted of a stream that are thrown away before the world sees them.
    pub(crate) fn count_of_lost_steps(&self, number: u64) -> Arc<AtomicU64> {
        self.by_number.get(&number).map(|session| Arc::clone(&session.lost_steps)).unwrap_or_default()
    }

    /// Steps for a robot that were thrown away.
    pub(crate) fn lost_steps(&self, seat: &Seat) -> u64 {
        let session = seat.session.and_then(|number| self.by_number.get(&number));
        seat.lost_steps + session.map_or(0, |session| session.lost_steps.load(Ordering::Relaxed))
    }
}

/// Steps of one stream that the world takes in a tick, where it does not wait for them.
pub(crate) const STEPS_A_TICK: usize = 64;
