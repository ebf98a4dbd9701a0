//! The order of sensors and actuators in the file, which is their order on the wire.
//!
//! A parsed table is sorted by its keys; where each key stood in the text tells the order that was written.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use toml::de::{DeTable, DeValue};

/// The names in a robot's table, in the order of the text.
#[derive(Default)]
pub(super) struct Names {
    pub(super) sensors: Vec<String>,
    pub(super) actuators: Vec<String>,
}

impl Names {
    /// Of a robot's table.
    fn of(robot: &DeTable<'_>) -> Self {
        Self { sensors: keys(robot, "sensors"), actuators: keys(robot, "actuators") }
    }
}

/// For each robot of the file.
pub(super) fn of_robots(toml: &str) -> Vec<Names> {
    let Ok(table) = DeTable::parse(toml) else { return Vec::new() };
    let Some(DeValue::Array(robots)) = table.get_ref().get("robots").map(|robots| robots.get_ref()) else {
        return Vec::new();
    };
    let names = |robot: &DeValue<'_>| match robot {
        DeValue::Table(robot) => Names::of(robot),
        _ => Names::default(),
    };
    robots.iter().map(|robot| names(robot.get_ref())).collect()
}

/// The names in a robot's table under `field`.
fn keys(robot: &DeTable<'_>, field: &str) -> Vec<String> {
    let Some(DeValue::Table(table)) = robot.get(field).map(|table| table.get_ref()) else {
        return Vec::new();
    };
    let mut keys: Vec<_> = table.keys().collect();
    keys.sort_by_key(|key| key.span().start);
    keys.into_iter().map(|key| key.get_ref().to_string()).collect()
}
