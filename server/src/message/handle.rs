//! The handle of a world.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use baudbot_sim::Scenario;
use tokio::sync::oneshot;
use tonic::Status;

use super::{Message, Order, Request};
use crate::answers::Answers;
use crate::audit::call::by;
use crate::limits::{Exceeded, Held, InForce};
use crate::mailbox::Mailbox;
use crate::report::Report;

/// Sends messages to a world. Clones lead to the same world.
#[derive(Clone)]
pub(crate) struct WorldHandle {
    name: Arc<str>,
    made: Arc<Scenario>,
    limits: InForce,
    /// The bytes of its state.
    bytes: Arc<AtomicU64>,
    mailbox: Arc<Mailbox<Message>>,
    answers: Arc<Answers>,
}

impl WorldHandle {
    /// The handle of the world of this name, which was made of this scenario. It counts the bytes of its state, on a
    /// server with these limits.
    pub(crate) fn new(
        name: Arc<str>,
        made: Arc<Scenario>,
        (limits, bytes): (InForce, Arc<AtomicU64>),
        mailbox: Arc<Mailbox<Message>>,
    ) -> Self {
        Self { name, made, limits, bytes, mailbox, answers: Arc::default() }
    }

    /// The limits of its server.
    pub(crate) fn limits(&self) -> &InForce {
        &self.limits
    }

    /// The answers that are made once for many.
    pub(crate) fn answers(&self) -> &Answers {
        &self.answers
    }

    /// Memory for a copy of its state.
    ///
    /// # Errors
    /// If there is not so much.
    pub(crate) fn room_for_copy(&self) -> Result<Held, Exceeded> {
        self.limits.hold(self.bytes.load(Ordering::Relaxed))
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The scenario that the world was made of. Manual changes and resets with other numbers have altered it since.
    pub(crate) fn made(&self) -> &Arc<Scenario> {
        &self.made
    }

    /// Whether the world is over.
    pub(crate) fn is_over(&self) -> bool {
        self.mailbox.is_closed()
    }

    /// Sends a message.
    ///
    /// # Errors
    /// `ABORTED` if the world is over.
    pub(crate) fn send(&self, message: Message) -> Result<(), Status> {
        if self.mailbox.post(message) { Ok(()) } else { Err(self.gone()) }
    }

    /// Sends a message and waits for its answer.
    ///
    /// # Errors
    /// `ABORTED` if the world is over before it has answered.
    pub(crate) async fn ask<T>(
        &self,
        message: impl FnOnce(oneshot::Sender<T>) -> Message,
    ) -> Result<T, Status> {
        let (reply, answer) = oneshot::channel();
        self.send(message(reply))?;
        answer.await.map_err(|_| self.gone())
    }

    /// Sends a request of an operator and waits for the report.
    ///
    /// # Errors
    /// `ABORTED` if the world is over, or why the world refuses the request.
    pub(crate) async fn request(&self, request: Request) -> Result<Report, Status> {
        if let Some(what) = request.order()
            && let Some(by) = by()
        {
            self.send(Message::Order(Order { by, what }))?;
        }
        self.ask(|reply| Message::Request(request, reply)).await?
    }

    fn gone(&self) -> Status {
        Status::aborted(format!("world `{}` was deleted", self.name))
    }
}
