//! The table of parts: memories, vectors, boot sections and signatures.
//!
//! Source: data sheet *ATmega48A/PA/88A/PA/168A/PA/328/P*, sections *Configuration Summary*, *Interrupts*, *Boot Loader
//! Support* and *Signature Bytes*.

use serde::{Deserialize, Serialize};

/// A microcontroller that can be simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Part {
    /// ATmega48A: 4 KiB of flash, no boot section.
    Atmega48A,
    /// ATmega48PA.
    Atmega48Pa,
    /// ATmega88A: 8 KiB of flash.
    Atmega88A,
    /// ATmega88PA.
    Atmega88Pa,
    /// ATmega168A: 16 KiB of flash.
    Atmega168A,
    /// ATmega168PA.
    Atmega168Pa,
    /// ATmega328: 32 KiB of flash.
    Atmega328,
    /// ATmega328P.
    Atmega328P,
}

/// The differences between parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Properties {
    /// The name in the data sheet and for `avr-gcc -mmcu`, in lower case.
    pub name: &'static str,
    /// Flash, in bytes; a power of two.
    pub flash_bytes: u32,
    /// Static memory, in bytes. It begins at data address 0x100.
    pub sram_bytes: u16,
    /// EEPROM, in bytes; a power of two.
    pub eeprom_bytes: u16,
    /// A page of the flash, in words: what one page write of `SPM` stores.
    pub page_words: u16,
    /// Words from one interrupt vector to the next: 1 where `RJMP` reaches all of the flash, else 2.
    pub vector_words: u32,
    /// Words of the smallest boot section; each step of BOOTSZ doubles it. None: there is no boot section, and `SPM` may
    /// be executed everywhere.
    pub boot_words: Option<u32>,
    /// The bytes of a return address on the stack: 2, or 3 where the program counter has more than 16 bits.
    pub return_bytes: u8,
    /// The three signature bytes.
    pub signature: [u8; 3],
}

/// The data address of the first byte of static memory.
pub const SRAM_START: u16 = 0x100;

impl Part {
    /// All parts, smallest first.
    pub const ALL: [Self; 8] = [
        Self::Atmega48A,
        Self::Atmega48Pa,
        Self::Atmega88A,
        Self::Atmega88Pa,
        Self::Atmega168A,
        Self::Atmega168Pa,
        Self::Atmega328,
        Self::Atmega328P,
    ];

    /// The part of this name, such as `atmega328p`.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|part| part.properties().name.eq_ignore_ascii_case(name))
    }

    /// This part's figures in the data sheet.
    pub const fn properties(self) -> &'static Properties {
        match self {
            Self::Atmega48A => &MEGA48A,
            Self::Atmega48Pa => &MEGA48PA,
            Self::Atmega88A => &MEGA88A,
            Self::Atmega88Pa => &MEGA88PA,
            Self::Atmega168A => &MEGA168A,
            Self::Atmega168Pa => &MEGA168PA,
            Self::Atmega328 => &MEGA328,
            Self::Atmega328P => &MEGA328P,
        }
    }

    /// Words of flash.
    pub const fn flash_words(self) -> u32 {
        self.properties().flash_bytes / 2
    }

    /// The highest data address, where the stack begins after a reset.
    pub const fn ram_end(self) -> u16 {
        SRAM_START + self.properties().sram_bytes - 1
    }
}

const MEGA48A: Properties = Properties {
    name: "atmega48a",
    flash_bytes: 4 << 10,
    sram_bytes: 512,
    eeprom_bytes: 256,
    page_words: 32,
    vector_words: 1,
    boot_words: None,
    return_bytes: 2,
    signature: [0x1E, 0x92, 0x05],
};
const MEGA48PA: Properties = Properties { name: "atmega48pa", signature: [0x1E, 0x92, 0x0A], ..MEGA48A };
const MEGA88A: Properties = Properties {
    name: "atmega88a",
    flash_bytes: 8 << 10,
    sram_bytes: 1 << 10,
    eeprom_bytes: 512,
    boot_words: Some(128),
    signature: [0x1E, 0x93, 0x0A],
    ..MEGA48A
};
const MEGA88PA: Properties = Properties { name: "atmega88pa", signature: [0x1E, 0x93, 0x0F], ..MEGA88A };
const MEGA168A: Properties = Properties {
    name: "atmega168a",
    flash_bytes: 16 << 10,
    page_words: 64,
    vector_words: 2,
    signature: [0x1E, 0x94, 0x06],
    ..MEGA88A
};
const MEGA168PA: Properties = Properties { name: "atmega168pa", signature: [0x1E, 0x94, 0x0B], ..MEGA168A };
const MEGA328: Properties = Properties {
    name: "atmega328",
    flash_bytes: 32 << 10,
    sram_bytes: 2 << 10,
    eeprom_bytes: 1 << 10,
    boot_words: Some(256),
    signature: [0x1E, 0x95, 0x14],
    ..MEGA168A
};
const MEGA328P: Properties = Properties { name: "atmega328p", signature: [0x1E, 0x95, 0x0F], ..MEGA328 };

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_is_found_by_its_name() {
        for part in Part::ALL {
            assert_eq!(Part::by_name(part.properties().name), Some(part));
            assert!(part.properties().flash_bytes.is_power_of_two());
        }
        assert_eq!(Part::by_name("ATmega328P"), Some(Part::Atmega328P));
        assert_eq!(Part::by_name("atmega2560"), None);
    }

    #[test]
    fn the_stack_of_an_atmega328p_begins_at_0x8ff() {
        assert_eq!(Part::Atmega328P.ram_end(), 0x8FF);
        assert_eq!(Part::Atmega48A.ram_end(), 0x2FF);
    }
}
