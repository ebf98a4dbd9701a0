//! The allowance: a limit on computation, so that a scenario from the network cannot keep a server busy without end.

use super::plan::Plan;

/// The amount of computation after which the search for remedies stops. It counts how often a sensor is evaluated in
/// an event of a dry run, so it does not depend on how fast the machine is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Allowance {
    left: u64,
}

impl Allowance {
    /// The allowance of all robots of a call together: four times that of one.
    pub const fn of_a_call() -> Self {
        Self { left: 4 * OF_A_ROBOT }
    }

    /// Whether nothing is left.
    pub const fn is_used_up(&self) -> bool {
        self.left == 0
    }

    /// A part of it, of which one robot may have no more.
    pub(super) fn of_a_robot(&self) -> Self {
        Self { left: self.left.min(OF_A_ROBOT) }
    }

    /// Counts what was left over of a part.
    pub(super) fn settle(&mut self, part: &Self) {
        let given = self.of_a_robot().left;
        self.left -= given.saturating_sub(part.left);
    }

    /// Counts bounds, and a dry run of so many events.
    pub(super) fn charge(&mut self, plan: &Plan<'_>, events: usize) {
        let parts = plan.spec.sensors.len() as u64;
        let work = (events as u64).saturating_mul(parts + EVENT).saturating_add(parts * BOUNDS);
        self.left = self.left.saturating_sub(work);
    }
}

impl Default for Allowance {
    /// An `Allowance` of one robot.
    fn default() -> Self {
        Self { left: OF_A_ROBOT }
    }
}

/// About a second.
const OF_A_ROBOT: u64 = 200_000_000;

/// The further cost of an event, in evaluations of a sensor.
const EVENT: u64 = 8;

/// The cost of the bounds for each sensor.
const BOUNDS: u64 = 1000;
