//! The list of all worlds: some are asked at a time, and one that does not answer delays no other.

use std::time::Duration;

use futures_util::future::join_all;
use tokio::time::{Instant, timeout_at};
use tonic::Status;

use super::Control;
use super::status::{field_1, status_in_bytes};
use crate::limits::Parts;
use crate::message::WorldHandle;

/// The time that worlds have to answer. One within a very long tick, whose `OnTick` blocks, or that waits for a brain
/// that hangs, does not.
const PATIENCE: Duration = Duration::from_secs(1);

/// The time of the next ones once a world has not answered.
const IMPATIENCE: Duration = Duration::from_millis(100);

/// Worlds that are asked at once: their states are copied for the answer.
const AT_ONCE: usize = 64;

impl Control {
    /// The response to a ListWorlds: the statuses of all worlds; of one that does not answer, its last known one. A
    /// world that is deleted meanwhile is left out.
    pub(super) async fn list_in_bytes(&self) -> Result<Parts, Status> {
        let mut patience = PATIENCE;
        let mut list = Vec::new();
        // The worlds are in the order of their names.
        for worlds in self.registry.all().chunks(AT_ONCE) {
            let deadline = Instant::now() + patience;
            let statuses = join_all(worlds.iter().map(|world| self.status_or_last(world, deadline))).await;
            for (status, is_late) in statuses {
                if is_late {
                    patience = IMPATIENCE;
                }
                list.extend(status.into_iter().flat_map(|status| field_1(status).0));
            }
        }
        Ok(Parts(list))
    }

    /// The status of a world, or its last known one, and whether it did not answer in time.
    async fn status_or_last(&self, world: &WorldHandle, deadline: Instant) -> (Option<Parts>, bool) {
        let mut status = std::pin::pin!(status_in_bytes(world));
        let in_time = timeout_at(deadline, &mut status).await;
        let (status, is_late) = match (in_time, self.told.last(world.name())) {
            (Ok(status), _) => (status, false),
            (Err(_), Some(last)) => return (Some(last), true),
            // Nothing is known of it yet.
            (Err(_), None) => (status.await, false),
        };
        let Ok(status) = status else { return (None, is_late) };
        self.told.note_bytes(world.name(), status.clone());
        (Some(status), is_late)
    }
}
