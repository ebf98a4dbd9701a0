//! A brain and its robots: how it takes them, what it receives, and how they are released.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use baudbot_sim::Scenario;
use bytes::Bytes;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::Status;

use super::truth::Truth;
use super::{Message, WorldHandle};
use crate::beliefs::Beliefs;
use crate::endpoint::Mode;

/// A brain program asks for robots.
pub(crate) struct Attach {
    /// The names of the robots.
    pub(crate) robots: Vec<String>,
    /// The name of the brain.
    pub(crate) brain: String,
    /// The form of its input and output.
    pub(crate) mode: Mode,
    /// Memory that the program's variables need on each robot.
    pub(crate) memory_bytes: Option<u64>,
    /// Whether it has promised to think as long as the scenario states.
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
    /// The counter of the Steps that are thrown away before the world sees them.
    pub(crate) lost_steps: Arc<AtomicU64>,
}

/// The hold of a brain on its robots. The robots are released when it is dropped, wherever that happens; so they are
/// when an answer is dropped that has it in it and for which no client waits any more.
pub(crate) struct Lease {
    pub(crate) world: WorldHandle,
    pub(crate) session: u64,
    /// The reason why the robots are released, for the log.
    pub(crate) why: String,
}

impl Drop for Lease {
    fn drop(&mut self) {
        let why = std::mem::take(&mut self.why);
        // A world that is over holds nothing any more.
        let _ = self.world.send(Message::Detach { session: self.session, why });
    }
}

/// The other end of a stream that holds robots. Only a trainer gets the truth.
pub(crate) enum Recipient {
    Brain(Deliveries),
    Trainer(mpsc::Sender<Told>),
}

impl Recipient {
    /// Places in the stream that are free.
    pub(crate) fn capacity(&self) -> usize {
        match self {
            Self::Brain(deliveries) => deliveries.queue.capacity(),
            Self::Trainer(told) => told.capacity(),
        }
    }

    /// Deliveries that it has not read yet.
    pub(crate) fn waiting(&self) -> usize {
        match self {
            Self::Brain(deliveries) => deliveries.queue.max_capacity() - deliveries.queue.capacity(),
            Self::Trainer(told) => told.max_capacity() - told.capacity(),
        }
    }

    /// Gives the Turn of this number; `false` if there is no room for it, or the recipient has gone.
    pub(crate) fn turn(&self, number: u64, turn: Bytes, truth: impl FnOnce() -> Truth) -> bool {
        match self {
            Self::Brain(deliveries) => deliveries.turn(number, turn),
            Self::Trainer(told) => told.try_send(Told::Turn(turn, truth().into())).is_ok(),
        }
    }

    /// Turns up to this number are of a run that is over: a brain that has not been given them is not.
    pub(crate) fn void(&self, number: u64) {
        match self {
            Self::Brain(deliveries) => deliveries.void.store(number, Ordering::Relaxed),
            // The trainers' service knows the era of each.
            Self::Trainer(_) => {}
        }
    }

    /// Sends the end of the run.
    pub(crate) fn ended(&self, tick: u64, truth: impl FnOnce() -> Truth) {
        // A recipient that is gone, or has not read hundreds of Turns, gets no end.
        match self {
            Self::Brain(deliveries) => drop(deliveries.queue.try_send(Delivery::Ended { tick })),
            Self::Trainer(told) => drop(told.try_send(Told::Ended(truth().into()))),
        }
    }

    /// Ends the stream.
    pub(crate) fn close(&self, status: Status) {
        match self {
            Self::Brain(deliveries) => drop(deliveries.queue.try_send(Delivery::Close(status))),
            Self::Trainer(told) => drop(told.try_send(Told::Close(status))),
        }
    }
}

/// The queue of deliveries to a brain. Clones lead to the same one.
#[derive(Clone)]
pub(crate) struct Deliveries {
    queue: mpsc::Sender<Delivery>,
    /// Turns up to this number are void.
    void: Arc<AtomicU64>,
    /// Bytes of the Turns that wait.
    bytes: Arc<AtomicU64>,
}

/// Bytes of Turns that wait for a brain, unless it is a single one.
const MOST_BYTES: u64 = 16 << 20;

impl Deliveries {
    /// The queue and the stream for a number of deliveries that may wait. The stream leaves out Turns that have become
    /// void while they waited.
    pub(crate) fn new(places: usize) -> (Self, impl Stream<Item = Delivery> + Send) {
        let (queue, waiting) = mpsc::channel(places);
        let this = Self { queue, void: Arc::default(), bytes: Arc::default() };
        let (void, bytes) = (Arc::clone(&this.void), Arc::clone(&this.bytes));
        let is_good = move |delivery: &Delivery| match delivery {
            Delivery::Turn { number, turn } => {
                bytes.fetch_sub(turn.len() as u64, Ordering::Relaxed);
                *number > void.load(Ordering::Relaxed)
            }
            Delivery::Ended { .. } | Delivery::Close(_) => true,
        };
        (this, ReceiverStream::new(waiting).filter(is_good))
    }

    /// Gives the Turn of this number; `false` if there is no room for it, or the recipient has gone.
    fn turn(&self, number: u64, turn: Bytes) -> bool {
        let bytes = turn.len() as u64;
        let waiting = self.bytes.fetch_add(bytes, Ordering::Relaxed);
        let fits = waiting == 0 || waiting + bytes <= MOST_BYTES;
        let is_sent = fits && self.queue.try_send(Delivery::Turn { number, turn }).is_ok();
        if !is_sent {
            self.bytes.fetch_sub(bytes, Ordering::Relaxed);
        }
        is_sent
    }

    /// Ends the stream.
    pub(crate) fn close(&self, status: Status) {
        let _ = self.queue.try_send(Delivery::Close(status));
    }

    /// Waits until the recipient has gone.
    pub(crate) async fn closed(&self) {
        self.queue.closed().await;
    }
}

/// A delivery to a brain.
pub(crate) enum Delivery {
    /// The Turn of this number, in the bytes that go over the network.
    Turn {
        number: u64,
        turn: Bytes,
    },
    Ended {
        tick: u64,
    },
    Close(Status),
}

/// A delivery to a trainer.
pub(crate) enum Told {
    /// The Turn of a brain, and the truth at the start of its tick.
    Turn(Bytes, Box<Truth>),
    Ended(Box<Truth>),
    Close(Status),
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt as _;

    use super::*;

    #[test]
    fn turns_that_become_void_while_they_wait_are_not_told_and_too_many_bytes_are_lost() {
        let (deliveries, stream) = Deliveries::new(300);
        let mut stream = std::pin::pin!(stream);
        let turn = |bytes: usize| Bytes::from(vec![0; bytes]);
        assert!((1..=5).all(|number| deliveries.turn(number, turn(10))));
        let recipient = Recipient::Brain(deliveries.clone());
        recipient.void(5);
        assert!(deliveries.turn(6, turn(10)));
        deliveries.close(Status::aborted("the end"));
        let mut next = || stream.next().now_or_never().flatten();
        assert!(matches!(next(), Some(Delivery::Turn { number: 6, .. })));
        assert!(matches!(next(), Some(Delivery::Close(_))));
        assert!(deliveries.turn(7, turn(20 << 20)), "a single one");
        assert!(!deliveries.turn(8, turn(1)));
        next();
        assert!(deliveries.turn(9, turn(1)), "it has been read");
    }
}
