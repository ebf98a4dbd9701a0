//! Brains of the repertoire, which drive robots as clients of the server.

use std::fs;
use std::io;

use baudbot_brains::catalogue::{self, CatalogueError};
use baudbot_client::{Brain, Channel, Client, Error, Fleet, run_fleet};
use baudbot_server::Services;
use serde::Deserialize;

/// Which brain drives which robots.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Assignment {
    world: String,
    robots: Vec<String>,
    /// As the catalogue has it: `NAME[:K=V,…]`; not needed with a text.
    #[serde(default)]
    brain: String,
    /// A brain that is described in TOML.
    text: Option<String>,
}

/// Why a brain does not drive.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BrainError {
    #[error(transparent)]
    Client(#[from] Error),
    #[error(transparent)]
    Brain(#[from] CatalogueError),
    #[error("the text of the brain: {0}")]
    File(#[from] io::Error),
}

/// A brain that holds its robots.
pub(crate) struct Driver {
    services: Services,
    assignment: Assignment,
    fleet: Fleet,
    brains: Vec<Box<dyn Brain + Send>>,
}

impl Driver {
    /// Takes hold of the robots and makes their brains, with the seed of the world, as `baudbot run` does.
    ///
    /// # Errors
    /// If the server refuses, or the catalogue has no such brain for a robot.
    pub(crate) async fn attach(services: Services, mut assignment: Assignment) -> Result<Self, BrainError> {
        if assignment.text.is_some() {
            assignment.brain = OWN.to_owned();
        }
        let robots: Vec<_> = assignment.robots.iter().map(String::as_str).collect();
        let client = Client::from_channel(Channel::to(services.clone()))
            .brain(catalogue::shown_name(&assignment.brain));
        // No brain of the catalogue says how long it thought.
        let fleet = client.thinks_as_scenario().attach_many(&assignment.world, &robots).await?;
        if let Some(text) = &assignment.text {
            // The catalogue reads such brains from files, and says of which file and line an error is. Nothing is waited for until it has
            // read this one, as that of another brain may be written then.
            fs::write(OWN, text)?;
        }
        let seed = services.seed(&assignment.world).await.map_err(Error::from)?;
        let make = |body| catalogue::brain(&assignment.brain, seed, body);
        let brains = fleet.bodies().iter().map(|body| make(body)).collect::<Result<_, _>>()?;
        Ok(Self { services, assignment, fleet, brains })
    }

    /// Drives until the stream is closed, over the ends of runs. Brains that the operator restarts are made again.
    ///
    /// # Errors
    /// If the stream fails, such as when the brain is thrown off.
    pub(crate) async fn drive(mut self) -> Result<(), BrainError> {
        while !self.fleet.is_closed() {
            match run_fleet(&mut self.fleet, &mut self.brains).await {
                Ok(_) => {}
                Err(Error::Restart) => self = Self::attach(self.services, self.assignment).await?,
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// What it drives with.
    pub(crate) fn assignment(&self) -> &Assignment {
        &self.assignment
    }
}

impl Assignment {
    pub(crate) fn world(&self) -> &str {
        &self.world
    }

    pub(crate) fn robots(&self) -> &[String] {
        &self.robots
    }

    pub(crate) fn brain(&self) -> &str {
        &self.brain
    }
}

/// The file of a brain that is typed into the page.
const OWN: &str = "brain.toml";
