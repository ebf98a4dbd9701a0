//! Tables whose fields depend on their `kind`: motors, actuators, sensors.
//!
//! Each is a list of schemas that all hold: the fields of all kinds, of the place, and the names of those of any kind, which is what
//! editors complete; then for each kind, if the table is of it, its own fields and no others.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_sim::sensor::{Place, SensorKind};
use baudbot_sim::{actuator, motor};
use schemars::JsonSchema;
use serde_json::{Map, Value, json};

use super::table::{from_schema, generator, properties, table};
use super::{if_kind, link, preset, set};
use crate::presets::{self, PresetKind};
use crate::{actuators, motors, sensors};

/// A table with kinds.
struct Kinds {
    /// What it is called if nothing is said.
    usual: Option<&'static str>,
    presets: Option<PresetKind>,
    /// The fields of all kinds; then those of a place.
    common: Vec<Value>,
    kinds: Vec<Kind>,
}

struct Kind {
    name: &'static str,
    /// Its own fields.
    table: Value,
    /// Which fields of the place it has.
    place: &'static [&'static str],
    /// What is required of these.
    place_needs: Option<Value>,
}

impl Kind {
    fn of<T: JsonSchema>(name: &'static str) -> Self {
        Self { name, table: table::<T>(), place: &[], place_needs: None }
    }
}

/// The motors' table; and what one is that says no kind, where no preset does.
pub(super) fn motors() -> (Value, Value) {
    let kinds = alloc::vec![
        Kind::of::<motor::DcMotor>("dc"),
        Kind::of::<motor::VelocityMotor>("velocity"),
        Kind::of::<motor::Servo>("servo"),
        Kind::of::<motor::Stepper>("stepper"),
    ];
    let common = alloc::vec![table::<motors::RawMotors>()];
    Kinds { usual: Some("dc"), presets: Some(PresetKind::Motors), common, kinds }.schema_and_usual()
}

/// An actuator's table.
pub(super) fn actuators() -> Value {
    let kinds = alloc::vec![
        Kind::of::<motor::PositionalServo>("turret"),
        Kind::of::<actuator::Lamp>("lamp"),
        Kind::of::<actuator::Speaker>("speaker"),
        Kind::of::<actuators::RawDispenser>("dispenser"),
    ];
    let kind = table::<actuators::RawActuatorKind>();
    let common = alloc::vec![json!({ "properties": { "kind": kind }, "required": ["kind"] })];
    Kinds { usual: None, presets: Some(PresetKind::Actuator), common, kinds }.schema()
}

/// A sensor's table.
pub(super) fn sensors() -> Value {
    let mut common = table::<sensors::Common>();
    let fields = properties(&mut common);
    set(&mut fields["kind"], json!({ "enum": SensorKind::NAMES }));
    link(&mut properties(&mut fields["port"])["link"]);
    let kinds = SensorKind::ALL.map(|kind| {
        let mut table = from_schema(kind.schema(&mut generator()).to_value());
        if let Some(lookup) = table["properties"].get_mut("lookup") {
            file_or_table(lookup);
        }
        let mount = json!({ "if": { "required": ["mount"] }, "else": { "required": ["bearing_rad"] } });
        let (place, place_needs): (&[_], _) = match kind.place() {
            Place::Inside => (&[], None),
            Place::Mounted => (&sensors::PLACE, Some(mount)),
            Place::Rim => (&["bearing_rad", "height_m"], None),
        };
        Kind { name: kind.name(), table, place, place_needs }
    });
    let common = alloc::vec![common, table::<sensors::RawPlace>()];
    Kinds { usual: None, presets: Some(PresetKind::Sensor), common, kinds: kinds.into() }.schema()
}

/// A table that may also be the name of a file.
fn file_or_table(node: &mut Value) {
    let Value::Object(mut table) = node.take() else { return };
    let words: Map<_, _> =
        ["description", "x-manual"].iter().filter_map(|word| table.remove_entry(*word)).collect();
    *node = json!({ "anyOf": [{ "type": "string" }, table] });
    set(node, words.into());
}

impl Kinds {
    fn schema(self) -> Value {
        self.schema_and_usual().0
    }

    fn schema_and_usual(mut self) -> (Value, Value) {
        if let Some(kind) = self.presets {
            properties(&mut self.common[0]).insert("preset".into(), preset(kind));
        }
        let of_all: Vec<String> = fields(&self.common[0]).map(|(name, _)| name.clone()).collect();
        let branches: Vec<_> = self.kinds.iter().map(|kind| self.branch(kind, &of_all)).collect();
        let mut all: Vec<Value> = core::mem::take(&mut self.common);
        for one in &mut all {
            if let Value::Object(one) = one {
                one.remove("additionalProperties");
                one.remove("description");
            }
        }
        all.push(json!({ "properties": self.words_of_any() }));
        let any: Map<_, _> =
            all.iter().flat_map(fields).map(|(name, _)| (name.clone(), true.into())).collect();
        all.extend(branches);
        let without = json!({ "properties": any, "additionalProperties": false });
        let says_kind = json!({ "anyOf": [{ "required": ["kind"] }, { "required": ["preset"] }] });
        all.push(json!({ "if": says_kind, "else": without }));
        let usual = self.kinds.iter().find(|kind| Some(kind.name) == self.usual);
        let usual = usual
            .map(|kind| json!({ "properties": self.closed(kind, &of_all), "additionalProperties": false }));
        (json!({ "type": "object", "allOf": all }), json!({ "if": says_kind, "else": usual }))
    }

    /// What holds for a table of this kind.
    fn branch(&self, kind: &Kind, of_all: &[String]) -> Value {
        let mut known = self.closed(kind, of_all);
        known.extend(fields(&kind.table).map(|(name, field)| (name.clone(), field.clone())));
        let mut then = json!({ "properties": known, "additionalProperties": false });
        for keyword in ["required", "allOf"] {
            if let Some(value) = kind.table.get(keyword) {
                then[keyword] = value.clone();
            }
        }
        if let Some(needs) = &kind.place_needs {
            let all = then["allOf"].as_array().into_iter().flatten().chain([needs]);
            then["allOf"] = all.cloned().collect();
        }
        let presets = self.presets_of(kind.name);
        let is_kind = if_kind(&[kind.name]);
        let is_preset = json!({ "properties": { "preset": { "enum": presets } }, "required": ["preset"] });
        let condition = if presets.is_empty() { is_kind } else { json!({ "anyOf": [is_kind, is_preset] }) };
        json!({ "if": condition, "then": then })
    }

    /// The names of its fields.
    fn closed(&self, kind: &Kind, of_all: &[String]) -> Map<String, Value> {
        let own = fields(&kind.table).map(|(name, _)| name.clone());
        let place = kind.place.iter().map(|name| String::from(*name));
        own.chain(place).chain(of_all.iter().cloned()).map(|name| (name, true.into())).collect()
    }

    /// The fields of any kind, each with what it is in all kinds that have it.
    fn words_of_any(&self) -> Map<String, Value> {
        let mut words: Map<String, Value> = Map::new();
        for kind in &self.kinds {
            for (name, field) in fields(&kind.table) {
                let own = format!("`{}`: {}", kind.name, field["description"].as_str().unwrap_or_default());
                let before = words.get(name).and_then(|field| field["description"].as_str());
                let all = before.map_or_else(|| own.clone(), |before| format!("{before}\n\n{own}"));
                words.insert(name.clone(), json!({ "description": all }));
            }
        }
        words
    }

    /// The presets that are of this kind.
    fn presets_of(&self, kind: &str) -> Vec<&'static str> {
        let those = presets::presets().filter(|preset| Some(preset.kind) == self.presets);
        let is_of_kind = |text: &str, word: &str| {
            let file: toml::Table = text.parse().unwrap_or_default();
            let own = file.get(word).and_then(|part| part.get("kind")).and_then(toml::Value::as_str);
            own.or(self.usual) == Some(kind)
        };
        those.filter(|preset| is_of_kind(preset.text, preset.kind.word())).map(|preset| preset.name).collect()
    }
}

/// The fields of a table, if it has any.
fn fields(table: &Value) -> impl Iterator<Item = (&String, &Value)> {
    table["properties"].as_object().into_iter().flatten()
}
