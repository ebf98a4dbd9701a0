//! One stream with its robots: the handshake, then turns and the answers to them.

use baudbot_brain::{Belief, Until};
use baudbot_proto::v1;

use crate::channel::Channel;
use crate::error::Error;
use crate::protocol::{self, Answer, Event, Part, Welcome};
use crate::stream::Stream;

/// An attached stream.
#[derive(Debug)]
pub(crate) struct Session {
    stream: Stream,
    welcome: Welcome,
    /// Number of the last turn.
    number: u64,
    /// Whether that turn still waits for its answer.
    owes_answer: bool,
    /// The tick of the last turn.
    tick: u64,
    /// The robots whose brains wait for news.
    waiting: Vec<Option<Until>>,
    /// The robots with waiting brains that have a part in the last turn, but no news.
    asleep: Vec<usize>,
    /// The others that have a part in it.
    asked: Vec<usize>,
    /// The server was promised an answer for each robot that has a part in a turn.
    answers_all: bool,
    /// The interval at which its brains publish their beliefs, in nanoseconds of simulated time.
    pub(crate) publishes_every_ns: u64,
}

impl Session {
    /// Opens the stream with this Hello. `publishes_every_ns`: how often the brains publish what they believe, in
    /// nanoseconds of simulated time.
    pub(crate) async fn open(
        channel: Channel,
        hello: v1::Hello,
        publishes_every_ns: u64,
    ) -> Result<Self, Error> {
        let (robots, answers_all) = (hello.robots.clone(), hello.thinks_as_scenario);
        let mut stream = Stream::open(channel, protocol::hello(hello)).await?;
        let welcome = protocol::welcome(stream.receive().await?, &robots)?;
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
            answers_all,
            publishes_every_ns,
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
            if response.response.is_none() {
                // It is of a kind that a later version of the contract has.
                continue;
            }
            let Event::Turn { number, tick, mut parts } = protocol::event(response, &self.welcome.bodies)?
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
        let step = protocol::step(self.number, answers.iter().cloned().chain(asleep).chain(silent));
        Ok(self.stream.send(step).await?)
    }

    /// Shows people what a robot's brain believes.
    pub(crate) async fn publish(&mut self, robot: usize, belief: Belief) -> Result<(), Error> {
        Ok(self.stream.send(protocol::annotate(robot, belief)).await?)
    }
}
