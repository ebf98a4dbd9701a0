//! The thinking time of brains: from a Turn to its answer. That is measured and reported, and never is part of the
//! simulation.

use std::sync::Arc;
use std::time::Duration;

use baudbot_sim::Histogram;

/// The processor time that the brain of the robot in a place of the scenario has used by now. `None` if that is not known.
pub type ProcessorTime = Arc<dyn Fn(usize) -> Option<Duration> + Send + Sync>;

/// The thinking times of a robot's brains.
#[derive(Clone, Debug, Default)]
pub(crate) struct Thought {
    /// The thinking by the wall clock.
    pub(crate) wall: Histogram,
    /// The thinking by the processor time of the brain's process.
    pub(crate) processor: Histogram,
}
