//! Places that fields vary: two fields of an experiment never vary the same one, since only one of their values would count.

use std::collections::BTreeMap;

use baudbot_run::assignment;
use toml::{Table, Value};

use crate::error::Error;
use crate::factor::{Choice, Field, Setting};

/// Refuses fields that vary the same place, whatever their labels are. `text` is the scenario's, in which `robots[0]`
/// has a name.
pub(crate) fn unique(fields: &[Field], text: &str) -> Result<(), Error> {
    // Faults of the scenario itself are reported later.
    let scenario = text.parse::<Table>().map(Value::Table).ok();
    let mut varied: BTreeMap<Vec<String>, (usize, String)> = BTreeMap::new();
    for (i, field) in fields.iter().enumerate() {
        for (place, path) in places(field, scenario.as_ref()) {
            let (other, before) = varied.entry(place).or_insert_with(|| (i, path.clone()));
            if *other != i {
                let same = if *before == path { String::new() } else { format!(", as `{before}`") };
                let problem = format!(
                    "varies `{path}`, which fields[{other}] varies already{same}; only one of the values would count, so \
                     remove one of the two"
                );
                return Err(Error::field(format!("fields[{i}]"), problem));
            }
        }
    }
    Ok(())
}

/// All places that a field varies, each with its path in the file.
fn places(field: &Field, scenario: Option<&Value>) -> Vec<(Vec<String>, String)> {
    let place = |setting: &Setting| match setting {
        Setting::Scenario { path, .. } => (resolved(path, scenario), path.clone()),
        Setting::Parameter { name, .. } => (vec![BRAIN.to_owned(), name.clone()], format!("{BRAIN}.{name}")),
        Setting::Brain(brain) => {
            let robot = assignment::split(brain).0.unwrap_or_default();
            (vec![BRAIN.to_owned(), String::new(), robot.to_owned()], BRAIN.to_owned())
        }
    };
    match &field.choice {
        Choice::Levels(levels) => levels.iter().flat_map(|level| &level.settings).map(place).collect(),
        Choice::Range(range) => range.level(range.from).settings.iter().map(place).collect(),
    }
}

/// The parts of a path, with elements of lists by their numbers.
fn resolved(path: &str, scenario: Option<&Value>) -> Vec<String> {
    let mut here = scenario;
    let parts = path.replace('[', ".").replace(']', "");
    let resolve = |part: &str| {
        let Some(Value::Array(list)) = here else {
            here = here.and_then(|table| table.get(part));
            return part.to_owned();
        };
        let is_named = |value: &Value| value.get("name").and_then(Value::as_str) == Some(part);
        let number = list.iter().position(is_named).or_else(|| part.parse().ok());
        here = number.and_then(|number| list.get(number));
        number.map_or_else(|| part.to_owned(), |number| number.to_string())
    };
    parts.split('.').map(resolve).collect()
}

/// The first part of the place of a brain and its parameters.
const BRAIN: &str = "brain";
