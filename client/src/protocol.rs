//! The messages of an Attach stream: what is asked and answered, and what comes.

use std::sync::Arc;
use std::time::Duration;

use baudbot_brain::{Action, Belief, Body, Reading, Turn, Until};
use baudbot_proto::convert::{self, Breach};
use baudbot_proto::v1;
use baudbot_proto::v1::attach_request::Request;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::robot_step::Output;

/// The server's description of the world and the bodies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Welcome {
    pub(crate) step_ns: u64,
    pub(crate) lockstep: bool,
    pub(crate) bodies: Vec<Arc<Body>>,
}

/// A later message of the server.
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
    /// A message of the microcontroller has come, with new readings or without.
    pub(crate) has_message: bool,
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
    /// The brain was not asked, or did not answer.
    Nothing,
}

/// The first request.
pub(crate) fn hello(hello: v1::Hello) -> v1::AttachRequest {
    request(Request::Hello(hello))
}

/// The answer to a turn.
pub(crate) fn step<'a>(turn: u64, answers: impl Iterator<Item = (usize, Answer<'a>)>) -> v1::AttachRequest {
    let robots = answers.map(|(robot, answer)| robot_step(robot, &answer)).collect();
    request(Request::Step(v1::Step { turn, robots }))
}

/// The request that publishes a robot's belief.
pub(crate) fn annotate(robot: usize, belief: Belief) -> v1::AttachRequest {
    request(Request::Annotate(v1::Annotate { robot: robot as u32, belief: Some(belief.into()) }))
}

/// Reads the answer to the Hello for `robots`.
pub(crate) fn welcome(response: Option<v1::AttachResponse>, robots: &[String]) -> Result<Welcome, Breach> {
    let found = match response {
        None => "the end of the stream",
        Some(response) => match response.response {
            Some(Response::Welcome(welcome)) => return accept(welcome, robots),
            other => name(other.as_ref()),
        },
    };
    Err(Breach::Expected { expected: "a Welcome", found })
}

/// Reads an answer after the Welcome with these `bodies`.
pub(crate) fn event(response: v1::AttachResponse, bodies: &[Arc<Body>]) -> Result<Event, Breach> {
    match response.response {
        Some(Response::Ended(_)) => Ok(Event::Ended),
        Some(Response::Turn(turn)) => {
            let parts = turn.robots.into_iter().map(|turn| part(turn, bodies));
            Ok(Event::Turn { number: turn.turn, tick: turn.tick, parts: parts.collect::<Result<_, _>>()? })
        }
        other => Err(Breach::Expected { expected: "a Turn or Ended", found: name(other.as_ref()) }),
    }
}

pub(crate) fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

impl Answer<'_> {
    /// The condition that the brain waits for now.
    pub(crate) fn until(&self) -> Option<Until> {
        match self {
            Self::Act(action) => action.until,
            Self::Write { until, .. } => *until,
            Self::Sleep(until) => Some(*until),
            Self::Nothing => None,
        }
    }
}

impl Part {
    pub(crate) fn has_news(&self) -> bool {
        let is_new = |reading: &Option<Reading>| reading.as_ref().is_some_and(|reading| reading.readable);
        let has_bytes = !self.bytes.is_empty() || !self.ports.is_empty();
        self.has_message || has_bytes || self.readings.iter().any(is_new)
    }

    /// The turn for the brain of the robot, which has this body.
    pub(crate) fn turn(self, tick: u64, body: Arc<Body>) -> Turn {
        Turn { tick, at_ns: self.at_ns, readings: self.readings, body, has_message: self.has_message }
    }
}

fn request(request: Request) -> v1::AttachRequest {
    v1::AttachRequest { request: Some(request) }
}

fn robot_step(robot: usize, answer: &Answer<'_>) -> v1::RobotStep {
    let step = match *answer {
        Answer::Act(action) => v1::RobotStep::from(action),
        Answer::Write { bytes, thinking, operations, until } => v1::RobotStep {
            robot: 0,
            thinking_ns: thinking.map(nanoseconds),
            output: Some(Output::Raw(bytes.to_vec())),
            operations,
            until_message: until.map(Into::into),
            opened: false,
            ports: Vec::new(),
        },
        Answer::Sleep(until) => {
            v1::RobotStep { until_message: Some(until.into()), ..v1::RobotStep::default() }
        }
        Answer::Nothing => v1::RobotStep::default(),
    };
    v1::RobotStep { robot: u32::try_from(robot).unwrap_or(u32::MAX), ..step }
}

fn name(response: Option<&Response>) -> &'static str {
    match response {
        Some(Response::Welcome(_)) => "a Welcome",
        Some(Response::Turn(_)) => "a Turn",
        Some(Response::Ended(_)) => "Ended",
        None => "an empty response",
    }
}

fn accept(welcome: v1::Welcome, robots: &[String]) -> Result<Welcome, Breach> {
    let v1::Welcome { step_ns, lockstep, robots: described } = welcome;
    if !described.iter().map(|body| &body.robot).eq(robots) {
        let described = described.into_iter().map(|body| body.robot).collect();
        return Err(Breach::Robots { asked: robots.to_vec(), described });
    }
    let bodies = described.into_iter().map(|described| Body::try_from(described).map(Arc::new));
    Ok(Welcome { step_ns, lockstep, bodies: bodies.collect::<Result<_, _>>()? })
}

fn part(turn: v1::RobotTurn, bodies: &[Arc<Body>]) -> Result<Part, Breach> {
    let (robot, body) = convert::item(bodies, turn.robot, "robot")?;
    let readings = convert::readings(turn.readings, body)?;
    let ports = convert::ports(turn.ports, body)?;
    let has_message = turn.has_message;
    Ok(Part { robot, at_ns: turn.at_ns, bytes: turn.raw, ports, readings, has_message })
}
