//! Robots that are alike but for their names, places and cables.

use baudbot_sim::model::RobotSpec;

/// Robots that are alike.
#[derive(Debug)]
pub(super) struct Kind<'a> {
    /// The first of them.
    pub(super) robot: &'a RobotSpec,
    /// The place of the kind among the scenario's robots.
    pub(super) first: usize,
    /// The number of robots of the kind.
    pub(super) count: usize,
}

/// The kinds of robots, in the robots' order, up to a number for which a key has room.
pub(super) fn of(robots: &[RobotSpec]) -> Vec<Kind<'_>> {
    let mut kinds: Vec<Kind<'_>> = Vec::new();
    for (first, robot) in robots.iter().enumerate() {
        match kinds.iter().position(|kind| are_alike(kind.robot, robot)) {
            Some(i) => kinds[i].count += 1,
            None if kinds.len() < MOST => kinds.push(Kind { robot, first, count: 1 }),
            None => {}
        }
    }
    kinds
}

fn are_alike(a: &RobotSpec, b: &RobotSpec) -> bool {
    a.drive == b.drive
        && a.outline == b.outline
        && a.look == b.look
        && a.parts == b.parts
        && a.sensors == b.sensors
        && a.actuators == b.actuators
        && a.chip == b.chip
}

const MOST: usize = 12;
