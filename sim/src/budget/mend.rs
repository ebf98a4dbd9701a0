//! stub
use super::plan::Plan;
use super::report::{Mend, RobotBudget};
use crate::scenario::Scenario;
use alloc::vec::Vec;
pub(super) fn mends(_: &Scenario, _: &Plan<'_>, _: &RobotBudget) -> Vec<Mend> {
    Vec::new()
}
