//! The rules of a run: what the referee counts besides collisions and distance, and when it has been enough.

use alloc::vec::Vec;

use crate::coverage::Floor;

/// The rules that the referee applies.
#[derive(Clone, Debug, Default)]
pub struct Rules {
    /// The floor to be covered, if that is counted (§6.1).
    pub floor: Option<Floor>,
    /// The sensor whose rays cover the floor: the place of a sensor for each robot that has one of that name.
    pub sensed_by: Vec<Option<usize>>,
    /// The period at which those rays are evaluated, in nanoseconds.
    pub sense_ns: u64,
    /// The run ends with so many collisions.
    pub collisions: Option<u64>,
    /// The run ends when all goals have been reached.
    pub all_goals: bool,
    /// The run ends when this share of the floor is covered.
    pub covered: Option<f64>,
    /// The run ends when this share of the floor is sensed.
    pub sensed: Option<f64>,
    /// The run ends when a battery is empty.
    pub battery_empty: bool,
    /// Whether some robot's missed deadline ends it.
    pub missed_deadline: bool,
}

impl Rules {
    /// Whether it is counted what the rays of a sensor reach.
    pub fn count_sensed(&self) -> bool {
        self.floor.is_some() && self.sensed_by.iter().any(Option::is_some)
    }

    /// Whether any of them can end a run.
    pub fn end_runs(&self) -> bool {
        self.collisions.is_some()
            || self.all_goals
            || self.covered.is_some()
            || self.sensed.is_some()
            || self.battery_empty
    }
}
