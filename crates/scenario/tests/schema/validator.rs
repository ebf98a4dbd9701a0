//! As much of JSON Schema as our schema uses. Any other keyword fails the test, so that nothing is passed over.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

/// Keywords that do not affect what is valid.
const WORDS: [&str; 7] = ["$schema", "title", "description", "default", "x-manual", "x-taplo", "then"];

/// The schema of a value, and the findings.
#[derive(Default)]
pub(crate) struct Findings {
    /// The places of faults, with the keyword of the schema.
    pub(crate) wrong: Vec<String>,
    /// The bounds of each number, by its place as a JSON pointer.
    pub(crate) numbers: BTreeMap<String, Bounds>,
}

/// The bounds of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) least: Option<f64>,
    pub(crate) above: Option<f64>,
    pub(crate) most: Option<f64>,
    pub(crate) is_whole: bool,
    pub(crate) is_one_of: bool,
}

/// The faults of a value.
pub(crate) fn findings(schema: &Value, value: &Value) -> Findings {
    let mut findings = Findings::default();
    findings.check(schema, value, "");
    findings
}

pub(crate) fn is_valid(schema: &Value, value: &Value) -> bool {
    findings(schema, value).wrong.is_empty()
}

impl Findings {
    fn check(&mut self, schema: &Value, value: &Value, at: &str) {
        if let Value::Bool(is_right) = schema {
            if !is_right {
                self.wrong.push(format!("{at}: false"));
            }
            return;
        }
        let Value::Object(schema) = schema else { panic!("no schema: {schema}") };
        for (keyword, rule) in schema {
            if !self.holds(keyword, rule, schema, value, at) {
                self.wrong.push(format!("{at}: {keyword} {rule}"));
            }
        }
        if value.is_number() {
            self.note(schema, at);
        }
    }

    /// Whether a keyword's own rule holds; what is in the value is checked along the way.
    fn holds(
        &mut self,
        keyword: &str,
        rule: &Value,
        schema: &Map<String, Value>,
        value: &Value,
        at: &str,
    ) -> bool {
        let number = || value.as_f64().zip(rule.as_f64());
        match keyword {
            "type" => has_type(value, rule),
            "enum" => rule.as_array().is_some_and(|all| all.contains(value)),
            "minimum" => number().is_none_or(|(value, bound)| value >= bound),
            "maximum" => number().is_none_or(|(value, bound)| value <= bound),
            "exclusiveMinimum" => number().is_none_or(|(value, bound)| value > bound),
            "minItems" => value.as_array().is_none_or(|list| list.len() as u64 >= rule.as_u64().unwrap()),
            "maxItems" => value.as_array().is_none_or(|list| list.len() as u64 <= rule.as_u64().unwrap()),
            "pattern" => value.as_str().is_none_or(|text| fits(text, rule.as_str().unwrap())),
            "required" => {
                let fields = rule.as_array().unwrap().iter().map(|name| name.as_str().unwrap());
                value.as_object().is_none_or(|table| fields.into_iter().all(|name| table.contains_key(name)))
            }
            "anyOf" => rule.as_array().unwrap().iter().any(|one| self.branch(one, value, at)),
            "allOf" => {
                rule.as_array().unwrap().iter().for_each(|one| self.check(one, value, at));
                true
            }
            "if" => {
                let branch = if findings(rule, value).wrong.is_empty() { "then" } else { "else" };
                schema.get(branch).into_iter().for_each(|branch| self.check(branch, value, at));
                true
            }
            "properties" | "additionalProperties" | "propertyNames" => {
                self.fields(keyword, rule, schema, value, at);
                true
            }
            "items" => {
                self.items(rule, value, at);
                true
            }
            "additionalItems" | "else" => true,
            _ if WORDS.contains(&keyword) => true,
            _ => panic!("{at}: the validator does not know `{keyword}`"),
        }
    }

    /// Whether one of several ways fits; what is found in it counts then.
    fn branch(&mut self, schema: &Value, value: &Value, at: &str) -> bool {
        let mut found = Self::default();
        found.check(schema, value, at);
        let fits = found.wrong.is_empty();
        if fits {
            self.numbers.extend(found.numbers);
        }
        fits
    }

    fn fields(&mut self, keyword: &str, rule: &Value, schema: &Map<String, Value>, value: &Value, at: &str) {
        for (name, field) in value.as_object().into_iter().flatten() {
            let own = schema.get("properties").and_then(|fields| fields.get(name));
            let at = format!("{at}/{name}");
            match (keyword, own) {
                ("properties", Some(own)) => self.check(own, field, &at),
                ("additionalProperties", None) => self.check(rule, field, &at),
                ("propertyNames", _) => self.check(rule, &Value::String(name.clone()), &at),
                _ => {}
            }
        }
    }

    fn items(&mut self, rule: &Value, value: &Value, at: &str) {
        for (i, item) in value.as_array().into_iter().flatten().enumerate() {
            let of_place = rule.as_array().map_or(Some(rule), |rules| rules.get(i));
            of_place.into_iter().for_each(|rule| self.check(rule, item, &format!("{at}/{i}")));
        }
    }

    fn note(&mut self, schema: &Map<String, Value>, at: &str) {
        let bounds = self.numbers.entry(at.to_owned()).or_default();
        let number = |keyword: &str| schema.get(keyword).and_then(Value::as_f64);
        bounds.least = bounds.least.or_else(|| number("minimum"));
        bounds.above = bounds.above.or_else(|| number("exclusiveMinimum"));
        bounds.most = bounds.most.or_else(|| number("maximum"));
        bounds.is_whole |= schema.get("type").is_some_and(|name| name == "integer");
        bounds.is_one_of |= schema.contains_key("enum");
    }
}

fn has_type(value: &Value, rule: &Value) -> bool {
    match rule.as_str().expect("one type") {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        other => panic!("the validator does not know the type {other}"),
    }
}

/// The patterns that there are.
fn fits(text: &str, pattern: &str) -> bool {
    if pattern == "^(pty|tcp|rfc2217|unix):." {
        return text
            .split_once(':')
            .is_some_and(|(kind, _)| ["pty", "tcp", "rfc2217", "unix"].contains(&kind));
    }
    let most = pattern.strip_prefix("^[A-Za-z0-9_-]{1,").and_then(|rest| rest.strip_suffix("}$"));
    let most: usize =
        most.unwrap_or_else(|| panic!("the validator does not know {pattern}")).parse().unwrap();
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    (1..=most).contains(&text.len()) && text.chars().all(is_of_name)
}
