//! The order of sensors and actuators in the file, which is their order on the wire.
//!
//! A parsed table is sorted by its keys; the place of each key in the text gives the order. What a robot has from
//! presets comes first, in their order.

use alloc::collections::BTreeMap;
use alloc::string::{String, ToString};
use alloc::vec::{self, Vec};

use toml::de::{DeTable, DeValue};

use super::preset::Chain;

/// The names in a robot's table, in the order of the text.
#[derive(Clone, Default)]
pub(super) struct Names {
    pub(super) sensors: Vec<String>,
    pub(super) actuators: Vec<String>,
}

/// The names of one robot after the other.
pub(super) struct Order {
    robots: vec::IntoIter<Names>,
    /// The names of the presets that were read.
    presets: BTreeMap<&'static str, Names>,
}

impl Order {
    /// In the text of a scenario.
    pub(super) fn of(document: &DeTable<'_>) -> Self {
        Self { robots: of_robots(document).into_iter(), presets: BTreeMap::new() }
    }

    /// The names of the next robot, which is made of these presets: the farthest one's names first, the file's own
    /// last.
    pub(super) fn next(&mut self, chain: &Chain) -> Names {
        let mut names = Names::default();
        for preset in chain.iter().rev() {
            names.extend(self.presets.entry(preset.name).or_insert_with(|| of_preset(preset.text)).clone());
        }
        names.extend(self.robots.next().unwrap_or_default());
        names
    }
}

impl Names {
    /// The `Names` of a robot's table.
    fn of(robot: &DeTable<'_>) -> Self {
        Self { sensors: keys(robot, "sensors"), actuators: keys(robot, "actuators") }
    }

    fn extend(&mut self, other: Self) {
        self.sensors.extend(other.sensors);
        self.actuators.extend(other.actuators);
    }
}

/// The order of names of each robot of the file.
fn of_robots(document: &DeTable<'_>) -> Vec<Names> {
    let Some(DeValue::Array(robots)) = document.get("robots").map(|robots| robots.get_ref()) else {
        return Vec::new();
    };
    robots.iter().map(|robot| robot.get_ref().as_table().map(Names::of).unwrap_or_default()).collect()
}

/// The order of names of a robot's preset.
fn of_preset(toml: &str) -> Names {
    let Ok(table) = DeTable::parse(toml) else { return Names::default() };
    match table.get_ref().get("robot").map(|robot| robot.get_ref()) {
        Some(DeValue::Table(robot)) => Names::of(robot),
        _ => Names::default(),
    }
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
