//! The schema of a table, from the type that it is read into.

use alloc::string::String;
use alloc::vec::Vec;
use alloc::{format, vec};

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use super::text::{Text, without_links};
use super::{if_kind, names, range};

/// The schema of a type, without references.
pub(super) fn table<T: JsonSchema>() -> Value {
    from_schema(generator().into_root_schema_for::<T>().to_value())
}

/// What makes schemas of types.
pub(super) fn generator() -> schemars::SchemaGenerator {
    let settings = SchemaSettings::draft07().with(|settings| {
        settings.inline_subschemas = true;
        settings.meta_schema = None;
    });
    settings.into_generator()
}

/// A derived schema as TOML has its values, with descriptions for people.
pub(super) fn from_schema(mut schema: Value) -> Value {
    tidy(&mut schema);
    schema
}

/// The fields of a table.
pub(super) fn properties(table: &mut Value) -> &mut Map<String, Value> {
    let properties = table.get_mut("properties").and_then(Value::as_object_mut);
    properties.expect("a table that is read into a type has fields")
}

/// Puts the fields of tables that have conditions into a schema beside these: where there are several, editors look into each of them, and
/// nowhere else.
pub(super) fn beside_conditions(node: &mut Value) {
    match node {
        Value::Array(nodes) => nodes.iter_mut().for_each(beside_conditions),
        Value::Object(map) => {
            map.values_mut().for_each(beside_conditions);
            if !map.contains_key("allOf") || !map.contains_key("properties") {
                return;
            }
            let keywords = ["type", "properties", "additionalProperties", "required"];
            let fields: Map<_, _> =
                keywords.iter().filter_map(|keyword| map.remove_entry(*keyword)).collect();
            if let Some(Value::Array(all)) = map.get_mut("allOf") {
                all.insert(0, fields.into());
            }
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// Says of each part of a table's schema that other parts may know more fields: tombi takes it for the whole otherwise.
pub(super) fn open(node: &mut Value) {
    match node {
        Value::Array(nodes) => nodes.iter_mut().for_each(open),
        Value::Object(map) => {
            map.values_mut().for_each(open);
            let is_of_table = map.get("properties").is_some_and(Value::is_object)
                || map.get("required").is_some_and(Value::is_array);
            if is_of_table {
                map.entry("additionalProperties").or_insert(true.into());
            }
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

fn tidy(node: &mut Value) {
    let Value::Object(map) = node else { return };
    for keyword in ["format", "title"] {
        map.remove(keyword);
    }
    without_null(map);
    words_of_an_enum(map);
    if let Some(items) = map.remove("prefixItems") {
        map.insert("items".into(), items);
        map.insert("additionalItems".into(), false.into());
    }
    for keyword in ["items", "additionalProperties"] {
        map.get_mut(keyword).into_iter().for_each(tidy_element);
    }
    for keyword in ["items", "anyOf"] {
        map.get_mut(keyword).and_then(Value::as_array_mut).into_iter().flatten().for_each(tidy_element);
    }
    if let Some(Value::Object(fields)) = map.get_mut("properties") {
        fields.values_mut().for_each(tidy);
        describe(map);
    }
}

/// An element of a list has bounds, and no description that would say them.
fn tidy_element(node: &mut Value) {
    tidy(node);
    if let Value::Object(map) = node {
        map.remove(range::RULE);
    }
}

/// TOML has no null: a field is there or is not.
fn without_null(map: &mut Map<String, Value>) {
    if map.get("default") == Some(&Value::Null) {
        map.remove("default");
    }
    for keyword in ["type", "enum"] {
        let Some(Value::Array(those)) = map.get_mut(keyword) else { continue };
        let number = those.len();
        those.retain(|one| !one.is_null() && one != "null");
        let is_optional = those.len() < number;
        if let ("type", [one]) = (keyword, &those[..]) {
            map[keyword] = one.clone();
        }
        if is_optional {
            map.insert("x-optional".into(), true.into());
        }
    }
    let Some(Value::Array(ways)) = map.get_mut("anyOf") else { return };
    ways.retain(|way| way["type"] != "null");
    if let [Value::Object(one)] = &mut ways[..] {
        let one = core::mem::take(one);
        map.remove("anyOf");
        for (keyword, value) in one {
            map.entry(keyword).or_insert(value);
        }
        without_null(map);
    }
}

/// Variants with a doc comment each become the words that there are.
fn words_of_an_enum(map: &mut Map<String, Value>) {
    let Some(Value::Array(variants)) = map.get("oneOf") else { return };
    let words = |variant: &Value| match variant.get("const") {
        Some(word) => vec![word.clone()],
        None => variant["enum"].as_array().cloned().unwrap_or_default(),
    };
    let words: Vec<_> = variants.iter().flat_map(words).collect();
    map.remove("oneOf");
    map.insert("type".into(), "string".into());
    map.insert("enum".into(), words.into());
}

/// Descriptions, ranges and conditions of a table's fields, from their comments.
fn describe(table: &mut Map<String, Value>) {
    let required = table.remove("required").as_ref().map(names).unwrap_or_default();
    let mut needs = Needs { always: required, ..Needs::default() };
    let mut texts = Vec::new();
    let fields = table.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten();
    for (name, field) in fields {
        let Value::Object(field) = field else { continue };
        let mut text = Text::of(field.get("description").and_then(Value::as_str).unwrap_or_default());
        if let Some(pattern) = text.range.as_deref().and_then(range::pattern) {
            field.insert("pattern".into(), pattern.into());
        }
        text.range = range::whole(field, text.range.take());
        defaults(field, &mut text, needs.always.contains(name));
        let whole = text.whole();
        let plain = without_links(&whole);
        if plain != whole {
            field.insert("x-manual".into(), whole.into());
        }
        field.insert("description".into(), plain.into());
        texts.push((name.clone(), text));
    }
    needs.read(&texts);
    needs.write(table);
}

/// The default, as the code or else the comment has it, in both places.
fn defaults(field: &mut Map<String, Value>, text: &mut Text, is_required: bool) {
    let is_optional = field.remove("x-optional").is_some();
    if is_required {
        text.default = Some("required".into());
    } else if let Some(words) = &text.default {
        let number = range::number(words).filter(|_| field.get("type") == Some(&json!("number")));
        if let Some(number) = number.filter(|_| !field.contains_key("default")) {
            field.insert("default".into(), number.into());
        }
    } else {
        text.default = Some(match (field.get("default"), field.get("type").and_then(Value::as_str)) {
            (Some(default), _) => in_words(default),
            (None, Some("array")) if !is_optional => "empty".into(),
            (None, _) => "none".into(),
        });
    }
}

/// A value as it stands in a file.
fn in_words(value: &Value) -> String {
    match value {
        Value::Array(list) if list.is_empty() => "empty".into(),
        Value::String(_) | Value::Array(_) => format!("`{value}`").replace(',', ", "),
        Value::Number(number) if number.as_f64() == Some(core::f64::consts::PI) => "π".into(),
        Value::Number(number) => range::grouped(&format!("{number}")),
        Value::Bool(_) | Value::Null | Value::Object(_) => format!("{value}"),
    }
}

/// Which fields a table must have, and which it may have only if it is of some kind.
#[derive(Default)]
struct Needs {
    always: Vec<String>,
    /// One of each of these lists.
    one_of: Vec<Vec<String>>,
    /// A field that another one needs.
    along: Vec<(String, String)>,
    /// A field that these kinds need.
    of_kinds: Vec<(String, Vec<String>)>,
    /// A field that only these kinds have.
    only: Vec<(String, Vec<String>)>,
}

impl Needs {
    fn read(&mut self, texts: &[(String, Text)]) {
        for (name, text) in texts {
            let named = |words| Text::named(text.default.as_ref(), words);
            let others = [named("this or "), named("this, ")].concat();
            if !others.is_empty() {
                let mut ways: Vec<_> = others.into_iter().chain([name.clone()]).collect();
                ways.sort();
                if !self.one_of.contains(&ways) {
                    self.one_of.push(ways);
                }
            }
            self.along.extend(named("required with ").into_iter().map(|other| (other, name.clone())));
            let kinds = named("required for ");
            if !kinds.is_empty() {
                self.of_kinds.push((name.clone(), kinds));
            }
            let only = Text::named(text.range.as_ref(), "only ");
            if !only.is_empty() {
                self.only.push((name.clone(), only));
            }
        }
    }

    /// Puts them into the schema, beside the fields if there are conditions.
    fn write(self, table: &mut Map<String, Value>) {
        let kinds = names(&table["properties"]["kind"]["enum"]);
        let mut conditions = Vec::new();
        for ways in self.one_of {
            let (one, others) = ways.split_last().expect("it has this and another");
            let others: Vec<_> = others.iter().map(|other| json!({ "required": [other] })).collect();
            conditions.push(json!({ "if": { "anyOf": others }, "else": { "required": [one] } }));
        }
        for (with, field) in self.along {
            conditions.push(json!({ "if": { "required": [with] }, "then": { "required": [field] } }));
        }
        for kind in &kinds {
            let needed: Vec<_> = fields_of(&self.of_kinds, |kinds| kinds.contains(kind));
            let is_of_others =
                |only: &[String]| only.iter().all(|one| kinds.contains(one)) && !only.contains(kind);
            let refused: Map<_, _> =
                fields_of(&self.only, is_of_others).into_iter().map(|field| (field, false.into())).collect();
            if !needed.is_empty() || !refused.is_empty() {
                let mut then = json!({});
                if !needed.is_empty() {
                    then["required"] = needed.into();
                }
                if !refused.is_empty() {
                    then["properties"] = refused.into();
                }
                conditions.push(json!({ "if": if_kind(&[kind]), "then": then }));
            }
        }
        if !self.always.is_empty() {
            table.insert("required".into(), self.always.into());
        }
        if !conditions.is_empty() {
            table.insert("allOf".into(), conditions.into());
        }
    }
}

fn fields_of(all: &[(String, Vec<String>)], is_meant: impl Fn(&[String]) -> bool) -> Vec<String> {
    all.iter().filter(|(_, kinds)| is_meant(kinds)).map(|(field, _)| field.clone()).collect()
}
