//! What trainers are told: the truth about robots that they drive, which brains never get.

use baudbot_sim::drive::Motion;
use baudbot_sim::{Ending, SimTime, World};

use crate::frame::{Charge, Score};

/// The truth at the start of a tick, for the trainer that holds some of the robots.
///
/// While other brains have yet to answer, the world may be ahead of them. All that is told here is certain then, too: the
/// answers that are missing could not have reached their robots.
pub(crate) struct Truth {
    /// Counts the resets, restored states and changes of pace before it.
    pub(crate) era: u64,
    /// Whether the world is in lockstep, and waits for an answer.
    pub(crate) lockstep: bool,
    pub(crate) tick: u64,
    pub(crate) time: SimTime,
    pub(crate) ending: Option<Ending>,
    /// In the order in which the trainer has asked for them.
    pub(crate) robots: Vec<RobotFacts>,
    /// `None` if the scenario counts nothing.
    pub(crate) score: Option<Score>,
}

/// The truth about one robot.
pub(crate) struct RobotFacts {
    pub(crate) motion: Motion,
    /// Since the start of the run.
    pub(crate) collisions: u64,
    /// How many of them were before the era: none after a reset, some after a state was restored.
    pub(crate) collisions_before: u64,
    pub(crate) distance_m: f64,
    pub(crate) battery: Option<Charge>,
    /// Time in each zone of the scenario.
    pub(crate) in_zone_ns: Vec<u64>,
}

impl Truth {
    /// The truth about these robots of a world, each with how often it had collided when the era began.
    pub(crate) fn of(
        world: &World,
        robots: impl Iterator<Item = (usize, u64)>,
        era: u64,
        lockstep: bool,
    ) -> Self {
        Self {
            era,
            lockstep,
            tick: world.tick(),
            time: world.time(),
            ending: world.ending().cloned(),
            robots: robots.map(|robot| facts(world, robot)).collect(),
            score: Score::of(world),
        }
    }
}

fn facts(world: &World, (index, collisions_before): (usize, u64)) -> RobotFacts {
    let robot = world.robot(index);
    let counters = robot.counters();
    RobotFacts {
        motion: *robot.motion(),
        collisions: counters.collisions,
        collisions_before,
        distance_m: counters.distance_m,
        battery: Charge::of(&robot),
        in_zone_ns: world.score().in_zone_ns(index).to_vec(),
    }
}
