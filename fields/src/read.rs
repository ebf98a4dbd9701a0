//! From a value of TOML to a type. The reader of the crate `toml` gives its errors as text only; this one keeps the cause.

use alloc::string::{String, ToString};
use core::fmt::{self, Display};

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{self, DeserializeOwned, IntoDeserializer, Unexpected, Visitor};
use serde::forward_to_deserialize_any;
use toml::Value;

use crate::{Cause, words};

/// Why a value of TOML is not of a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{problem}", if path.is_empty() { String::new() } else { alloc::format!("{path}: ") })]
pub struct Misread {
    /// Where in the value, such as `start.x_m`; empty for the value itself.
    pub path: String,
    /// The problem.
    pub problem: String,
    /// The kind of problem.
    pub cause: Cause,
}

/// Reads a value of TOML.
///
/// # Errors
/// Names the field that is missing, unknown, or of the wrong type.
pub fn read<T: DeserializeOwned>(value: impl Into<Value>) -> Result<T, Misread> {
    serde_path_to_error::deserialize(Tree(value.into())).map_err(|error| {
        let path = error.path().to_string();
        let Problem { words, cause } = error.into_inner();
        Misread { path: if path == "." { String::new() } else { path }, problem: words, cause }
    })
}

/// A value whose errors have causes.
struct Tree(Value);

#[derive(Debug)]
struct Problem {
    words: String,
    cause: Cause,
}

impl Problem {
    fn value(words: String) -> Self {
        Self { words, cause: Cause::Value }
    }

    /// In the words that serde has for it.
    fn new(error: &de::value::Error, cause: Cause) -> Self {
        Self { words: error.to_string(), cause }
    }
}

impl Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
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
        Self::new(&de::Error::unknown_field(field, expected), cause)
    }

    fn missing_field(field: &'static str) -> Self {
        Self::new(&de::Error::missing_field(field), Cause::MissingField)
    }
}

impl IntoDeserializer<'_, Problem> for Tree {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> de::Deserializer<'de> for Tree {
    type Error = Problem;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        match self.0 {
            Value::Boolean(value) => visitor.visit_bool(value),
            Value::Integer(value) => visitor.visit_i64(value),
            Value::Float(value) => visitor.visit_f64(value),
            Value::String(value) => visitor.visit_string(value),
            Value::Datetime(value) => visitor.visit_string(value.to_string()),
            Value::Array(values) => {
                visitor.visit_seq(&mut SeqDeserializer::new(values.into_iter().map(Tree)))
            }
            // A visitor of a map takes all of it, or says which field is wrong.
            Value::Table(table) => visitor
                .visit_map(MapDeserializer::new(table.into_iter().map(|(key, value)| (key, Self(value))))),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Problem> {
        if let Value::Array(values) = &self.0
            && values.len() != length
        {
            return Err(Problem::value(words::wrong_length(values.len(), length)));
        }
        self.deserialize_any(visitor)
    }

    /// Fields have names: a list of their values is no table.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Problem> {
        if matches!(self.0, Value::Array(_)) {
            return Err(de::Error::invalid_type(Unexpected::Seq, &visitor));
        }
        self.deserialize_any(visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Problem> {
        self.deserialize_tuple(length, visitor)
    }

    /// TOML has no null: what stands there is some value.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Problem> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Problem> {
        match self.0 {
            Value::String(variant) => visitor.visit_enum(variant.into_deserializer()),
            Value::Table(table) if table.len() == 1 => {
                let entries = table.into_iter().map(|(key, value)| (key, Self(value)));
                visitor.visit_enum(de::value::MapAccessDeserializer::new(MapDeserializer::new(entries)))
            }
            Value::Table(table) => {
                Err(Problem::value(alloc::format!("must be a table with 1 field, has {}", table.len())))
            }
            Value::Boolean(value) => Err(not_a_name(Unexpected::Bool(value))),
            Value::Integer(value) => Err(not_a_name(Unexpected::Signed(value))),
            Value::Float(value) => Err(not_a_name(Unexpected::Float(value))),
            Value::Datetime(_) => Err(not_a_name(Unexpected::Other("a date"))),
            Value::Array(_) => Err(not_a_name(Unexpected::Seq)),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq
        map identifier ignored_any
    }
}

fn not_a_name(found: Unexpected<'_>) -> Problem {
    de::Error::invalid_type(found, &"a string")
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use serde::Deserialize;
    use toml::Table;

    use super::*;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Sheet {
        range_m: f64,
        #[serde(default)]
        mark: Option<Mark>,
        #[serde(default)]
        places: Vec<[f64; 2]>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "kebab-case")]
    enum Mark {
        LightGrey,
        Rgb([u8; 3]),
    }

    fn misread(toml: &str) -> Misread {
        read::<Sheet>(toml.parse::<Table>().unwrap()).unwrap_err()
    }

    #[test]
    fn what_fits_is_read() {
        let read = |toml: &str| read::<Sheet>(toml.parse::<Table>().unwrap()).unwrap();
        let sheet = read("range_m = 2\nmark = { rgb = [1, 2, 3] }\nplaces = [[0.5, 1]]");
        assert_eq!(sheet, Sheet { range_m: 2.0, mark: Some(Mark::Rgb([1, 2, 3])), places: vec![[0.5, 1.0]] });
        assert_eq!(read("range_m = 2.0\nmark = \"light-grey\"").mark, Some(Mark::LightGrey));
    }

    #[test]
    fn fields_that_are_not_there_have_their_cause() {
        let error = misread("range_m = 1.0\nrnge_m = 2.0");
        let known = ["range_m", "mark", "places"].into();
        assert_eq!(error.cause, Cause::UnknownField { name: "rnge_m".into(), known });
        let expected = "unknown field `rnge_m`, expected one of `range_m`, `mark`, `places`";
        assert_eq!((error.path.as_str(), error.problem.as_str()), ("rnge_m", expected));
        let error = misread("places = []");
        assert_eq!((error.path.as_str(), error.problem.as_str()), ("", "missing field `range_m`"));
        assert_eq!(error.cause, Cause::MissingField);
    }

    /// Paths are those that the crate `toml` has for the same values; words are those of a file.
    #[test]
    fn what_does_not_fit_is_told_in_words_of_toml() {
        let wrong = [
            ("range_m = \"far\"", "must be a number, is \"far\""),
            ("range_m = 1.0\nplaces = [[1.0, 2.0], [3.0]]", "must have 2 elements, has 1"),
            ("range_m = 1.0\nplaces = [[1.0, 2.0, 3.0]]", "must have 2 elements, has 3"),
            ("range_m = 1.0\nplaces = 7", "must be a list, is 7"),
            ("range_m = 1.0\nmark = \"dark\"", "must be `light-grey` or `rgb`, is `dark`"),
            ("range_m = 1.0\nmark = {}", "must be a table with 1 field, has 0"),
            ("range_m = 1.0\nmark = { rgb = [1, 2, 3], grey = 1 }", "must be a table with 1 field, has 2"),
            ("range_m = 1.0\nmark = { rgb = [1, 2, 300] }", "must be a whole number from 0 to 255, is 300"),
            ("range_m = 1.0\nmark = { rgb = [1, 2, 3.5] }", "must be a whole number from 0 to 255, is 3.5"),
            ("range_m = 1.0\nmark = 5", "must be a string, is 5"),
            ("range_m = 1.0\nmark = [true]", "must be a string, is a list"),
            ("range_m = 1979-05-27", "must be a number, is \"1979-05-27\""),
            ("range_m = { x = 1 }", "must be a number, is a table"),
            ("mark = \"light-grey\"", "missing field `range_m`"),
            ("other = 1", "unknown field `other`, expected one of `range_m`, `mark`, `places`"),
        ];
        for (toml, words) in wrong {
            let ours = misread(toml);
            assert_eq!(ours.problem, words, "{toml}");
            let theirs: Result<Sheet, _> = serde_path_to_error::deserialize(toml.parse::<Table>().unwrap());
            let path = if ours.path.is_empty() { "." } else { &ours.path };
            assert_eq!(path, theirs.unwrap_err().path().to_string(), "{toml}");
        }
    }

    /// Otherwise `sheet = [1.0]` would be a sheet whose fields have no names.
    #[test]
    fn a_list_is_no_table() {
        let sheet: Value = "sheet = [1.0]".parse::<Table>().unwrap().remove("sheet").unwrap();
        assert_eq!(read::<Sheet>(sheet).unwrap_err().problem, "must be a table, is a list");
    }

    #[test]
    fn the_name_that_was_meant_is_suggested() {
        assert_eq!(
            words::unknown("uat", &["ideal", "onboard", "uart"]),
            "must be one of `ideal`, `onboard`, `uart`, is `uat`; did you mean `uart`?"
        );
        assert_eq!(words::unknown("x", &["dc"]), "must be `dc`, is `x`");
    }
}
