//! One stream with its robots: the handshake, then turns and the answers to them.

use std::sync::Arc;
use std::time::Duration;

use baudbot_brain::{Action, Belief, Body, Reading, Until};
use tonic::transport::Channel;

use crate::client::Client;
use crate::convert;
use crate::error::Error;
use crate::stream::Stream;

/// Who attaches to what.
#[derive(Clone, Debug)]
pub(crate) struct Hello {
    pub(crate) world: String,
    pub(crate) robots: Vec<String>,
    pub(crate) raw: bool,
    pub(crate) brain: String,
    pub(crate) memory_bytes: Option<u64>,
    pub(crate) thinks_as_scenario: bool,
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
    Write {
        bytes: &'a [u8],
        thinking: Option<Duration>,
        operations: Option<u64>,
        until: Option<Until>,
    },
    /// The brain waits, and nothing has come.
    Sleep(Until),
    /// The brain was not asked, or said nothing.
    Nothing,
}

impl Answer<'_> {
    /// What the brain waits for now.
    pub(crate) fn until(&self) -> Option<Until> {
        match self {
            Self::Act(action) => action.until,
            Self::Write { until, .. } => *until,
            Self::Sleep(until) => Some(*until),
            Self::Nothing => None,
        }
    }
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
    /// Its tick.
    tick: u64,
    /// The robots whose brains wait for news.
    waiting: Vec<Option<Until>>,
    /// Those among them that have a part in the last turn, but no news.
    asleep: Vec<usize>,
    /// The others that have a part in it.
    asked: Vec<usize>,
    /// The server was promised an answer for each robot that has a part in a turn.
    answers_all: bool,
    /// How often its brains publish what they believe, in nanoseconds of simulated time.
    pub(crate) publishes_every_ns: u64,
}

impl Session {
    pub(crate) async fn open(channel: Channel, hello: &Hello) -> Result<Self, Error> {
        let mut stream = Stream::open(channel, convert::hello(hello)).await?;
        let welcome = convert::welcome(stream.receive().await?, &hello.robots)?;
        let waiting = vec![None; welcome.bodies.len()];
        Ok(Self {
            stream,
            welcome,
            number: 0,
            owes_answer: false,
            tick: 0,
            waiting,
            asleep: Vec::new(),
            asked: Vec::new(),
            answers_all: hello.thinks_as_scenario,
            publishes_every_ns: convert::nanoseconds(Client::LOOKS_EVERY),
        })
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
        loop {
            if self.owes_answer {
                self.answer(&[]).await?;
            }
            let Some(response) = self.stream.receive().await? else { return Ok(None) };
            let Event::Turn { number, tick, mut parts } = convert::event(response, &self.welcome.bodies)?
            else {
                self.waiting.fill(None);
                return Ok(None);
            };
            if tick <= self.tick {
                // The world went back in time, and what was waited for there means nothing here.
                self.waiting.fill(None);
            }
            (self.number, self.tick, self.owes_answer) = (number, tick, true);
            parts.retain(|part| !self.lets_sleep(part));
            self.asked.clear();
            self.asked.extend(parts.iter().map(|part| part.robot));
            if self.asleep.is_empty() || !parts.is_empty() {
                return Ok(Some((tick, parts)));
            }
        }
    }

    /// A server may ask brains that wait, and does if it does not look ahead.
    fn lets_sleep(&mut self, part: &Part) -> bool {
        let sleeps =
            self.waiting[part.robot].is_some_and(|until| !part.has_news() && !until.is_over(part.at_ns));
        if sleeps {
            self.asleep.push(part.robot);
        } else {
            self.waiting[part.robot] = None;
        }
        sleeps
    }

    /// Answers the last turn.
    pub(crate) async fn answer(&mut self, answers: &[(usize, Answer<'_>)]) -> Result<(), Error> {
        self.owes_answer = false;
        let waiting = &mut self.waiting;
        for (robot, answer) in answers {
            if let Some(waiting) = waiting.get_mut(*robot) {
                *waiting = answer.until();
            }
        }
        let asleep = self.asleep.drain(..).filter_map(|robot| Some((robot, Answer::Sleep(waiting[robot]?))));
        let left_out = |robot: &&usize| self.answers_all && !answers.iter().any(|(other, _)| other == *robot);
        let silent = self.asked.iter().filter(left_out).map(|&robot| (robot, Answer::Nothing));
        let step = convert::step(self.number, answers.iter().cloned().chain(asleep).chain(silent));
        Ok(self.stream.send(step).await?)
    }

    /// Shows people what a robot's brain believes.
    pub(crate) async fn publish(&mut self, robot: usize, belief: Belief) -> Result<(), Error> {
        Ok(self.stream.send(convert::annotate(robot, belief)).await?)
    }
}

impl Part {
    fn has_news(&self) -> bool {
        let is_new = |reading: &Option<Reading>| reading.as_ref().is_some_and(|reading| reading.readable);
        !self.bytes.is_empty() || !self.ports.is_empty() || self.readings.iter().any(is_new)
    }
}
