//! Brains as `--brain` arguments name them.

use anyhow::Context;
use baudbot_brains::catalogue;
use baudbot_client::{Client, Error, Summary};
use baudbot_experiment::crew::{self, CrewError};
use baudbot_sim::model::RobotSpec;

pub(crate) use baudbot_experiment::crew::{Job, fitting_brain};

use crate::error::Refused;

/// Shares the robots out to the brains that `--brain` arguments name.
pub(crate) fn share_out(arguments: &[String], robots: &[RobotSpec]) -> anyhow::Result<Vec<Job>> {
    crew::share_out(arguments, robots).map_err(|error| {
        Refused::error(if let CrewError::Blind { robot } = error {
            format!(
                "robot `{robot}` has no IR sensors, so the default brain `{}` cannot drive it; give it another \
                 with --brain {robot}=NAME (`baudbot brain --list` lists them; `none` is no brain)",
                crew::DEFAULT
            )
        } else {
            format!("--brain: {error}")
        })
    })
}

/// A job that is being done.
pub(crate) struct Crew {
    crew: crew::Crew,
    /// What it is made from, again if the operator wants that.
    client: Client,
    world: String,
    job: Job,
    seed: u64,
}

impl Crew {
    /// Takes hold of the robots and makes their brains.
    pub(crate) async fn attach(client: Client, world: &str, job: Job, seed: u64) -> anyhow::Result<Self> {
        let crew = attach(&client, world, &job, seed).await?;
        Ok(Self { crew, client, world: world.to_owned(), job, seed })
    }

    /// Drives the robots until the run is over or the server closes the stream. Brains that the operator restarts are
    /// made anew, which is told; the summary is of those that were the last.
    pub(crate) async fn run(&mut self, tell_restarted: impl Fn()) -> anyhow::Result<Summary> {
        loop {
            match self.crew.run().await {
                Err(Error::Restart) => {
                    self.crew = attach(&self.client, &self.world, &self.job, self.seed).await?;
                    tell_restarted();
                }
                summary => {
                    let failed = || format!("brain `{}` failed", self.crew.brain());
                    return summary.with_context(failed);
                }
            }
        }
    }

    /// Whether the server has closed the stream.
    pub(crate) fn is_closed(&self) -> bool {
        self.crew.is_closed()
    }
}

async fn attach(client: &Client, world: &str, job: &Job, seed: u64) -> anyhow::Result<crew::Crew> {
    match crew::Crew::attach(client.clone(), world, job.clone(), seed).await {
        Ok(crew) => Ok(crew),
        Err(CrewError::Brain(error)) => Err(Refused::error(error.to_string())),
        // Whose errors tell whether it is worth trying again.
        Err(CrewError::Client(error)) => Err(error.into()),
        Err(error) => Err(error.into()),
    }
}

/// Refuses a brain that is not there, or whose file is wrong, before anything is started for it.
pub(crate) fn check_name(description: &str) -> anyhow::Result<()> {
    catalogue::check(description).map_err(|error| Refused::error(error.to_string()))
}
