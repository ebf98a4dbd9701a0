//! The forms in which a file may say what is on a pin, and which program runs.

use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_fields::Path;
use toml::Value;

use crate::pins::{Inline, Options};

/// What is on a pin, in the order of the pins' names.
#[derive(Debug, Default, serde::Deserialize)]
#[serde(transparent)]
pub(super) struct Pins(BTreeMap<String, OnPin>);

#[derive(Clone, Debug, serde::Deserialize)]
#[serde(try_from = "Value")]
struct OnPin(Vec<Connection>);

#[derive(Clone, Debug)]
enum Connection {
    Plain(String),
    With(Options),
}

impl TryFrom<Value> for OnPin {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        if let Value::Array(many) = value {
            return many.into_iter().map(Connection::try_from).collect::<Result<_, _>>().map(Self);
        }
        Connection::try_from(value).map(|one| Self(alloc::vec![one]))
    }
}

impl TryFrom<Value> for Connection {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        let kind = value.type_str();
        if let Value::String(to) = value {
            return Ok(Self::Plain(to));
        }
        let Value::Table(table) = value else {
            return Err(format!("takes a text, a list, or a table with `to`, not {kind}"));
        };
        table.try_into().map(Self::With).map_err(|error| error.message().to_string())
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
