//! Brains as `--brain` arguments name them.

use baudbot_brains::catalogue;
use baudbot_client::{Client, Summary};
use baudbot_experiment::crew::{self, CrewError};
use baudbot_sim::robot::RobotSpec;

pub(crate) use baudbot_experiment::crew::{Job, fitting_brain};

use crate::error::Refused;

/// Shares the robots out to the brains that `--brain` arguments name.
pub(crate) fn share_out(arguments: &[String], robots: &[RobotSpec]) -> anyhow::Result<Vec<Job>> {
    crew::share_out(arguments, robots).map_err(|error| match error {
        CrewError::Blind { robot } => Refused::error(format!(
            "robot `{robot}` has no IR sensors, so that the default brain `{}` cannot drive it; give it another \
             with --brain {robot}=NAME (`baudbot brain --list` lists them; `none` is no brain)",
            crew::DEFAULT
        )),
        error => Refused::error(format!("--brain: {error}")),
    })
}

/// A job that is being done.
pub(crate) struct Crew(crew::Crew);

impl Crew {
    /// Takes hold of the robots and makes their brains.
    pub(crate) async fn attach(client: Client, world: &str, job: Job, seed: u64) -> anyhow::Result<Self> {
        match crew::Crew::attach(client, world, job, seed).await {
            Ok(crew) => Ok(Self(crew)),
            Err(CrewError::Brain(error)) => Err(Refused::error(error.to_string())),
            Err(error) => Err(error.into()),
        }
    }

    /// Drives the robots until the run is over or the server closes the stream.
    pub(crate) async fn run(&mut self) -> anyhow::Result<Summary> {
        let summary = self.0.run().await;
        summary
            .map_err(|error| anyhow::Error::from(error).context(format!("brain `{}` failed", self.0.brain())))
    }

    /// Whether the server has closed the stream.
    pub(crate) fn is_closed(&self) -> bool {
        self.0.is_closed()
    }
}

/// Refuses a brain that is not there, or whose file is wrong, before anything is started for it.
pub(crate) fn check_name(description: &str) -> anyhow::Result<()> {
    catalogue::check(description).map_err(|error| Refused::error(error.to_string()))
}
