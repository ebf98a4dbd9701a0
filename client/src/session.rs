//! One stream with its robots: the handshake, then turns and the answers to them.

use std::sync::Arc;
use std::time::Duration;

use tonic::transport::Channel;

use crate::body::Body;
use crate::brain::Action;
use crate::convert;
use crate::error::Error;
use crate::stream::Stream;
use crate::turn::Reading;

/// Who attaches to what.
#[derive(Clone, Debug)]
pub(crate) struct Hello {
    pub(crate) world: String,
    pub(crate) robots: Vec<String>,
    pub(crate) raw: bool,
    pub(crate) brain: String,
    pub(crate) memory_bytes: Option<u64>,
}

/// What the server says of the world and the bodies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Welcome {
    pub(crate) step_ns: u64,
    pub(crate) lockstep: bool,
    pub(crate) bodies: Vec<Arc<Body>>,
}

/// What the server says after that.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Event {
    Turn { number: u64, tick: u64, parts: Vec<Part> },
    Ended,
}

/// One robot's part of a turn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) robot: usize,
    pub(crate) at_ns: u64,
    pub(crate) bytes: Vec<u8>,
    pub(crate) ports: Vec<(usize, Vec<u8>)>,
    pub(crate) readings: Vec<Option<Reading>>,
}

/// One robot's part of an answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Answer<'a> {
    Act(&'a Action),
    Write { bytes: &'a [u8], thinking: Option<Duration>, operations: Option<u64> },
}

/// An attached stream.
#[derive(Debug)]
pub(crate) struct Session {
    stream: Stream,
    welcome: Welcome,
    /// Number of the last turn.
    number: u64,
    /// Whether that turn still waits for its answer.
    owes_answer: bool,
}

impl Session {
    pub(crate) async fn open(channel: Channel, hello: &Hello) -> Result<Self, Error> {
        let mut stream = Stream::open(channel, convert::hello(hello)).await?;
        let welcome = convert::welcome(stream.receive().await?, &hello.robots)?;
        Ok(Self { stream, welcome, number: 0, owes_answer: false })
    }

    pub(crate) fn welcome(&self) -> &Welcome {
        &self.welcome
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.stream.is_closed()
    }

    /// The next tick and the turns in it; `None` when the run is over or the stream is closed. A turn that
    /// was not answered is answered with nothing first, because in lockstep the world waits for it; that is
    /// done in every pace, as an operator may change to lockstep at any time.
    pub(crate) async fn turn(&mut self) -> Result<Option<(u64, Vec<Part>)>, Error> {
        if self.owes_answer {
            self.answer(&[]).await?;
        }
        let Some(response) = self.stream.receive().await? else { return Ok(None) };
        match convert::event(response, &self.welcome.bodies)? {
            Event::Ended => Ok(None),
            Event::Turn { number, tick, parts } => {
                self.number = number;
                self.owes_answer = true;
                Ok(Some((tick, parts)))
            }
        }
    }

    /// Answers the last turn.
    pub(crate) async fn answer(&mut self, answers: &[(usize, Answer<'_>)]) -> Result<(), Error> {
        self.owes_answer = false;
        Ok(self.stream.send(convert::step(self.number, answers)).await?)
    }
}
