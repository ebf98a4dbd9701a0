//! One robot, in messages.

use std::sync::Arc;
use std::time::Duration;

use baudbot_brain::{Action, Belief, Body, Signals, Turn};

use crate::error::Error;
use crate::protocol::Answer;
use crate::session::Session;

/// A robot that this program holds; the server en- and decodes the bytes of its cable.
#[derive(Debug)]
pub struct Robot {
    session: Session,
}

impl Robot {
    pub(crate) fn new(session: Session) -> Self {
        Self { session }
    }

    /// The interval at which its brain's beliefs are published.
    pub(crate) fn publishes_every_ns(&self) -> u64 {
        self.session.publishes_every_ns
    }

    /// The robot's data sheet.
    pub fn body(&self) -> &Arc<Body> {
        // A Welcome has as many bodies as the Hello has robots, which was one.
        &self.session.welcome().bodies[0]
    }

    /// Length of the world's tick, in nanoseconds.
    pub fn step_ns(&self) -> u64 {
        self.session.welcome().step_ns
    }

    /// Whether the world waited for its brains when this one attached.
    pub fn lockstep(&self) -> bool {
        self.session.welcome().lockstep
    }

    /// Whether the server has closed the stream, so that no turn will come.
    pub fn is_closed(&self) -> bool {
        self.session.is_closed()
    }

    /// Waits for the next turn. `None` when the run is over, or when the server has closed the stream.
    ///
    /// In lockstep the world waits for one answer to each turn. If the last turn was not answered, it is
    /// answered with nothing first, as by [`pass`](Self::pass).
    ///
    /// After the end of a run the operator may reset the world: unless the stream
    /// [is closed](Self::is_closed), another call waits for the first turn of the next run.
    ///
    /// # Errors
    /// [`Error::Status`] if the server ends the stream with an error (the world was deleted, the watchdog
    /// lost patience, the operator has thrown the brain off), [`Error::Restart`] if the operator wants it to start over,
    /// [`Error::Lost`] if the connection broke, [`Error::Protocol`] if the server breaks the contract.
    pub async fn turn(&mut self) -> Result<Option<Turn>, Error> {
        loop {
            let Some((tick, mut parts)) = self.session.turn().await? else { return Ok(None) };
            // A turn without a part for the only robot needs no answer: the next turn follows.
            if let Some(part) = parts.pop() {
                let body = Arc::clone(self.body());
                return Ok(Some(part.turn(tick, body)));
            }
        }
    }

    /// Answers the turn with signals for the motors, which stay in force until others arrive.
    ///
    /// # Errors
    /// [`Error::Status`] if the server has ended the stream with an error. One that has closed it in good
    /// order gets no more answers; [`turn`](Self::turn) then gives `None`.
    pub async fn drive(&mut self, signals: Signals) -> Result<(), Error> {
        self.act(Action { signals: Some(signals), ..Action::wait() }).await
    }

    /// Answers the turn with signals for the motors after so much simulated time of thought.
    ///
    /// # Errors
    /// As [`drive`](Self::drive).
    pub async fn drive_after(&mut self, thinking: Duration, signals: Signals) -> Result<(), Error> {
        self.act(Action { signals: Some(signals), ..Action::wait() }.after(thinking)).await
    }

    /// Answers the turn with nothing.
    ///
    /// # Errors
    /// As [`drive`](Self::drive).
    pub async fn pass(&mut self) -> Result<(), Error> {
        self.act(Action::wait()).await
    }

    /// Answers the turn with a request for readings, for a firmware that speaks only when asked.
    ///
    /// # Errors
    /// As [`drive`](Self::drive).
    pub async fn poll(&mut self) -> Result<(), Error> {
        self.act(Action::poll()).await
    }

    /// Answers the turn with what a brain chose to do.
    ///
    /// # Errors
    /// As [`drive`](Self::drive).
    pub async fn act(&mut self, action: Action) -> Result<(), Error> {
        self.session.answer(&[(0, Answer::Act(&action))]).await
    }

    /// Shows people what the brain believes and does. It costs no time on the cable and changes nothing in the world; of
    /// what is published faster than people look, they see the newest. In lockstep, publish before the answer to a turn: then
    /// it is in the next tick's frame, where after the answer it may be late.
    ///
    /// # Errors
    /// As [`drive`](Self::drive). A belief of more than 256 KiB ends the stream.
    pub async fn publish(&mut self, belief: Belief) -> Result<(), Error> {
        self.session.publish(0, belief).await
    }
}
