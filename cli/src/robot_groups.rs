//! Robots of one table of a scenario, with several `starts`: reports show one of them, which stands for all.

use std::collections::BTreeMap;

use baudbot_sim::model::RobotSpec;

use crate::natural;

/// The first robot of each table, in the natural order of names, and how many of them are of that table.
pub(crate) fn first_of_each<'a>(
    robots: impl IntoIterator<Item = &'a RobotSpec>,
) -> Vec<(&'a RobotSpec, usize)> {
    let mut firsts: Vec<(&RobotSpec, usize)> = Vec::new();
    let mut places = BTreeMap::new();
    for robot in natural::sorted(robots, |robot| &robot.name) {
        let place = *places.entry(robot.table_name()).or_insert(firsts.len());
        match firsts.get_mut(place) {
            Some((_, count)) => *count += 1,
            None => firsts.push((robot, 1)),
        }
    }
    firsts
}

/// A line with the number of other robots that this one stands for; empty if none.
pub(crate) fn others(robot: &RobotSpec, count: usize) -> String {
    match (&robot.group, count) {
        (Some(table), 2..) => {
            format!("  and {} more of `{table}`, identical but for their start\n", count - 1)
        }
        _ => String::new(),
    }
}
