//! The forms in which a file may say what is on a pin, and which program runs.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt::Formatter;

use baudbot_fields::Path;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::pins::{Inline, Options};

/// What is on a pin, in the order of the pins' names.
#[derive(Debug, Default, serde::Deserialize)]
#[serde(transparent)]
pub(super) struct Pins(BTreeMap<String, OnPin>);

#[derive(Clone, Debug)]
struct OnPin(Vec<Connection>);

#[derive(Clone, Debug)]
enum Connection {
    Plain(String),
    With(Options),
}

// Both are read by hand, because an untagged enum reads a copy, of which errors do not say the field.
impl<'de> Deserialize<'de> for OnPin {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMany;

        impl<'de> Visitor<'de> for OneOrMany {
            type Value = OnPin;

            fn expecting(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
                f.write_str("a text, a list, or a table with `to`")
            }

            fn visit_str<E: Error>(self, to: &str) -> Result<OnPin, E> {
                Ok(OnPin(vec![Connection::Plain(to.into())]))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<OnPin, A::Error> {
                Connection::deserialize(MapAccessDeserializer::new(map)).map(|one| OnPin(vec![one]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, many: A) -> Result<OnPin, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(many)).map(OnPin)
            }
        }

        deserializer.deserialize_any(OneOrMany)
    }
}

impl<'de> Deserialize<'de> for Connection {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct One;

        impl<'de> Visitor<'de> for One {
            type Value = Connection;

            fn expecting(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
                f.write_str("a text, or a table with `to`")
            }

            fn visit_str<E: Error>(self, to: &str) -> Result<Connection, E> {
                Ok(Connection::Plain(to.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Connection, A::Error> {
                Options::deserialize(MapAccessDeserializer::new(map)).map(Connection::With)
            }
        }

        deserializer.deserialize_any(One)
    }
}

impl Pins {
    /// Each connection: where it stands, the pin, and what is on it.
    pub(super) fn connections(&self, path: &Path) -> Vec<(Path, &str, Options)> {
        let mut all = Vec::new();
        for (pin, on) in &self.0 {
            let at = path.field(pin);
            for (i, one) in on.0.iter().enumerate() {
                let at = if on.0.len() == 1 { at.clone() } else { at.index(i) };
                all.push((at, &**pin, one.options()));
            }
        }
        all
    }
}

impl Connection {
    fn options(&self) -> Options {
        match self {
            Self::With(options) => options.clone(),
            Self::Plain(to) => Options { to: to.clone(), ..Options::default() },
        }
    }
}

/// A program that is in the text.
#[derive(Debug, serde::Deserialize)]
#[serde(untagged, expecting = "must be the name of a file, or a table with `hex`, the flash as Intel HEX")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) enum RawProgram {
    /// The name of a file, which somebody else must have replaced.
    File(String),
    Inline(Inline),
}
