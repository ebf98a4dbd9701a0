//! A value of TOML and its parts as serde takes them. Each part adds its place to the path of an error in it: the crate `serde_path_to_error`
//! does that, too, but compiles each type that is read a second time, which the page without a server has no room for. A test compares the paths.

use alloc::string::{String, ToString};
use alloc::vec::{self, Vec};

use serde::Deserialize as _;
use serde::de::value::StringDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, IntoDeserializer as _, MapAccess, SeqAccess,
    Unexpected, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use toml::{Table, Value};

use crate::misread::{Problem, wrong};
use crate::words;

/// A value whose errors have causes.
pub(crate) struct Tree(pub(crate) Value);

impl<'de> Deserializer<'de> for Tree {
    type Error = Problem;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        match self.0 {
            Value::Boolean(value) => visitor.visit_bool(value),
            Value::Integer(value) => visitor.visit_i64(value),
            Value::Float(value) => visitor.visit_f64(value),
            Value::String(value) => visitor.visit_string(value),
            Value::Datetime(value) => visitor.visit_string(value.to_string()),
            Value::Array(values) => visitor.visit_seq(Elements::new(values)),
            // A visitor of a map takes all of it, or names the field that is wrong.
            Value::Table(table) => visitor.visit_map(Entries::new(table)),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        let Value::Array(values) = self.0 else { return Err(wrong(&self.0, &visitor)) };
        visitor.visit_seq(Elements::new(values))
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        let Value::Table(table) = self.0 else { return Err(wrong(&self.0, &visitor)) };
        visitor.visit_map(Entries::new(table))
    }

    /// A struct comes from a table only. Serde would take a list, too, of values in the order in which the program has
    /// the fields.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Problem> {
        self.deserialize_map(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Problem> {
        if let Value::Array(values) = &self.0
            && values.len() != length
        {
            return Err(Problem::value(words::wrong_length(values.len(), length)));
        }
        self.deserialize_seq(visitor)
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
            Value::String(name) => visitor.visit_enum(Variant { name, content: None }),
            Value::Table(table) => {
                let fields = table.len();
                let mut entries = table.into_iter();
                match (entries.next(), entries.next()) {
                    (Some((name, content)), None) => {
                        visitor.visit_enum(Variant { name, content: Some(Self(content)) })
                    }
                    _ => Err(Problem::value(alloc::format!("must be a table with 1 field, has {fields}"))),
                }
            }
            Value::Boolean(_)
            | Value::Integer(_)
            | Value::Float(_)
            | Value::Datetime(_)
            | Value::Array(_) => Err(wrong(&self.0, &"a string")),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        identifier ignored_any
    }
}

/// The elements of a list.
pub(crate) struct Elements {
    rest: vec::IntoIter<Value>,
    /// The number of values that were taken.
    taken: usize,
}

impl Elements {
    pub(crate) fn new(values: Vec<Value>) -> Self {
        Self { rest: values.into_iter(), taken: 0 }
    }

    fn next(&mut self) -> Option<Tree> {
        let value = self.rest.next()?;
        self.taken += 1;
        Some(Tree(value))
    }

    /// A problem in the element that was taken last.
    fn in_last(&self, problem: Problem) -> Problem {
        problem.in_element(self.taken - 1)
    }
}

impl<'de> SeqAccess<'de> for Elements {
    type Error = Problem;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Problem> {
        let Some(value) = self.next() else { return Ok(None) };
        seed.deserialize(value).map(Some).map_err(|problem| self.in_last(problem))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// The entries of a table.
pub(crate) struct Entries {
    rest: toml::map::IntoIter<String, Value>,
    key: String,
    value: Option<Value>,
}

impl Entries {
    pub(crate) fn new(table: Table) -> Self {
        Self { rest: table.into_iter(), key: String::new(), value: None }
    }

    /// Goes to the next entry.
    fn next(&mut self) -> Option<StringDeserializer<Problem>> {
        let (key, value) = self.rest.next()?;
        (self.key, self.value) = (key, Some(value));
        Some(name(&self.key))
    }

    fn take(&mut self) -> Result<Tree, Problem> {
        self.value.take().map(Tree).ok_or_else(|| Problem::custom("a value without a key"))
    }

    /// A problem in this entry.
    fn in_this(&self, problem: Problem) -> Problem {
        problem.in_field(&self.key)
    }
}

impl<'de> MapAccess<'de> for Entries {
    type Error = Problem;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Problem> {
        let Some(key) = self.next() else { return Ok(None) };
        seed.deserialize(key).map(Some).map_err(|problem| self.in_this(problem))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Problem> {
        seed.deserialize(self.take()?).map_err(|problem| self.in_this(problem))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// A variant of an enum: a name, or a table with this name as its only field.
pub(crate) struct Variant {
    pub(crate) name: String,
    pub(crate) content: Option<Tree>,
}

impl<'de> EnumAccess<'de> for Variant {
    type Error = Problem;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Problem> {
        Ok((seed.deserialize(name(&self.name))?, self))
    }
}

impl Variant {
    /// Reads the content, which is expected to be of this kind.
    fn read<T>(self, kind: &str, read: impl FnOnce(Tree) -> Result<T, Problem>) -> Result<T, Problem> {
        let missing = || Problem::invalid_type(Unexpected::UnitVariant, &kind);
        self.content.map_or_else(|| Err(missing()), read).map_err(|problem| problem.in_field(&self.name))
    }
}

impl<'de> VariantAccess<'de> for Variant {
    type Error = Problem;

    fn unit_variant(self) -> Result<(), Problem> {
        if self.content.is_none() { Ok(()) } else { self.read("unit variant", <()>::deserialize) }
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Problem> {
        self.read("newtype variant", |content| seed.deserialize(content))
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Problem> {
        self.read("tuple variant", |content| content.deserialize_tuple(length, visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Problem> {
        self.read("struct variant", |content| content.deserialize_map(visitor))
    }
}

fn name(text: &str) -> StringDeserializer<Problem> {
    String::from(text).into_deserializer()
}
