//! A JSON Schema of scenario files, for editors and for the tables of the manual.
//!
//! Its source are the types that files are read into, with their doc comments:
//!
//! 1. `table` derives a schema from a type. Descriptions come from doc comments, which say at their end what a default or a range is
//!    (`text`, `range`).
//! 2. `kinds` puts tables together whose fields depend on their `kind`.
//! 3. `needs` takes out of a robot's schema which fields are required, since a preset can fill any of them, and adds the condition that there
//!    is none.
//!
//! The schema has no field that the parser refuses, and no narrower range. What depends on other fields the parser alone knows, but for
//! what `kind` and `preset` decide.

mod kinds;
mod map;
mod needs;
mod range;
mod table;
mod text;

use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_avr::Part;
use serde_json::{Map, Value, json};

use crate::presets::{self, PresetKind};
use crate::{pins, raw};
use table::{properties, table};

/// The schema, in the form of JSON Schema's draft 7, which all editors understand.
pub fn schema() -> Value {
    let mut schema = table::<raw::Scenario>();
    let maps = table::<map::Map>();
    set(
        &mut properties(&mut properties(&mut schema)["arena"])["maps"],
        json!({ "type": "array", "items": maps }),
    );
    robot(&mut properties(&mut schema)["robots"]["items"]);
    set(
        &mut schema,
        json!({
            "$schema": "http://json-schema.org/draft-07/schema#",
            "title": "A scenario of baudbot",
            "description": "An arena, robots with their cables, and the rules of the run.",
        }),
    );
    table::beside_conditions(&mut schema);
    table::open(&mut schema);
    schema
}

/// Completes the schema of a robot by what its type does not say: tables by kind, presets, and what these fill.
fn robot(robot: &mut Value) {
    let fields = properties(robot);
    let (motors, without_kind) = kinds::motors();
    set(&mut fields["motors"], motors);
    set(&mut fields["actuators"], by_name(kinds::actuators()));
    set(&mut fields["sensors"], by_name(kinds::sensors()));
    set(&mut fields["pins"], on_pins());
    let chips = Part::ALL.map(|part| part.properties().name.to_ascii_lowercase());
    set(&mut properties(&mut fields["microcontroller"])["chip"], json!({ "enum": chips }));
    link(&mut fields["link"]);
    add_preset(&mut fields["microcontroller"], PresetKind::Microcontroller);
    add_preset(&mut fields["battery"], PresetKind::Battery);
    add_preset(robot, PresetKind::Robot);
    let without =
        "Sensors of the preset that this robot does not have. Default: empty. Range: only with `preset`.";
    properties(robot).insert(
        "without".into(),
        json!({ "type": "array", "items": { "type": "string" }, "description": without }),
    );
    if let Some(mut needs) = needs::take(robot) {
        needs["else"]["properties"]["motors"] = without_kind;
        set(robot, needs);
    }
    // That no preset has.
    set(robot, json!({ "required": ["name"] }));
}

/// Completes the schema of a link.
pub(super) fn link(link: &mut Value) {
    let endpoint = json!({ "type": "string", "pattern": "^(pty|tcp|rfc2217|unix):." });
    let several = json!({ "type": "array", "items": endpoint, "maxItems": 8 });
    set(&mut properties(link)["serial_port"], json!({ "anyOf": [endpoint, several] }));
    add_preset(&mut properties(link)["adapter"], PresetKind::Adapter);
    add_preset(link, PresetKind::Link);
}

/// What is on a pin: one or several of what is connected.
fn on_pins() -> Value {
    let name = json!({ "type": "string", "description": "The part on the pin, such as `sensors.ir_left`." });
    let one = json!([name, table::<pins::Options>()]);
    json!({
        "type": "object",
        "additionalProperties": { "anyOf": [name, table::<pins::Options>(), { "type": "array", "items": { "anyOf": one } }] },
    })
}

/// A table of tables, by names.
fn by_name(each: Value) -> Value {
    json!({
        "type": "object",
        "propertyNames": { "pattern": "^[A-Za-z0-9_-]{1,64}$" },
        "additionalProperties": each,
    })
}

/// Lets a table name a preset of this kind, one of those that there are.
fn add_preset(node: &mut Value, kind: PresetKind) {
    properties(node).insert("preset".into(), preset(kind));
}

fn preset(kind: PresetKind) -> Value {
    let (names, descriptions): (Vec<_>, Vec<_>) = presets::presets()
        .filter(|preset| preset.kind == kind)
        .map(|preset| (preset.name, preset.description))
        .unzip();
    json!({
        "description": "The preset that sets the fields which this table omits: `baudbot preset NAME` shows it. Default: none.",
        "x-manual": "The [preset](presets.md) that sets the fields which this table omits. Default: none.",
        "enum": names,
        "x-taplo": { "docs": { "enumValues": descriptions } },
    })
}

/// Puts keywords into a schema.
fn set(node: &mut Value, keywords: Value) {
    let Value::Object(keywords) = keywords else { return };
    if !node.is_object() {
        *node = Value::Object(Map::new());
    }
    for (keyword, value) in keywords {
        node[keyword] = value;
    }
}

/// The condition that the kind of a table is one of these.
fn if_kind(kinds: &[&str]) -> Value {
    json!({ "properties": { "kind": { "enum": kinds } }, "required": ["kind"] })
}

/// Names as JSON has them.
fn names(value: &Value) -> Vec<String> {
    let names = value.as_array().into_iter().flatten().filter_map(Value::as_str);
    names.map(ToString::to_string).collect()
}
