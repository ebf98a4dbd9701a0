//! A program that drives robots until their run is over, and comes back to a server that it has lost.

use std::fmt::Display;
use std::time::Duration;

use baudbot_brain::{Body, Brain, EachRun};
use thiserror::Error as ThisError;
use tokio::time::Instant;

use crate::comeback::come_back;
use crate::connect::{connect, connect_with};
use crate::credentials::Credentials;
use crate::error::Error;
use crate::fleet::Fleet;
use crate::reconnect::{Hope, Reconnect};
use crate::run::{Summary, run_fleet};

/// The address, the world and the robots of a program, and its conduct when it loses its server.
#[derive(Clone, Debug)]
pub struct Attachment {
    /// The server, as [`connect()`] takes it.
    pub connect: String,
    /// The credentials to show; `None` for the [credentials of the environment](Credentials::from_environment).
    pub credentials: Option<Credentials>,
    /// Name of the world.
    pub world: String,
    /// Names of the robots, which get a brain each, over one stream.
    pub robots: Vec<String>,
    /// The name under which people see the brain: [`Client::brain`](crate::Client::brain).
    pub brain: String,
    /// The promise of [`Client::thinks_as_scenario`](crate::Client::thinks_as_scenario).
    pub thinks_as_scenario: bool,
    /// The time for which to try to come back.
    pub reconnect: Reconnect,
}

/// A reason why a program no longer drives its robots. `E` is the error of making a brain.
#[derive(Debug, ThisError)]
pub enum AttachmentError<E> {
    /// The server cannot be reached, has refused, or has ended the stream with an error.
    #[error(transparent)]
    Client(#[from] Error),
    /// The server has closed the stream in good order.
    #[error("the server closed the connection before the run was over")]
    Closed,
    /// A server that was lost was not found again.
    #[error("the brain of {robots} could not reconnect: {error}")]
    NotBack {
        /// Names of the robots.
        robots: String,
        /// The error of the last attempt.
        error: Error,
    },
    /// A brain cannot be made for a robot.
    #[error("{0}")]
    Brain(E),
}

impl<E> AttachmentError<E> {
    fn may_pass(&self) -> bool {
        match self {
            Self::Client(error) => error.may_pass(),
            Self::Closed => true,
            Self::NotBack { .. } | Self::Brain(_) => false,
        }
    }
}

impl Attachment {
    /// Attaches, and drives until the run is over. `make` makes the brain of each robot from its data sheet; it is
    /// called again for each run, when the operator restarts the brain, and after a lost connection, as the world may
    /// have changed meanwhile. `tell` gets a line for people for each of the last two, and if `make` fails.
    ///
    /// # Errors
    /// If the program cannot attach, is thrown off, or loses its server and does not find it again.
    pub async fn drive<B: Brain, E: Display>(
        &self,
        make: impl Fn(&Body) -> Result<B, E>,
        tell: impl Fn(&str),
    ) -> Result<Summary, AttachmentError<E>> {
        let driving = format!("driving {} of world {}", self.names(), self.world);
        let mut attached = self.attach(&make).await?;
        tell(&driving);
        loop {
            let (mut fleet, brains) = attached;
            let again = |body: &Body| {
                make(body).inspect_err(|error| tell(&format!("a new run, but no brain for it: {error}"))).ok()
            };
            let mut brains: Vec<_> = brains.into_iter().map(|brain| EachRun::new(brain, again)).collect();
            let lost = match run_fleet(&mut fleet, &mut brains).await {
                Ok(_) if fleet.is_closed() => AttachmentError::Closed,
                Ok(summary) => return Ok(summary),
                Err(Error::Restart) => match self.attach(&make).await {
                    Ok(again) => {
                        attached = again;
                        tell(&format!("the operator has restarted the brain of {}", self.names()));
                        continue;
                    }
                    Err(error) => error,
                },
                Err(error) => error.into(),
            };
            let Reconnect::For(limit) = self.reconnect else { return Err(lost) };
            if !lost.may_pass() {
                return Err(lost);
            }
            tell(&format!("{lost}; trying to reconnect for {} s", limit.as_secs()));
            attached = self.come_back(limit, &make).await?;
            tell(&format!("reconnected with a restarted brain: {driving}"));
        }
    }

    async fn come_back<B, E>(
        &self,
        limit: Duration,
        make: impl Fn(&Body) -> Result<B, E>,
    ) -> Result<Attached<B>, AttachmentError<E>> {
        let mut hope = Hope::default();
        let may_pass = |error: &AttachmentError<E>| match error {
            AttachmentError::Client(error) => hope.is_left(error, Instant::now()),
            AttachmentError::Closed | AttachmentError::NotBack { .. } | AttachmentError::Brain(_) => false,
        };
        come_back(limit, may_pass, async || self.attach(&make).await).await.map_err(|error| match error {
            AttachmentError::Client(error) => AttachmentError::NotBack { robots: self.names(), error },
            other @ (AttachmentError::Closed
            | AttachmentError::NotBack { .. }
            | AttachmentError::Brain(_)) => other,
        })
    }

    async fn attach<B, E>(
        &self,
        make: impl Fn(&Body) -> Result<B, E>,
    ) -> Result<Attached<B>, AttachmentError<E>> {
        let client = match &self.credentials {
            Some(credentials) => connect_with(&self.connect, credentials).await?,
            None => connect(&self.connect).await?,
        };
        let mut client = client.brain(&self.brain);
        if self.thinks_as_scenario {
            client = client.thinks_as_scenario();
        }
        let robots: Vec<_> = self.robots.iter().map(String::as_str).collect();
        let fleet = client.attach_many(&self.world, &robots).await?;
        let brains = fleet.bodies().iter().map(|body| make(body)).collect::<Result<_, _>>();
        Ok((fleet, brains.map_err(AttachmentError::Brain)?))
    }

    /// The robots, for people.
    fn names(&self) -> String {
        self.robots.join(", ")
    }
}

/// Robots that are held, and a brain for each.
type Attached<B> = (Fleet, Vec<B>);
