//! The truth for trainers: about robots that they drive, which brains never get.

use baudbot_proto::v1;
use baudbot_sim::{Ending, World};

use crate::convert;

/// The truth at the start of a tick, for the trainer that holds some of the robots.
///
/// While other brains have yet to answer, the world may be ahead of them. All that is told here is certain then, too: the
/// answers that are missing could not have reached their robots.
pub(crate) struct Truth {
    /// Counts the resets, restored states and changes of pace before it.
    pub(crate) era: u64,
    /// Whether the world is in lockstep, and waits for an answer.
    pub(crate) lockstep: bool,
    /// The world and the robots, in the order in which the trainer has asked for them; without an outcome.
    pub(crate) standing: v1::WorldResult,
    pub(crate) ending: Option<Ending>,
    /// How often each robot had collided before the era: never before a reset, and maybe before a state was restored.
    pub(crate) collisions_before: Vec<u64>,
}

impl Truth {
    /// The truth about these robots of a world, each with how often it had collided when the era began.
    pub(crate) fn of(
        world: &World,
        robots: impl Iterator<Item = (usize, u64)>,
        era: u64,
        lockstep: bool,
    ) -> Self {
        let (robots, collisions_before): (Vec<_>, _) = robots.unzip();
        let standing = convert::standing(world, &robots);
        Self { era, lockstep, standing, ending: world.ending().cloned(), collisions_before }
    }
}
