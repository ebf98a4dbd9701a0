//! The description of a map in YAML, and the errors of one that is invalid.
//!
//! Values are read as loosely as ROS reads them: `negate` may be a number or a word, `mode` in capitals, numbers in quotation marks.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_saphyr::Error;
use serde_saphyr::options::{DuplicateKeyPolicy, NonFiniteFloatPolicy};

use super::problem::DescriptionError;

/// The names and values of the file, in its order. Map servers and their friends may have more than we know.
pub(crate) struct Description(Vec<(String, Value)>);

/// The value behind a name.
#[derive(Clone, Debug)]
enum Value {
    Nothing,
    Flag(bool),
    Number(f64),
    Text(String),
    List(Vec<Self>),
    Table,
}

impl Description {
    pub(crate) fn parse(text: &str) -> Result<Self, DescriptionError> {
        let options = serde_saphyr::options! {
            duplicate_keys: DuplicateKeyPolicy::PassThrough,
            non_finite_float_policy: NonFiniteFloatPolicy::PassThrough,
        };
        let Entries(mut entries) = serde_saphyr::from_str_with_options(text, options)
            .map_err(|error| DescriptionError::Yaml(in_words(&error)))?;
        let is_twice = |i: usize| entries[..i].iter().any(|(name, _)| *name == entries[i].0);
        if let Some(i) = (0..entries.len()).find(|&i| is_twice(i)) {
            return Err(DescriptionError::Twice(entries.swap_remove(i).0));
        }
        Ok(Self(entries))
    }

    /// The value behind this name, unless that is nothing.
    fn value(&self, name: &str) -> Option<&Value> {
        let value = self.0.iter().find(|(other, _)| other == name).map(|(_, value)| value);
        value.filter(|value| !matches!(value, Value::Nothing))
    }

    pub(crate) fn text(&self, name: &str) -> Result<Option<String>, DescriptionError> {
        match self.value(name) {
            None => Ok(None),
            Some(value @ (Value::Text(_) | Value::Number(_) | Value::Flag(_))) => Ok(Some(value.to_string())),
            Some(other) => Err(form(name, "a text", other)),
        }
    }

    pub(crate) fn number(&self, name: &str) -> Result<Option<f64>, DescriptionError> {
        let Some(value) = self.value(name) else { return Ok(None) };
        value.number().map(Some).ok_or_else(|| form(name, "a number", value))
    }

    /// The numbers of a list.
    pub(crate) fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, DescriptionError> {
        let Some(value) = self.value(name) else { return Ok(None) };
        let numbers = match value {
            Value::List(values) => values.iter().map(Value::number).collect(),
            Value::Nothing | Value::Flag(_) | Value::Number(_) | Value::Text(_) | Value::Table => None,
        };
        numbers.map(Some).ok_or_else(|| form(name, "a list of numbers", value))
    }

    /// A number that is 0 or 1, or a word for it.
    pub(crate) fn flag(&self, name: &str) -> Result<bool, DescriptionError> {
        let Some(value) = self.value(name) else { return Ok(false) };
        let is_set = match value {
            Value::Flag(is_set) => Some(*is_set),
            Value::Text(text) => match &*text.to_ascii_lowercase() {
                "true" | "yes" | "on" | "y" => Some(true),
                "false" | "no" | "off" | "n" => Some(false),
                _ => value.number().and_then(zero_or_one),
            },
            Value::Number(number) => zero_or_one(*number),
            Value::Nothing | Value::List(_) | Value::Table => None,
        };
        is_set.ok_or_else(|| form(name, "0, 1, true or false", value))
    }
}

/// The value behind this name has another form than this.
fn form(name: &str, form: &'static str, value: &Value) -> DescriptionError {
    DescriptionError::Form { name: name.to_owned(), form, value: value.to_string() }
}

fn zero_or_one(number: f64) -> Option<bool> {
    if number == 0.0 {
        Some(false)
    } else if number == 1.0 {
        Some(true)
    } else {
        None
    }
}

impl Value {
    fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => text.trim().parse().ok(),
            Self::Nothing | Self::Flag(_) | Self::List(_) | Self::Table => None,
        }
    }
}

/// The value as it stands in the file, more or less.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => f.write_str("nothing"),
            Self::Flag(is_set) => write!(f, "{is_set}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Text(text) => f.write_str(text),
            Self::List(values) => {
                let values: Vec<_> = values.iter().map(ToString::to_string).collect();
                write!(f, "[{}]", values.join(", "))
            }
            Self::Table => f.write_str("a table"),
        }
    }
}

/// The fault of the file, without words of the crate that reads it or of Rust's.
#[expect(clippy::wildcard_enum_match_arm, reason = "the enum is not exhaustive, and has what no map has")]
fn in_words(error: &Error) -> String {
    let line = error.location().map_or_else(String::new, |location| format!("line {}: ", location.line()));
    let problem = match error.without_snippet() {
        // The scanner's errors are about characters and brackets; the others are ours.
        Error::Message { msg, .. } | Error::ExternalMessage { msg, .. } => {
            msg.strip_suffix(&format!(", {EXPECTED}")).map_or_else(|| msg.clone(), |_| EXPECTED.to_owned())
        }
        Error::Unexpected { .. } | Error::SerdeInvalidType { .. } => EXPECTED.to_owned(),
        Error::MultipleDocuments { .. } => "has more than one document: keep only the first".to_owned(),
        Error::UnknownAnchor { .. } => "refers to an anchor that does not exist".to_owned(),
        Error::RecursiveReferencesRequireWeakTypes { .. } => "refers to itself".to_owned(),
        Error::Eof { .. } => "ends too early".to_owned(),
        _ => "is not YAML that is supported here".to_owned(),
    };
    format!("{line}{problem}")
}

const EXPECTED: &str = "must be names with values, such as `resolution: 0.05`";

/// The file as names and values. A name may stand there twice.
struct Entries(Vec<(String, Value)>);

impl<'de> Deserialize<'de> for Entries {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Entries;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(EXPECTED)
            }

            fn visit_unit<E>(self) -> Result<Entries, E> {
                Ok(Entries(Vec::new()))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(Reader)
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ValueReader)
    }
}

/// Takes any value of YAML; what is in a table is passed over.
struct ValueReader;

impl<'de> Visitor<'de> for ValueReader {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("must be a number, a text, a list or a table")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Nothing)
    }

    fn visit_bool<E>(self, is_set: bool) -> Result<Value, E> {
        Ok(Value::Flag(is_set))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::Number(number as f64))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value::Number(number as f64))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        Ok(Value::Number(number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(Value::List(values))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Value::Table)
    }
}
