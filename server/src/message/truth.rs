//! The truth for trainers: about robots that they drive, which brains never get.

use baudbot_proto::v1;
use baudbot_sim::Ending;

/// The truth at the start of a tick, for the trainer that holds some of the robots.
///
/// While other brains have yet to answer, the world may be ahead of them. All of this is certain then, too: the answers
/// that are missing could not have reached their robots.
pub(crate) struct Truth {
    /// The number of resets, restored states and changes of pace before it.
    pub(crate) era: u64,
    /// Whether the world is in lockstep, and waits for an answer.
    pub(crate) lockstep: bool,
    /// The world and the robots, in the order in which the trainer has asked for them; without an outcome.
    pub(crate) standing: v1::WorldResult,
    pub(crate) ending: Option<Ending>,
    /// The collisions of each robot before the era: none before a reset, maybe some before a state was restored.
    pub(crate) collisions_before: Vec<u64>,
}
