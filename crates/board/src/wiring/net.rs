//! The wires of a board, by the names that are printed on it.

use alloc::format;
use alloc::string::{String, ToString};

use baudbot_avr::{Pin, Port};
use serde::{Deserialize, Serialize};

/// A net that a terminal can be connected to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Net {
    /// A pin of a port.
    Pin(Pin),
    /// ADC6 or ADC7, which parts in a package of 32 pins have, and which belong to no port.
    AnalogOnly(u8),
    /// Ground: `GND`.
    Ground,
    /// The supply of the chip: `VCC` or `5V`.
    Supply,
}

/// A digital pin of an Arduino of which analog input 0 is the pin 14.
const ANALOG_0: u8 = 14;

impl Net {
    /// The wire of this name: `A0` to `A7`, `0` to `19`, `D0` to `D13`, `PB0` to `PD7`, `GND`, `VCC`, `5V`; upper or lower case.
    pub fn by_name(name: &str) -> Option<Self> {
        if ["VCC", "5V"].iter().any(|supply| name.eq_ignore_ascii_case(supply)) {
            return Some(Self::Supply);
        }
        if name.eq_ignore_ascii_case("GND") {
            return Some(Self::Ground);
        }
        if let Ok(number) = name.strip_prefix(['D', 'd']).unwrap_or(name).parse() {
            return Self::arduino(number);
        }
        let digit = name.as_bytes().last()?.checked_sub(b'0').filter(|digit| *digit < 8)?;
        let port = match name.get(..name.len() - 1)? {
            "A" | "a" => return Self::analog(digit),
            "PB" | "pb" => Port::B,
            "PC" | "pc" => Port::C,
            "PD" | "pd" => Port::D,
            _ => return None,
        };
        Self::usable(port, digit)
    }

    /// The digital pin of this number on an Arduino: 0 to 13, and 14 to 19 for A0 to A5.
    pub const fn arduino(number: u8) -> Option<Self> {
        match number {
            0..=7 => Self::usable(Port::D, number),
            8..=13 => Self::usable(Port::B, number - 8),
            ANALOG_0..=19 => Self::analog(number - ANALOG_0),
            _ => None,
        }
    }

    const fn analog(number: u8) -> Option<Self> {
        match number {
            0..=5 => Self::usable(Port::C, number),
            6 | 7 => Some(Self::AnalogOnly(number)),
            _ => None,
        }
    }

    /// Whether a board has such a wire.
    pub(super) const fn is_possible(self) -> bool {
        match self {
            Self::Pin(pin) => Self::usable(pin.port(), pin.bit()).is_some(),
            Self::AnalogOnly(channel) => matches!(channel, 6 | 7),
            Self::Ground | Self::Supply => true,
        }
    }

    /// The usable pins: PC7 does not exist. PC6 is the reset, PB6 and PB7 are the crystal's only by the fuses.
    const fn usable(port: Port, bit: u8) -> Option<Self> {
        match (port, bit) {
            (Port::C, 7) => None,
            _ => match Pin::new(port, bit) {
                Some(pin) => Some(Self::Pin(pin)),
                None => None,
            },
        }
    }

    /// The name printed on an Arduino: `9`, `A0`; for nets without a number there that of the data sheet: `PB6`, `GND`.
    pub fn printed(self) -> String {
        match (0..=19).find(|&number| Self::arduino(number) == Some(self)) {
            Some(number @ ANALOG_0..) => format!("A{}", number - ANALOG_0),
            Some(number) => number.to_string(),
            None => self.to_string(),
        }
    }

    /// The place of the net in a list of pins: those with a number first, then A6 and A7, the others, the supply and
    /// ground.
    fn place(self) -> (u8, u8) {
        match self {
            Self::Pin(pin) => match (0..=19).find(|&number| Self::arduino(number) == Some(self)) {
                Some(number) => (0, number),
                None => (2, pin.bit()),
            },
            Self::AnalogOnly(channel) => (1, channel),
            Self::Supply => (3, 0),
            Self::Ground => (3, 1),
        }
    }

    /// Whether it stands before another one in a list of pins.
    pub fn order(self, other: Self) -> core::cmp::Ordering {
        self.place().cmp(&other.place())
    }

    /// The pin, if it is one.
    pub const fn pin(self) -> Option<Pin> {
        match self {
            Self::Pin(pin) => Some(pin),
            Self::AnalogOnly(_) | Self::Ground | Self::Supply => None,
        }
    }

    /// The channel of the ADC on this wire.
    pub const fn adc_channel(self) -> Option<u8> {
        match self {
            Self::Pin(pin) if matches!(pin.port(), Port::C) && pin.bit() < 6 => Some(pin.bit()),
            Self::AnalogOnly(channel) => Some(channel),
            Self::Pin(_) | Self::Ground | Self::Supply => None,
        }
    }
}

impl core::fmt::Display for Net {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Pin(pin) => write!(f, "{pin:?}"),
            Self::AnalogOnly(channel) => write!(f, "A{channel}"),
            Self::Ground => f.write_str("GND"),
            Self::Supply => f.write_str("VCC"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pin(port: Port, bit: u8) -> Option<Net> {
        Pin::new(port, bit).map(Net::Pin)
    }

    #[test]
    fn names_of_arduino_and_of_ports_mean_the_same_pins() {
        for (names, net) in [
            (["9", "PB1", "pb1"], pin(Port::B, 1)),
            (["A3", "PC3", "17"], pin(Port::C, 3)),
            (["2", "PD2", "pd2"], pin(Port::D, 2)),
            (["13", "PB5", "pb5"], pin(Port::B, 5)),
            (["A6", "a6", "A6"], Some(Net::AnalogOnly(6))),
            (["VCC", "5v", "5V"], Some(Net::Supply)),
        ] {
            assert_eq!(names.map(Net::by_name), [net; 3], "{names:?}");
        }
    }

    #[test]
    fn what_no_board_has_is_no_name() {
        for name in ["", "A8", "20", "PB8", "PC7", "PE0", "-1", "A", "é", "Pé1"] {
            assert_eq!(Net::by_name(name), None, "{name}");
        }
    }

    #[test]
    fn the_adc_is_on_a0_to_a7_only() {
        let channels =
            ["A0", "A5", "A7", "PC6", "9", "GND"].map(|name| Net::by_name(name).and_then(Net::adc_channel));
        assert_eq!(channels, [Some(0), Some(5), Some(7), None, None, None]);
    }
}
