//! The order of sensors in the file, which is their order on the wire.
//!
//! A parsed table is sorted by its keys; where each key stood in the text tells the order that was written.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use toml::de::{DeTable, DeValue};

/// For each robot of the file, the names of its sensors in the order of the text.
pub(super) fn sensors(toml: &str) -> Vec<Vec<String>> {
    let Ok(table) = DeTable::parse(toml) else { return Vec::new() };
    let Some(DeValue::Array(robots)) = table.get_ref().get("robots").map(|robots| robots.get_ref()) else {
        return Vec::new();
    };
    robots.iter().map(|robot| names(robot.get_ref())).collect()
}

fn names(robot: &DeValue<'_>) -> Vec<String> {
    let DeValue::Table(robot) = robot else { return Vec::new() };
    let Some(DeValue::Table(sensors)) = robot.get("sensors").map(|sensors| sensors.get_ref()) else {
        return Vec::new();
    };
    let mut keys: Vec<_> = sensors.keys().collect();
    keys.sort_by_key(|key| key.span().start);
    keys.into_iter().map(|key| key.get_ref().to_string()).collect()
}
