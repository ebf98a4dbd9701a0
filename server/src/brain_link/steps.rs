//! Requests of a stream that holds robots: they are read, and Steps go to their world.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use baudbot_proto::v1;
use tokio::sync::Semaphore;
use tonic::{Status, Streaming};

use super::TURNS_AHEAD;
use crate::convert;
use crate::endpoint::Mode;
use crate::endpoint::{Endpoint, Write};
use crate::message::{Attached, Lease, Message, Step};
use crate::sessions::STEPS_A_TICK;

/// Steps of one stream that wait until the world handles them: as many as a tick takes, and the answers to all Turns that may wait,
/// which a brain in lockstep may send at once.
const STEPS_AHEAD: usize = TURNS_AHEAD + STEPS_A_TICK;

/// The next request of a stream; `None` if the client has ended it or is gone.
///
/// # Errors
/// If the request cannot be read, such as one that is too long.
pub(crate) async fn next_request<T>(requests: &mut Streaming<T>) -> Result<Option<T>, Status> {
    match requests.message().await {
        Ok(request) => Ok(request),
        // A status that the transport made has a source: the connection broke.
        Err(status) if status.source().is_some() => Ok(None),
        Err(status) => Err(Status::new(status.code(), format!("request: {}", status.message()))),
    }
}

/// The way of the Steps of one stream to its world.
pub(crate) struct Steps {
    endpoint: Endpoint,
    /// One for each Step that may wait until the world handles it.
    permits: Arc<Semaphore>,
    lost: Arc<AtomicU64>,
}

/// A Step that has been checked: the Turn that it answers, and what it writes.
pub(crate) struct CheckedStep {
    pub(crate) turn: u64,
    writes: Vec<Write>,
}

impl Steps {
    pub(crate) fn new(attached: &Attached, mode: Mode) -> Self {
        Self {
            endpoint: Endpoint::new(Arc::clone(&attached.scenario), attached.robots.clone(), mode),
            permits: Arc::new(Semaphore::new(STEPS_AHEAD)),
            lost: Arc::clone(&attached.lost_steps),
        }
    }

    /// Checks a Step.
    ///
    /// # Errors
    /// If it is invalid, with its field.
    pub(crate) fn checked(&self, step: v1::Step) -> Result<CheckedStep, Status> {
        let writes = convert::writes(step.robots);
        self.endpoint.check(&writes)?;
        Ok(CheckedStep { turn: step.turn, writes })
    }

    /// Sends a Step to the world; `false` if the world is over.
    pub(crate) fn send(&self, lease: &Lease, CheckedStep { turn, writes }: CheckedStep) -> bool {
        // A stream is always read on: unread requests would hold up all other streams of its connection.
        let Ok(permit) = Arc::clone(&self.permits).try_acquire_owned() else {
            self.lost.fetch_add(1, Ordering::Relaxed);
            return true;
        };
        let step = Step { session: lease.session, turn, writes, permit };
        lease.world.send(Message::Step(step)).is_ok()
    }
}
