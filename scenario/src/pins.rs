//! What a file may say of a microcontroller's pins and of its program.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_fields::Path;

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

/// A connection with numbers of its own.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Options {
    pub(super) to: String,
    pub(super) volts_at_0: Option<f64>,
    pub(super) volts_per_unit: Option<f64>,
    pub(super) divider: Option<f64>,
    pub(super) pull: Option<Pull>,
    pub(super) drop_v: Option<f64>,
    pub(super) decay: Option<Decay>,
    pub(super) lit_by: Option<LitBy>,
    pub(super) rc: Option<bool>,
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Pull {
    External,
    Internal,
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Decay {
    Brake,
    Coast,
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LitBy {
    High,
    Low,
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

/// What is put in place of a file's name.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Inline {
    /// The file that it is from, for errors.
    #[serde(default)]
    pub(super) file: String,
    /// The flash as Intel HEX.
    pub(super) hex: String,
    /// The EEPROM as Intel HEX.
    pub(super) eeprom_hex: Option<String>,
    /// Low, high and extended.
    pub(super) fuses: Option<[u8; 3]>,
    /// Behind the last variable.
    pub(super) data_end: Option<u16>,
}
