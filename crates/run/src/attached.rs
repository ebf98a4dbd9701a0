//! Brains of the catalogue at work, as gRPC clients like any other.

use baudbot_brains::catalogue;
use baudbot_client::{Brain, Client, Error, Fleet, Summary, run_fleet};

use crate::assignment::{Assignment, AssignmentError};

/// An assignment that is being carried out.
pub struct AttachedBrains {
    fleet: Fleet,
    brains: Vec<Box<dyn Brain + Send>>,
    // The sessions are made again with these if the operator restarts a brain.
    client: Client,
    world: String,
    assignment: Assignment,
    seed: u64,
}

impl AttachedBrains {
    /// Takes hold of the robots and makes their brains.
    ///
    /// # Errors
    /// If the server refuses, or the catalogue has no such brain for a robot.
    pub async fn attach(
        client: Client,
        world: &str,
        assignment: Assignment,
        seed: u64,
    ) -> Result<Self, AssignmentError> {
        let robots: Vec<_> = assignment.robots.iter().map(String::as_str).collect();
        // The brains of the catalogue do not state a thinking time.
        let named = client.clone().brain(catalogue::shown_name(&assignment.brain)).thinks_as_scenario();
        let fleet = named.attach_many(world, &robots).await?;
        let make = |body| catalogue::brain(&assignment.brain, seed, body);
        let brains = fleet.bodies().iter().map(|body| make(body)).collect::<Result<_, _>>()?;
        Ok(Self { fleet, brains, client, world: world.to_owned(), assignment, seed })
    }

    /// Drives the robots until the run is over or the server closes the stream.
    ///
    /// # Errors
    /// If the stream fails.
    pub async fn run(&mut self) -> Result<Summary, Error> {
        run_fleet(&mut self.fleet, &mut self.brains).await
    }

    /// The same; brains that the operator restarts are made again. The summary is of those that were the last.
    ///
    /// # Errors
    /// If the stream fails, or the brains cannot be made again.
    pub async fn run_with_restarts(&mut self) -> Result<Summary, AssignmentError> {
        loop {
            match self.run().await {
                Err(Error::Restart) => {
                    let (client, assignment) = (self.client.clone(), self.assignment.clone());
                    *self = Self::attach(client, &self.world, assignment, self.seed).await?;
                }
                summary => return Ok(summary?),
            }
        }
    }

    /// Whether the server has closed the stream, so that there will be no further run.
    pub fn is_closed(&self) -> bool {
        self.fleet.is_closed()
    }

    /// The assignment that is being carried out.
    pub fn assignment(&self) -> &Assignment {
        &self.assignment
    }
}
