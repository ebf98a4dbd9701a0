//! The list of all worlds: all are asked at once, and one that does not answer keeps nobody waiting.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use baudbot_proto::v1;
use tokio::sync::oneshot;
use tokio::time::{Instant, timeout_at};
use tonic::Status;

use super::Control;
use crate::convert;
use crate::message::{Message, Reply, Request};
use crate::report::Report;
use crate::system::blocking;

/// How long worlds have to answer. One within a very long tick, whose `OnTick` blocks, or that waits for a brain that hangs,
/// does not.
const PATIENCE: Duration = Duration::from_secs(1);

/// How long the next ones have once a world has not answered.
const IMPATIENCE: Duration = Duration::from_millis(100);

/// Worlds that are asked at once: their states are copied for the answer.
const AT_ONCE: usize = 64;

/// What was last told of each world.
#[derive(Default)]
pub(crate) struct Told(Mutex<BTreeMap<String, v1::WorldStatus>>);

impl Told {
    /// Notes what is told of a world.
    pub(super) fn note(&self, status: &v1::WorldStatus) {
        self.lock().insert(status.world.clone(), status.clone());
    }

    pub(super) fn forget(&self, world: &str) {
        self.lock().remove(world);
    }

    fn last(&self, world: &str) -> Option<v1::WorldStatus> {
        self.lock().get(world).cloned()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, v1::WorldStatus>> {
        // The map is consistent between any two of its changes, so a panic elsewhere does not spoil it.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Control {
    /// The statuses of all worlds; of one that does not answer, what was last told of it. A world that is deleted meanwhile is
    /// left out.
    pub(super) async fn list_all(&self) -> Result<Vec<v1::WorldStatus>, Status> {
        let mut patience = PATIENCE;
        let mut statuses = Vec::new();
        for worlds in self.registry.all().chunks(AT_ONCE) {
            let asked: Vec<_> = worlds
                .iter()
                .filter_map(|world| {
                    let (reply, answer): (Reply<Report>, _) = oneshot::channel();
                    world.send(Message::Request(Request::Report, reply)).ok()?;
                    Some((world.name(), answer))
                })
                .collect();
            let deadline = Instant::now() + patience;
            let mut reports = Vec::new();
            for (name, mut answer) in asked {
                match (timeout_at(deadline, &mut answer).await, self.told.last(name)) {
                    (Ok(answer), _) => reports.extend(answer.ok().and_then(Result::ok)),
                    (Err(_), Some(last)) => {
                        statuses.push(last);
                        patience = IMPATIENCE;
                    }
                    // Nothing is known of it yet.
                    (Err(_), None) => reports.extend(answer.await.ok().and_then(Result::ok)),
                }
            }
            let work = move || reports.iter().map(convert::status).collect::<Vec<_>>();
            let fresh = blocking(work).await?;
            fresh.iter().for_each(|status| self.told.note(status));
            statuses.extend(fresh);
        }
        statuses.sort_by(|a, b| a.world.cmp(&b.world));
        Ok(statuses)
    }
}
