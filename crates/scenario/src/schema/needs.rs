//! Which fields a robot needs that no preset fills.
//!
//! A preset may fill any field of its table, and of the tables in it; so may the preset of the robot. What is required is therefore taken
//! out of the schema of a robot, and becomes a schema of its own, which holds unless there is a preset.

use alloc::string::String;
use alloc::vec::Vec;

use serde_json::{Map, Value, json};

/// Takes out of a schema what is required, of it and of the tables in it. Lists stay as they are: a preset fills none.
pub(super) fn take(node: &mut Value) -> Option<Value> {
    let Value::Object(map) = node else { return None };
    let mut needs = Map::new();
    needs.extend(map.remove_entry("required"));
    if let Some(Value::Object(fields)) = map.get_mut("properties") {
        let of_fields = fields.iter_mut().filter_map(|(name, field)| Some((name.clone(), take(field)?)));
        let of_fields: Map<_, _> = of_fields.collect();
        if !of_fields.is_empty() {
            needs.insert("properties".into(), of_fields.into());
        }
    }
    if let Some(of_each) = map.get_mut("additionalProperties").and_then(take) {
        needs.insert("additionalProperties".into(), of_each);
    }
    if let Some(Value::Array(all)) = map.get_mut("allOf") {
        let of_all: Vec<_> = all.iter_mut().filter_map(of_condition).collect();
        all.retain(|one| one.get("if").is_none() || one.get("then").is_some() || one.get("else").is_some());
        if !of_all.is_empty() {
            needs.insert("allOf".into(), of_all.into());
        }
    }
    if map.get("allOf").is_some_and(|all| *all == json!([])) {
        map.remove("allOf");
    }
    if needs.is_empty() {
        return None;
    }
    let has_preset = |node: &Map<String, Value>| {
        node.get("properties").is_some_and(|fields| fields.get("preset").is_some())
    };
    let common = map.get("allOf").and_then(|all| all[0].as_object());
    if has_preset(map) || common.is_some_and(has_preset) {
        return Some(json!({ "if": { "required": ["preset"] }, "else": needs }));
    }
    Some(needs.into())
}

/// The same of one schema of several, which may have a condition.
fn of_condition(node: &mut Value) -> Option<Value> {
    let Some(condition) = node.get("if").cloned() else { return take(node) };
    let mut needs = json!({ "if": condition });
    for branch in ["then", "else"] {
        let Some(needed) = node.get_mut(branch).and_then(take) else { continue };
        needs[branch] = needed;
        let is_left =
            node[branch].as_object().is_some_and(|branch| branch.values().any(|value| *value != json!({})));
        if !is_left && let Value::Object(node) = node {
            node.remove(branch);
        }
    }
    (needs.get("then").is_some() || needs.get("else").is_some()).then_some(needs)
}
