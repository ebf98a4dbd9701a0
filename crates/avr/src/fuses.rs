//! The fuse bytes, and what they decide.
//!
//! Source: data sheet, sections *Fuse Bits*, *Boot Loader Support* (table *Boot Size Configuration*), *Clock Sources* and
//! *System Reset*.

use serde::{Deserialize, Serialize};

use crate::part::Part;
use crate::pin::{Pin, Port};

/// The three fuse bytes. A bit that is programmed reads as 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fuses {
    /// CKDIV8, CKOUT, SUT1:0, CKSEL3:0.
    pub low: u8,
    /// RSTDISBL, DWEN, SPIEN, WDTON, EESAVE; on an ATmega328 BOOTSZ1:0 and BOOTRST, else BODLEVEL2:0.
    pub high: u8,
    /// On an ATmega328 BODLEVEL2:0; on an ATmega88 and ATmega168 BOOTSZ1:0 and BOOTRST.
    pub extended: u8,
}

/// The delay of the processor after the start of the clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartUp {
    /// Cycles of the clock source, after a reset and after power-down.
    pub cycles: u32,
    /// The additional delay after a reset, in tenths of a millisecond.
    pub reset_100us: u32,
}

/// The function that takes a pin from its port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// The clock source: a crystal, a resonator or an external clock.
    Clock,
    /// The reset.
    Reset,
}

impl Fuses {
    /// The fuses of parts from the factory: internal oscillator of 8 MHz divided by 8, start at address 0.
    pub const fn factory(part: Part) -> Self {
        match part {
            Part::Atmega328 | Part::Atmega328P => Self { low: 0x62, high: 0xD9, extended: 0xFF },
            Part::Atmega48A | Part::Atmega48Pa => Self { low: 0x62, high: 0xDF, extended: 0xFF },
            Part::Atmega88A | Part::Atmega88Pa | Part::Atmega168A | Part::Atmega168Pa => {
                Self { low: 0x62, high: 0xDF, extended: 0xF9 }
            }
        }
    }

    /// The fuses of an Arduino Uno: a crystal, and a reset starts the boot section of 512 bytes.
    pub const ARDUINO_UNO: Self = Self { low: 0xFF, high: 0xDE, extended: 0xFD };

    /// The fuses with an external clock that is not divided: the shortest start-up, start at address 0.
    pub const fn external_clock(part: Part) -> Self {
        let factory = Self::factory(part);
        Self { low: 0xC0, ..factory }
    }

    /// CKDIV8: after a reset the clock is divided by 8.
    pub const fn divides_clock(self) -> bool {
        self.low & 0x80 == 0
    }

    /// WDTON: the watchdog is always on, and resets.
    pub const fn watchdog_always_on(self) -> bool {
        self.high & 0x10 == 0
    }

    /// BOOTRST: a reset starts the boot section.
    pub const fn starts_in_boot_section(self, part: Part) -> bool {
        part.properties().boot_words.is_some() && self.boot_byte(part) & 0x01 == 0
    }

    /// The word address at which the boot section begins; without one, the end of the flash.
    pub const fn boot_start(self, part: Part) -> u32 {
        match part.properties().boot_words {
            None => part.flash_words(),
            Some(smallest) => part.flash_words() - (smallest << (3 - (self.boot_byte(part) >> 1 & 3))),
        }
    }

    /// CKSEL: an internal oscillator, of 8 MHz or 128 kHz, is the clock source.
    pub const fn clocks_internally(self) -> bool {
        matches!(self.low & 0x0F, 2 | 3)
    }

    /// The function that takes a pin from its port for good: XTAL1 and XTAL2 belong to the clock source (CKSEL), PC6
    /// is the reset unless RSTDISBL is programmed. Data sheet, section *Alternate Functions of Port B* and *of Port
    /// C*.
    pub const fn takes(self, pin: Pin) -> Option<Taken> {
        match (pin.port(), pin.bit(), self.low & 0x0F) {
            (Port::C, 6, _) if self.high & 0x80 != 0 => Some(Taken::Reset),
            (Port::B, 6, _) if !self.clocks_internally() => Some(Taken::Clock),
            // An external clock leaves XTAL2 free.
            (Port::B, 7, 4..) => Some(Taken::Clock),
            _ => None,
        }
    }

    /// CKSEL and SUT: how long the clock takes to start.
    pub const fn start_up(self) -> StartUp {
        let sut = self.low >> 4 & 3;
        let (cycles, reset_100us) = match self.low & 0x0F {
            // External clock and internal oscillators: 6 cycles, and 14 CK after a reset.
            0..=3 => (6, [0, 41, 650, 650][sut as usize]),
            // Low-frequency crystal.
            4 | 6 => (1 << 10, [0, 41, 650, 650][sut as usize]),
            5 | 7 => (32 << 10, [0, 41, 650, 650][sut as usize]),
            // Crystals and resonators, CKSEL0 = 0: resonator, but for SUT = 3.
            8 | 10 | 12 | 14 => ([258, 258, 1 << 10, 1 << 10][sut as usize], [41, 650, 0, 41][sut as usize]),
            // CKSEL0 = 1.
            _ => ([1 << 10, 16 << 10, 16 << 10, 16 << 10][sut as usize], [650, 0, 41, 650][sut as usize]),
        };
        StartUp { cycles, reset_100us }
    }

    const fn boot_byte(self, part: Part) -> u8 {
        match part {
            Part::Atmega328 | Part::Atmega328P => self.high,
            Part::Atmega48A
            | Part::Atmega48Pa
            | Part::Atmega88A
            | Part::Atmega88Pa
            | Part::Atmega168A
            | Part::Atmega168Pa => self.extended,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crystal_takes_two_pins_an_external_clock_one_and_the_reset_one() {
        let taken = |low, high| {
            let fuses = Fuses { low, high, extended: 0xFD };
            [(Port::B, 6), (Port::B, 7), (Port::C, 6), (Port::B, 5)]
                .map(|(port, bit)| fuses.takes(Pin::new(port, bit).unwrap()))
        };
        let (clock, reset) = (Some(Taken::Clock), Some(Taken::Reset));
        assert_eq!(taken(0xFF, 0xDE), [clock, clock, reset, None]);
        assert_eq!(taken(0xC0, 0xD9), [clock, None, reset, None]);
        assert_eq!(taken(0x62, 0x59), [None; 4], "the internal oscillator, and RSTDISBL");
    }

    #[test]
    fn an_arduino_starts_in_its_boot_section_of_512_bytes() {
        let uno = Fuses::ARDUINO_UNO;
        assert!(uno.starts_in_boot_section(Part::Atmega328P));
        assert_eq!(uno.boot_start(Part::Atmega328P), 0x3F00);
        assert!(!uno.divides_clock());
        assert_eq!(uno.start_up(), StartUp { cycles: 16384, reset_100us: 650 });
    }

    #[test]
    fn the_factory_divides_the_clock_and_has_the_largest_boot_section() {
        for part in Part::ALL {
            let fuses = Fuses::factory(part);
            assert!(fuses.divides_clock());
            assert!(!fuses.starts_in_boot_section(part));
            assert!(!fuses.watchdog_always_on());
        }
        assert_eq!(Fuses::factory(Part::Atmega328P).boot_start(Part::Atmega328P), 0x3800);
        assert_eq!(Fuses::factory(Part::Atmega168A).boot_start(Part::Atmega168A), 0x1C00);
        assert_eq!(Fuses::factory(Part::Atmega48A).boot_start(Part::Atmega48A), 0x800);
    }
}
