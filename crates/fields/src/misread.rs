//! The reason why a value of TOML cannot be read: the place in it, words, and the cause.

use alloc::boxed::Box;
use alloc::string::{String, ToString};
use core::fmt::{self, Display};

use serde::de::{self, Error as _, Unexpected};
use toml::Value;

use crate::{Cause, words};

/// A reason why a value of TOML is not of a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{problem}", if path.is_empty() { String::new() } else { alloc::format!("{path}: ") })]
pub struct Misread {
    /// The path in the value, such as `start.x_m`; empty for the value itself.
    pub path: String,
    /// The problem.
    pub problem: String,
    /// The kind of problem.
    pub cause: Cause,
}

/// A fault, with its place below the value that is read: each part of a value adds its place on the way out. In a
/// box, as code for values that fit passes it on everywhere.
#[derive(Debug)]
pub(crate) struct Problem(pub(crate) Box<Misread>);

impl Problem {
    fn new(problem: String, cause: Cause) -> Self {
        Self(Box::new(Misread { path: String::new(), problem, cause }))
    }

    pub(crate) fn value(words: String) -> Self {
        Self::new(words, Cause::Value)
    }

    /// The same below this element of a list.
    pub(crate) fn in_element(self, i: usize) -> Self {
        self.in_field(&alloc::format!("[{i}]"))
    }

    /// The same below the field of this name.
    pub(crate) fn in_field(mut self, name: &str) -> Self {
        let path = &mut self.0.path;
        if !path.is_empty() && !path.starts_with('[') {
            path.insert(0, '.');
        }
        path.insert_str(0, name);
        self
    }
}

impl Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.problem)
    }
}

impl core::error::Error for Problem {}

impl de::Error for Problem {
    fn custom<T: Display>(words: T) -> Self {
        Self::value(words.to_string())
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn de::Expected) -> Self {
        Self::value(words::wrong(&found, expected))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn de::Expected) -> Self {
        Self::value(words::wrong(&found, expected))
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Self::value(words::unknown(name, known))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let cause = Cause::UnknownField { name: field.into(), known: expected.into() };
        let text =
            de::value::Error::unknown_field(field, expected).to_string() + &words::meant(field, expected);
        Self::new(text, cause)
    }

    fn missing_field(field: &'static str) -> Self {
        Self::new(de::value::Error::missing_field(field).to_string(), Cause::MissingField)
    }
}

/// A value of another type than is expected.
pub(crate) fn wrong(found: &Value, expected: &dyn de::Expected) -> Problem {
    let found = match found {
        Value::Boolean(value) => Unexpected::Bool(*value),
        Value::Integer(value) => Unexpected::Signed(*value),
        Value::Float(value) => Unexpected::Float(*value),
        Value::String(value) => Unexpected::Str(value),
        Value::Datetime(_) => Unexpected::Other("a date"),
        Value::Array(_) => Unexpected::Seq,
        Value::Table(_) => Unexpected::Map,
    };
    Problem::invalid_type(found, expected)
}
