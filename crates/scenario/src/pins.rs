//! What a file may say of what is on a pin, and the program that is put in place of a file's name.

use alloc::string::String;

use baudbot_board::{Decay, LitBy, Pull};
use baudbot_fields::number::{Between, Number, Share};
use baudbot_sim::chip::LowWhen;

/// A voltage by any unit of a sensor.
type Volts = Between<-1_000_000_000_000, 1_000_000_000_000>;

/// A connection with numbers of its own.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Options {
    /// The part on the pin, such as `sensors.ir_left`.
    pub(super) to: String,
    /// For a voltage: its size at the value 0, in volts, before the divider. Default: 0.0 with `volts_per_unit`;
    /// else 5.0 for a floor sensor, and 0 V at the smallest code of others.
    pub(super) volts_at_0: Option<Number<Volts>>,
    /// For a voltage: its increase per unit of the value, in volts. Default: 1.0 for a value in volts, −5.0 for a
    /// floor sensor; else the range of the sensor's codes spans the supply voltage.
    pub(super) volts_per_unit: Option<Number<Volts>>,
    /// For a voltage: fraction of it that reaches the pin. Default: 1.0.
    pub(super) divider: Option<Number<Share>>,
    /// For a voltage: a comparator with an open collector gives the pin a level: whether the voltage, before the divider, is above this.
    pub(super) threshold_v: Option<Number<Between<-100, 100>>>,
    /// For a comparator: width of the band around the threshold in which the level stays as it was. Default: 0.02.
    pub(super) hysteresis_v: Option<Number<Between<0, 100>>>,
    /// For a comparator: the side of the threshold on which the level is low. Default: `"below"`.
    pub(super) low_when: Option<LowWhen>,
    /// For a button or a switch: longest bounce of the contact. Default: 5.0.
    pub(super) bounce_ms: Option<Number<Between<0, 1000>>>,
    /// For a switch: the resistor that holds the open pin: high, or low with `"down"`, for a switch to the supply. Default: `"internal"`.
    pub(super) pull: Option<Pull>,
    /// For a motor shield: number of the motor, as printed on it. Default: 1 of the left motor, 2 of the right one. Range: 1
    /// to 4.
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 4)))]
    pub(super) channel: Option<u8>,
    /// For a motor's driver: voltage drop across it. Default: 2.55 of an L298N, 2.6 of a shield's L293D, 0.5 of a TB6612, else 0.0.
    pub(super) drop_v: Option<Number<Between<0, 100>>>,
    /// For a driver with PWM and direction: behaviour of the motor in the pauses of the PWM. Default: `"brake"`.
    pub(super) decay: Option<Decay>,
    /// For a light-emitting diode: the level that lights it. Default: `"high"`.
    pub(super) lit_by: Option<LitBy>,
    /// For a floor sensor: it is read by the discharge of a capacitor. Default: false on an analog pin, else true.
    pub(super) rc: Option<bool>,
}

/// What is put in place of a file's name.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Inline {
    /// File of the program, for error messages.
    #[serde(default)]
    pub(super) file: String,
    /// The flash, as Intel HEX.
    pub(super) hex: String,
    /// The EEPROM, as Intel HEX.
    pub(super) eeprom_hex: Option<String>,
    /// Chip that the program was built for, as the compiler notes it.
    pub(super) device: Option<String>,
    /// The fuse bytes of the ELF file. Range: each 0 to 255.
    pub(super) fuses: Option<[u8; 3]>,
    /// The address behind the last variable, below which the stack overwrites variables.
    pub(super) data_end: Option<u16>,
}
