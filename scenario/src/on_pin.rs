//! The forms in which a file may say what is on a pin, and which program runs.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_fields::Path;

use crate::pins::{Inline, Options};

/// What is on a pin, in the order of the pins' names.
#[derive(Debug, Default, serde::Deserialize)]
#[serde(transparent)]
pub(super) struct Pins(BTreeMap<String, OnPin>);

#[derive(Clone, Debug, serde::Deserialize)]
#[serde(untagged)]
enum OnPin {
    One(Connection),
    Many(Vec<Connection>),
}

#[derive(Clone, Debug, serde::Deserialize)]
#[serde(untagged)]
enum Connection {
    Plain(String),
    With(Options),
}

impl Pins {
    /// Each connection: where it stands, the pin, and what is on it.
    pub(super) fn connections(&self, path: &Path) -> Vec<(Path, &str, Options)> {
        let mut all = Vec::new();
        for (pin, on) in &self.0 {
            let at = path.field(pin);
            match on {
                OnPin::One(one) => all.push((at, &**pin, one.options())),
                OnPin::Many(many) => {
                    let many = many.iter().enumerate();
                    all.extend(many.map(|(i, one)| (at.index(i), &**pin, one.options())));
                }
            }
        }
        all
    }
}

impl Connection {
    fn options(&self) -> Options {
        match self {
            Self::With(options) => options.clone(),
            Self::Plain(to) => Options {
                to: to.clone(),
                volts_at_0: None,
                volts_per_unit: None,
                divider: None,
                pull: None,
                drop_v: None,
                decay: None,
                lit_by: None,
                rc: None,
            },
        }
    }
}

/// A program that is in the text.
#[derive(Debug, serde::Deserialize)]
#[serde(untagged)]
pub(super) enum RawProgram {
    /// The name of a file, which somebody else must have replaced.
    File(String),
    Inline(Inline),
}
