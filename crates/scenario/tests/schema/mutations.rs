//! Each field of each table is left out, misspelt and of a wrong type: the schema refuses what the parser refuses, and nothing else.

use baudbot_fields::Cause;
use baudbot_scenario::ScenarioError;
use serde_json::{Value, json};

use crate::schema::corpus::{SCHEMA, parsed, path, places, scenarios};
use crate::schema::validator::findings;

/// Fields of which only the parser knows what is wrong, with the reason.
const KNOWN_BY_THE_PARSER: [(&str, &str); 12] = [
    ("/metrics/cell_m", "`end` needs it"),
    ("/metrics/sensed_by", "`end` needs it"),
    ("/urg/period_ms", "another period is too short for a sweep"),
    ("/urg/port", "the robot's messages are then too long"),
    ("/starts/1/x_m", "two robots then start in one place"),
    ("/robots/0/link", "a chip needs a cable"),
    ("/pins/4", "a driver has two pins"),
    ("/pins/5", "a driver has two pins"),
    ("/pins/6", "a driver has two pins"),
    ("/pins/7", "a driver has two pins"),
    ("/A0/volts_per_unit", "the sensor has no `bits` that would say it"),
    ("/microcontroller/program", "a text names a file, which another program puts in"),
];

/// The same of values in place of which there is a text.
const TEXTS: [(&str, &str); 2] = [
    ("/lookup/lookup", "a text names a file, which another program puts in"),
    ("/pins/", "a text names what is on a pin"),
];

#[test]
fn a_field_that_there_is_not_is_refused_in_every_table() {
    let mut tables = 0;
    for scenario in scenarios() {
        for place in places(&scenario).into_iter().chain([String::new()]) {
            let mut changed = scenario.clone();
            let Some(Value::Object(table)) = changed.pointer_mut(&place) else { continue };
            if ["/sensors", "/actuators", "/pins"].iter().any(|map| place.ends_with(map)) {
                continue;
            }
            table.insert("nmae".into(), json!(1));
            parsed(&changed).expect_err(&place);
            let found = findings(&SCHEMA, &changed).wrong;
            let names_it = found.iter().any(|wrong| wrong.contains("/nmae: false"));
            let one_of =
                place.contains("/pins/") || place.ends_with("/program") || place.ends_with("/lookup");
            assert!(names_it || one_of && !found.is_empty(), "{place}.nmae: {found:#?}");
            tables += 1;
        }
    }
    assert!(tables > 100, "found only {tables}");
}

#[test]
fn a_field_that_is_not_there_is_missed_by_both_or_none() {
    let mut all = Vec::new();
    for scenario in scenarios() {
        for place in places(&scenario) {
            let (table, name) = place.rsplit_once('/').unwrap();
            let mut changed = scenario.clone();
            let Value::Object(table) = changed.pointer_mut(table).unwrap() else { continue };
            table.remove(name);
            all.extend(difference(&place, "left out", &changed));
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn a_value_of_another_type_is_refused_by_both() {
    let others = [json!("zz zz"), json!(true), json!(1.5), json!(2), json!({}), json!([]), json!(["zz zz"])];
    let mut all = Vec::new();
    for scenario in scenarios() {
        for place in places(&scenario) {
            for other in &others {
                let mut changed = scenario.clone();
                let value = changed.pointer_mut(&place).unwrap();
                if kind(value) == kind(other) {
                    continue;
                }
                *value = other.clone();
                all.extend(difference(&place, &other.to_string(), &changed));
            }
        }
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// Numbers are of one kind, unless a whole one is wanted.
fn kind(value: &Value) -> u8 {
    match value {
        Value::Null => 0,
        Value::Bool(_) => 1,
        Value::Number(_) => 2,
        Value::String(_) => 3,
        Value::Array(_) => 4,
        Value::Object(_) => 5,
    }
}

/// The difference between the two: one takes the value and the other refuses it.
fn difference(place: &str, change: &str, changed: &Value) -> Option<String> {
    let (parser, schema) = (parsed(changed), findings(&SCHEMA, changed).wrong);
    match (parser, schema.is_empty()) {
        (Ok(()), true) | (Err(_), false) => None,
        (Ok(()), false) => Some(format!("{place} {change}: only the schema refuses it: {schema:?}")),
        (Err(_), true) if KNOWN_BY_THE_PARSER.iter().any(|(field, _)| place.ends_with(field)) => None,
        (Err(_), true) if change.contains("zz") && TEXTS.iter().any(|(field, _)| place.contains(field)) => {
            None
        }
        (Err(error), true) if is_about_another(&error, place) => None,
        (Err(error), true) => Some(format!("{place} {change}: only the parser refuses it: {error}")),
    }
}

/// Whether a refusal is about a field that depends on the one that was changed: neither about this nor about the table that it is in.
fn is_about_another(error: &ScenarioError, place: &str) -> bool {
    let ScenarioError::Field { path: refused, cause: Cause::Value, .. } = error else { return false };
    !path(place).starts_with(refused.as_str())
}
