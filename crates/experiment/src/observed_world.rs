//! Worlds of a private server whose every tick an observer sees.

use std::sync::{Arc, Mutex, PoisonError};

use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
use baudbot_sim::{Scenario, World};
use tonic::Status;

use crate::experiment::Experiment;
use crate::observer::Sight;
use crate::run_record::{Ran, RunError};

/// A world, with what its observer has seen so far.
pub(crate) struct ObservedWorld {
    sight: Arc<Mutex<Sight>>,
}

impl ObservedWorld {
    /// Makes a world in lockstep, which stands until its brains are there.
    pub(crate) fn create(
        server: &Server,
        name: &str,
        scenario: Scenario,
        experiment: &Experiment,
    ) -> Result<Self, Status> {
        let sight = Arc::new(Mutex::new(Sight::new(experiment.requirements.clone())));
        let told = Arc::clone(&sight);
        let on_tick = move |world: &World| told.lock().unwrap_or_else(PoisonError::into_inner).see(world);
        let world = WorldConfig::new(name, scenario).pace(Pace::Lockstep(Lockstep::default()));
        server.create_world(world.paused(true).on_tick(Box::new(on_tick)))?;
        Ok(Self { sight })
    }

    /// Adds what was seen to a run that is over.
    pub(crate) fn tell(&self, ran: Ran) -> Result<Ran, RunError> {
        self.sight.lock().unwrap_or_else(PoisonError::into_inner).tell(ran)
    }
}
