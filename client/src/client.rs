//! A connection to a server, from which brains attach to robots.

use std::time::Duration;

use baudbot_proto::v1;

use crate::channel::Channel;
use crate::error::Error;
use crate::fleet::Fleet;
use crate::protocol;
use crate::raw::RawRobot;
use crate::robot::Robot;
use crate::session::Session;

/// A connection to a server. Clones share it.
#[derive(Clone, Debug)]
pub struct Client {
    channel: Channel,
    brain: String,
    memory_bytes: Option<u64>,
    thinks_as_scenario: bool,
    publishes_every: Duration,
}

impl Client {
    /// The default interval at which brains publish their beliefs: people see no more than some 20 pictures a second
    /// as such.
    pub const LOOKS_EVERY: Duration = Duration::from_millis(50);

    /// A client of the server at the other end of `channel`, such as one in the same process.
    pub fn from_channel(channel: impl Into<Channel>) -> Self {
        Self {
            channel: channel.into(),
            brain: "brain".to_owned(),
            memory_bytes: None,
            thinks_as_scenario: false,
            publishes_every: Self::LOOKS_EVERY,
        }
    }

    /// The connection, for clients of the server's other services.
    pub fn channel(&self) -> Channel {
        self.channel.clone()
    }

    /// The name, at most 64 characters, under which brains attach from now on; people see it, nothing else
    /// depends on it.
    #[must_use]
    pub fn brain(self, name: impl Into<String>) -> Self {
        Self { brain: name.into(), ..self }
    }

    /// Memory, in bytes, that the program's variables need on each robot to which it attaches from now on. Only
    /// for robots that are [onboard](crate::Body::onboard); others refuse (`InvalidArgument`), and so does one
    /// that has not as much (`ResourceExhausted`).
    #[must_use]
    pub fn memory_bytes(self, bytes: u64) -> Self {
        Self { memory_bytes: Some(bytes), ..self }
    }

    /// Promises that the brains which attach from now on never declare how long they thought: neither
    /// [`Action::thinking`](crate::Action::thinking) nor [`Action::operations`](crate::Action::operations) is set. It is
    /// then known when a brain is done before it has answered, and a world in lockstep can go on meanwhile, as far as the
    /// answer cannot have reached its robot. A brain that breaks the promise is thrown out (`FailedPrecondition`).
    #[must_use]
    pub fn thinks_as_scenario(self) -> Self {
        Self { thinks_as_scenario: true, ..self }
    }

    /// Sets the interval, in simulated time, at which [`run`](crate::run) and [`run_fleet`](crate::run_fleet) publish
    /// the beliefs of brains that attach from now on; [`LOOKS_EVERY`](Self::LOOKS_EVERY) by default. A recording that
    /// is to show each step needs more.
    #[must_use]
    pub fn publishes_every(self, every: Duration) -> Self {
        Self { publishes_every: every, ..self }
    }

    /// Takes hold of a robot. It is released when the [`Robot`] is dropped.
    ///
    /// # Errors
    /// [`Error::Status`] if there is no such world or robot (`NotFound`) or another brain holds it
    /// (`AlreadyExists`); [`Error::Protocol`] if the server breaks the contract.
    pub async fn attach(&self, world: &str, robot: &str) -> Result<Robot, Error> {
        Ok(Robot::new(self.session(world, &[robot], false).await?))
    }

    /// Takes hold of several robots of a world with one stream: their turns come, and the answers go, in
    /// one message a tick.
    ///
    /// # Errors
    /// As [`attach`](Self::attach).
    pub async fn attach_many(&self, world: &str, robots: &[&str]) -> Result<Fleet, Error> {
        Ok(Fleet::new(self.session(world, robots, false).await?))
    }

    /// Takes hold of a robot whose brain reads and writes the bytes of the wire itself.
    ///
    /// # Errors
    /// As [`attach`](Self::attach).
    pub async fn attach_raw(&self, world: &str, robot: &str) -> Result<RawRobot, Error> {
        Ok(RawRobot::new(self.session(world, &[robot], true).await?))
    }

    async fn session(&self, world: &str, robots: &[&str], raw: bool) -> Result<Session, Error> {
        let mode = if raw { v1::PortMode::Raw } else { v1::PortMode::Messages };
        let hello = v1::Hello {
            world: world.to_owned(),
            robots: robots.iter().map(|&robot| robot.to_owned()).collect(),
            mode: mode.into(),
            brain: self.brain.clone(),
            memory_bytes: self.memory_bytes,
            thinks_as_scenario: self.thinks_as_scenario,
            stop_when_gone: false,
            serial_port: false,
        };
        Session::open(self.channel.clone(), hello, protocol::nanoseconds(self.publishes_every)).await
    }
}
