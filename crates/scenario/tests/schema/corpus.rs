//! Scenarios with all fields that there are, for changes of each.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use baudbot_scenario::ScenarioError;
use serde_json::Value;

use crate::schema::validator::is_valid;

pub(crate) static SCHEMA: LazyLock<Value> = LazyLock::new(baudbot_scenario::schema);

/// The scenarios, each with all its robots' tables.
pub(crate) fn scenarios() -> Vec<Value> {
    include_str!("all_fields.txt").split("# ----\n").skip(1).map(read).collect()
}

/// The value of a text.
pub(crate) fn read(toml: &str) -> Value {
    let table: toml::Table = toml.parse().unwrap_or_else(|error| panic!("{error} in\n{toml}"));
    serde_json::to_value(table).unwrap()
}

/// The parser's result for a scenario.
pub(crate) fn parsed(scenario: &Value) -> Result<(), ScenarioError> {
    let table: toml::Table = serde_json::from_value(scenario.clone()).unwrap();
    baudbot_scenario::parse(&toml::to_string(&table).unwrap()).map(drop)
}

/// The places of all fields in a value, tables and lists before what is in them.
pub(crate) fn places(value: &Value) -> Vec<String> {
    let mut all = Vec::new();
    let mut below = |name: String, value: &Value| {
        all.push(name.clone());
        all.extend(places(value).into_iter().map(|place| format!("{name}{place}")));
    };
    match value {
        Value::Object(table) => {
            table.iter().for_each(|(name, value)| below(format!("/{name}"), value));
        }
        Value::Array(list) => list.iter().enumerate().for_each(|(i, value)| below(format!("/{i}"), value)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
    all
}

/// The path `/robots/0/start/x_m` in the form of errors. Names of pins may be numbers.
pub(crate) fn path(place: &str) -> String {
    let mut path = String::new();
    for part in place.split('/').skip(1) {
        match part.parse::<usize>() {
            Ok(i) if !path.ends_with(".pins") => path += &format!("[{i}]"),
            _ if path.is_empty() => path += part,
            _ => path += &format!(".{part}"),
        }
    }
    path
}

/// The names of fields in a schema, each behind those of the tables that it is in; all kinds of a table together.
fn fields(schema: &Value, at: &str, all: &mut BTreeSet<String>) {
    for (name, field) in schema["properties"].as_object().into_iter().flatten() {
        let at = format!("{at}/{name}");
        fields(field, &at, all);
        all.insert(at);
    }
    for keyword in ["items", "additionalProperties", "then"] {
        if let Some(below) = schema.get(keyword) {
            let at = if keyword == "then" { at.to_owned() } else { format!("{at}/*") };
            fields(below, &at, all);
        }
    }
    for keyword in ["allOf", "anyOf"] {
        schema[keyword].as_array().into_iter().flatten().for_each(|one| fields(one, at, all));
    }
}

#[test]
fn each_field_is_in_some_scenario() {
    let mut expected = BTreeSet::new();
    fields(&SCHEMA, "", &mut expected);
    let mut found = BTreeSet::new();
    for scenario in scenarios() {
        let places = places(&scenario);
        for place in &places {
            // Names of sensors, actuators and pins, and places in lists.
            let mut parts: Vec<&str> = place.split('/').collect();
            let is_name = |parts: &[&str], i: usize| {
                ["sensors", "actuators", "pins"].contains(&parts[i - 1]) || parts[i].parse::<usize>().is_ok()
            };
            for i in 2..parts.len() {
                if is_name(&parts, i) {
                    parts[i] = "*";
                }
            }
            found.insert(parts.join("/"));
        }
    }
    // A preset stands for fields that others have; a map is in another file; a port's link is a link; what is in a list of several on a
    // pin is what may be there alone; only one of several starts has a name.
    let others = ["/preset", "/without", "/maps", "/sensors/*/port/link/", "/pins/*/*/", "/start/name"];
    let is_other = |place: &&String| others.iter().any(|other| place.contains(other));
    let missing: Vec<_> = expected.difference(&found).filter(|place| !is_other(place)).collect();
    assert!(missing.is_empty(), "no scenario of the corpus has {missing:#?}");
}

#[test]
fn parser_and_schema_take_the_scenarios() {
    for scenario in scenarios() {
        parsed(&scenario).unwrap_or_else(|error| panic!("{error}"));
        assert!(is_valid(&SCHEMA, &scenario));
    }
}
