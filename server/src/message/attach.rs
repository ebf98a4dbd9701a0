//! A brain and its robots: how it takes them, what it receives, and how they are released.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use baudbot_sim::Scenario;
use bytes::Bytes;
use tokio::sync::mpsc;
use tonic::Status;

use super::{Message, WorldHandle};
use crate::beliefs::Beliefs;
use crate::endpoint::Mode;
use crate::truth::Truth;

/// A brain program asks for robots.
pub(crate) struct Attach {
    /// The names of the robots.
    pub(crate) robots: Vec<String>,
    /// The name of the brain.
    pub(crate) brain: String,
    /// What it takes and gives.
    pub(crate) mode: Mode,
    /// Memory that the program's variables need on each robot.
    pub(crate) memory_bytes: Option<u64>,
    /// Whether it has promised to think as long as the scenario says.
    pub(crate) thinks_as_scenario: bool,
    /// Whether its robots are to stand when it is gone.
    pub(crate) stop_when_gone: bool,
    /// The name of the token that it has shown, if it has shown one.
    pub(crate) by: Option<String>,
    pub(crate) recipient: Recipient,
    /// The way back to the world, for the lease.
    pub(crate) world: WorldHandle,
}

/// The answer to a brain that has its robots.
pub(crate) struct Attached {
    pub(crate) lease: Lease,
    pub(crate) scenario: Arc<Scenario>,
    /// Indices of the robots, in the order of the request.
    pub(crate) robots: Vec<usize>,
    pub(crate) lockstep: bool,
    pub(crate) beliefs: Beliefs,
    /// Counts the Steps that are thrown away before the world sees them.
    pub(crate) lost_steps: Arc<AtomicU64>,
}

/// The hold of a brain on its robots. Dropping it, wherever that happens, lets them go; so does dropping an answer that has
/// it in it and for which no client waits any more.
pub(crate) struct Lease {
    pub(crate) world: WorldHandle,
    pub(crate) session: u64,
    /// Why the robots are let go, for the log.
    pub(crate) why: String,
}

impl Drop for Lease {
    fn drop(&mut self) {
        let why = std::mem::take(&mut self.why);
        // A world that is over holds nothing any more.
        let _ = self.world.send(Message::Detach { session: self.session, why });
    }
}

/// Who is at the other end of a stream that holds robots. Only a trainer is told the truth.
pub(crate) enum Recipient {
    Brain(mpsc::Sender<Delivery>),
    Trainer(mpsc::Sender<Told>),
}

impl Recipient {
    /// Places in the stream that are free.
    pub(crate) fn capacity(&self) -> usize {
        match self {
            Self::Brain(deliveries) => deliveries.capacity(),
            Self::Trainer(told) => told.capacity(),
        }
    }

    /// Deliveries that it has not read yet.
    pub(crate) fn waiting(&self) -> usize {
        match self {
            Self::Brain(deliveries) => deliveries.max_capacity() - deliveries.capacity(),
            Self::Trainer(told) => told.max_capacity() - told.capacity(),
        }
    }

    /// Gives a Turn; `false` if there is no room for it, or nobody who takes it.
    pub(crate) fn turn(&self, turn: Bytes, truth: impl FnOnce() -> Truth) -> bool {
        match self {
            Self::Brain(deliveries) => deliveries.try_send(Delivery::Turn(turn)).is_ok(),
            Self::Trainer(told) => told.try_send(Told::Turn(turn, truth().into())).is_ok(),
        }
    }

    /// Says that the run is over.
    pub(crate) fn ended(&self, tick: u64, truth: impl FnOnce() -> Truth) {
        // Whoever is gone, or has not read hundreds of Turns, is not told.
        match self {
            Self::Brain(deliveries) => drop(deliveries.try_send(Delivery::Ended { tick })),
            Self::Trainer(told) => drop(told.try_send(Told::Ended(truth().into()))),
        }
    }

    /// Ends the stream.
    pub(crate) fn close(&self, status: Status) {
        match self {
            Self::Brain(deliveries) => drop(deliveries.try_send(Delivery::Close(status))),
            Self::Trainer(told) => drop(told.try_send(Told::Close(status))),
        }
    }
}

/// A delivery to a brain.
pub(crate) enum Delivery {
    /// A Turn, in the bytes that go over the network.
    Turn(Bytes),
    Ended {
        tick: u64,
    },
    Close(Status),
}

/// A delivery to a trainer.
pub(crate) enum Told {
    /// What a brain would get, and what is true at the start of its tick.
    Turn(Bytes, Box<Truth>),
    Ended(Box<Truth>),
    Close(Status),
}
