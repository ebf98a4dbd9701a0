//! What a file may say of what is on a pin, and the program that is put in place of a file's name.

use alloc::string::String;

use baudbot_board::{Decay, LitBy, Pull};
use baudbot_fields::number::{Between, Number, Share};

/// A voltage by any unit of a sensor.
type Volts = Between<-1_000_000_000_000, 1_000_000_000_000>;

/// A connection with numbers of its own.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Options {
    /// What is on the pin, such as `sensors.ir_left`.
    pub(super) to: String,
    /// Of a voltage: what the pin has at the value 0, in volts. Default: 0.0.
    pub(super) volts_at_0: Option<Number<Volts>>,
    /// Of a voltage: how much more for each unit of the value, in volts. Default: the range of the sensor's
    /// code is that of the supply.
    pub(super) volts_per_unit: Option<Number<Volts>>,
    /// Of a voltage: the share that the pin gets. Default: 1.0.
    pub(super) divider: Option<Number<Share>>,
    /// Of a switch: what makes its open pin high. Default: `"internal"`.
    pub(super) pull: Option<Pull>,
    /// Of a motor's driver: what it takes from the motor, in volts. Default: 2.55 of an L298N, 0.5 of a TB6612,
    /// else 0.0.
    pub(super) drop_v: Option<Number<Between<0, 100>>>,
    /// Of a driver with PWM and direction: what the motor does in the pauses. Default: `"brake"`.
    pub(super) decay: Option<Decay>,
    /// Of a light: the level that lights it. Default: `"high"`.
    pub(super) lit_by: Option<LitBy>,
    /// Of a floor sensor: it discharges a capacitor. Default: false on an analog pin, else true.
    pub(super) rc: Option<bool>,
}

/// What is put in place of a file's name.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Inline {
    /// The file that it is from, for errors.
    #[serde(default)]
    pub(super) file: String,
    /// The flash, as Intel HEX.
    pub(super) hex: String,
    /// The EEPROM, as Intel HEX.
    pub(super) eeprom_hex: Option<String>,
    /// The part that it was built for, as the compiler notes it.
    pub(super) device: Option<String>,
    /// The fuse bytes of the ELF file. Range: each 0 to 255.
    pub(super) fuses: Option<[u8; 3]>,
    /// The address behind the last variable, below which the stack overwrites variables.
    pub(super) data_end: Option<u16>,
}
