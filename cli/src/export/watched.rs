//! The writers of `baudbot run`, which send their result by a channel.

use std::io;

use baudbot_sim::World;
use tokio::sync::oneshot;
use tokio::sync::oneshot::error::TryRecvError;

use super::pass::{Sink, lost};

/// A writer with its channel.
pub(super) struct Watched<W> {
    writer: W,
    outcome: oneshot::Receiver<io::Result<()>>,
    write: fn(&mut W, &World),
}

impl<W> Watched<W> {
    pub(super) fn new(
        (writer, outcome): (W, oneshot::Receiver<io::Result<()>>),
        write: fn(&mut W, &World),
    ) -> Self {
        Self { writer, outcome, write }
    }
}

impl<W> Sink for Watched<W> {
    fn tick(&mut self, world: &World) -> io::Result<()> {
        (self.write)(&mut self.writer, world);
        match self.outcome.try_recv() {
            Ok(outcome) => outcome,
            Err(TryRecvError::Empty) => Ok(()),
            Err(TryRecvError::Closed) => Err(lost()),
        }
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        let Self { writer, mut outcome, .. } = *self;
        // The end is signalled when the writer is dropped.
        drop(writer);
        outcome.try_recv().unwrap_or_else(|_| Err(lost()))
    }
}
