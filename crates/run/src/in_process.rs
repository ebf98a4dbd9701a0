//! A world with brains of the catalogue in one thread: lockstep without a server.

use baudbot_brain::{Body, Brain};
use baudbot_brains::catalogue::{self, CatalogueError};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Scenario, World};

use crate::assignment::Assignment;
use crate::driven_world::{BareWorld, DrivenWorld, Driver};

/// Any brain.
pub type AnyBrain = Box<dyn Brain + Send>;

/// A world and a brain for each of its robots, or for some of them.
pub type InProcess = DrivenWorld<BareWorld, AnyBrain>;

/// Runs a scenario with these brains, seeded with the scenario's seed, to its end, which it must have, and reads the
/// sensors a last time, as a server does. `look` sees the world between the halves of each tick, and at the end. Returns how the
/// world then is.
///
/// # Errors
/// If the catalogue has no such brain for a robot.
pub fn run(
    scenario: Scenario,
    assignments: &[Assignment],
    mut look: impl FnMut(&World),
) -> Result<World, CatalogueError> {
    let mut local = InProcess::with_assignments(scenario, assignments)?;
    local.world.keep_timeline(0);
    while local.world.ending().is_none() {
        local.tick(&mut look);
    }
    local.world.begin();
    look(&local.world);
    Ok(local.world.into_world())
}

/// A brain of the catalogue for each robot that an assignment names, with this seed; `None` for the others.
///
/// # Errors
/// If the catalogue has no such brain for a robot.
pub fn drivers(
    robots: &[RobotSpec],
    assignments: &[Assignment],
    seed: u64,
) -> Result<Vec<Option<Driver<AnyBrain>>>, CatalogueError> {
    let driver = |spec: &RobotSpec| {
        let assignment = assignments.iter().find(|assignment| assignment.robots.contains(&spec.name))?;
        let body = Body::from(spec);
        let brain = catalogue::brain(&assignment.brain, seed, &body);
        Some(brain.map(|brain| Driver::new(body, brain)))
    };
    robots.iter().map(|spec| driver(spec).transpose()).collect()
}

impl InProcess {
    /// All robots get the brain that `brain` describes, seeded with the scenario's seed.
    ///
    /// # Errors
    /// If the catalogue has no such brain for a robot.
    pub fn new(scenario: Scenario, brain: &str) -> Result<Self, CatalogueError> {
        let robots = scenario.robots.iter().map(|spec| spec.name.clone()).collect();
        Self::with_assignments(scenario, &[Assignment { brain: brain.to_owned(), robots }])
    }

    /// Each robot gets the brain of the assignment that names it, seeded with the scenario's seed; a robot that none names
    /// gets none.
    ///
    /// # Errors
    /// If the catalogue has no such brain for a robot.
    pub fn with_assignments(scenario: Scenario, assignments: &[Assignment]) -> Result<Self, CatalogueError> {
        let drivers = drivers(&scenario.robots, assignments, scenario.seed)?;
        Ok(Self { world: BareWorld::new(World::new(scenario.into())), drivers })
    }

    /// The same as [`new`](Self::new), with a brain of the caller's own for the first robot, which is the only one with
    /// a brain.
    pub fn with_brain(scenario: Scenario, brain: impl Brain + Send + 'static) -> Self {
        let driver = |spec| Driver::new(Body::from(spec), Box::new(brain) as AnyBrain);
        let drivers = vec![scenario.robots.first().map(driver)];
        Self { world: BareWorld::new(World::new(scenario.into())), drivers }
    }

    /// A tick; `look` sees the world between its halves.
    pub fn tick(&mut self, look: impl FnOnce(&World)) {
        let Ok(_) = self.advance(|run| {
            look(&run.world);
            Ok(())
        });
    }

    /// Runs as many ticks, or fewer if the run ends.
    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            if self.world.ending().is_some() {
                return;
            }
            self.tick(|_| {});
        }
    }
}
