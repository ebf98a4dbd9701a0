//! What a file may say of what is on a pin, and the program that is put in place of a file's name.

use alloc::string::String;

use baudbot_board::{Decay, LitBy, Pull};

/// A connection with numbers of its own.
#[derive(Clone, Debug, Default, serde::Deserialize)]
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
    /// The part that it was built for.
    pub(super) device: Option<String>,
    /// Low, high and extended.
    pub(super) fuses: Option<[u8; 3]>,
    /// Behind the last variable.
    pub(super) data_end: Option<u16>,
}
