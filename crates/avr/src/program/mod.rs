//! A program as files hold it: Intel HEX or ELF.

mod elf;
mod hex;
mod image;

use alloc::string::String;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use elf::ElfError;
pub use hex::HexError;

use crate::part::Part;

/// The content of a part's memories before it starts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    part: Part,
    flash: Vec<u8>,
    eeprom: Vec<u8>,
    fuses: Option<[u8; 3]>,
    data_end: Option<u16>,
    device: Option<String>,
}

/// A file is no program for the part.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ProgramError {
    /// The text is not Intel HEX.
    #[error("line {line}: {error}")]
    Hex {
        /// The line, counted from 1.
        line: usize,
        /// The fault in the record.
        error: HexError,
    },
    /// The bytes are no ELF file for an AVR.
    #[error(transparent)]
    Elf(#[from] ElfError),
    /// There is more than the memory holds.
    #[error("byte {address:#x} is beyond the {memory} of an {part}, which has {bytes} bytes")]
    Beyond {
        /// The memory that is too small.
        memory: Memory,
        /// The first address that does not exist.
        address: u32,
        /// The name of the part.
        part: &'static str,
        /// The bytes that the part has.
        bytes: u32,
    },
    /// Two records have a value for one byte.
    #[error("byte {address:#x} of the {memory} is given twice")]
    Overlap {
        /// The memory that is written twice.
        memory: Memory,
        /// The address.
        address: u32,
    },
    /// The file has no byte for the flash.
    #[error("there is nothing in it for the flash")]
    Empty,
}

/// A memory that a file can fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// The program memory.
    Flash,
    /// The EEPROM.
    Eeprom,
}

impl core::fmt::Display for Memory {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Flash => "flash",
            Self::Eeprom => "EEPROM",
        })
    }
}

impl Program {
    /// Reads a file, ELF if it begins like one, else Intel HEX.
    ///
    /// # Errors
    ///
    /// A [`ProgramError`] names the line or section that is at fault.
    pub fn parse(part: Part, file: &[u8]) -> Result<Self, ProgramError> {
        if file.starts_with(&elf::MAGIC) { Self::from_elf(part, file) } else { Self::from_hex(part, file) }
    }

    /// Reads Intel HEX, which has the flash only.
    ///
    /// # Errors
    ///
    /// A line that is no record, an address beyond the flash, a byte that is given twice, no byte at all.
    pub fn from_hex(part: Part, text: &[u8]) -> Result<Self, ProgramError> {
        let mut flash = image::Image::new(part, Memory::Flash);
        hex::read(text, &mut flash)?;
        Self::finish(part, flash, image::Image::new(part, Memory::Eeprom), elf::Found::default())
    }

    /// Reads an ELF file: the flash, and the sections `.eeprom` and `.fuse` if they are there.
    ///
    /// # Errors
    ///
    /// A file that is cut off or is for another machine, an address beyond a memory, no byte for the flash.
    pub fn from_elf(part: Part, file: &[u8]) -> Result<Self, ProgramError> {
        let mut flash = image::Image::new(part, Memory::Flash);
        let mut eeprom = image::Image::new(part, Memory::Eeprom);
        let found = elf::read(file, &mut flash, &mut eeprom)?;
        Self::finish(part, flash, eeprom, found)
    }

    /// A program from the words of its instructions, from address 0 on.
    ///
    /// # Errors
    ///
    /// No words, or more than the flash has.
    pub fn from_words(part: Part, words: &[u16]) -> Result<Self, ProgramError> {
        let mut flash = image::Image::new(part, Memory::Flash);
        for (at, word) in words.iter().enumerate() {
            flash.put(u32::try_from(2 * at).unwrap_or(u32::MAX), &word.to_le_bytes())?;
        }
        Self::finish(part, flash, image::Image::new(part, Memory::Eeprom), elf::Found::default())
    }

    /// This program, and the flash of `other` where this one has nothing: an application and its boot loader.
    ///
    /// # Errors
    ///
    /// A byte that both have. Bytes 0xFF count as nothing.
    pub fn and(mut self, other: &Self) -> Result<Self, ProgramError> {
        let len = self.flash.len().max(other.flash.len());
        self.flash.resize(len, 0xFF);
        for (address, (byte, &more)) in self.flash.iter_mut().zip(&other.flash).enumerate() {
            if *byte != 0xFF && more != 0xFF {
                let address = u32::try_from(address).unwrap_or(u32::MAX);
                return Err(ProgramError::Overlap { memory: Memory::Flash, address });
            }
            *byte &= more;
        }
        Ok(self)
    }

    /// This program with what ELF has besides the flash: an EEPROM as Intel HEX, the fuse bytes low, high and extended, and the
    /// address behind the last variable.
    ///
    /// # Errors
    ///
    /// As [`from_hex`](Self::from_hex), of the EEPROM.
    pub fn with_extras(
        mut self,
        eeprom_hex: Option<&[u8]>,
        fuses: Option<[u8; 3]>,
        data_end: Option<u16>,
    ) -> Result<Self, ProgramError> {
        if let Some(text) = eeprom_hex {
            let mut eeprom = image::Image::new(self.part, Memory::Eeprom);
            hex::read(text, &mut eeprom)?;
            self.eeprom = eeprom.into_bytes();
        }
        Ok(Self { fuses, data_end, ..self })
    }

    /// The flash as Intel HEX.
    pub fn flash_hex(&self) -> String {
        hex::write(&self.flash)
    }

    /// The EEPROM as Intel HEX, if there is anything in it.
    pub fn eeprom_hex(&self) -> Option<String> {
        (!self.eeprom.is_empty()).then(|| hex::write(&self.eeprom))
    }

    /// The part that it is for.
    pub const fn part(&self) -> Part {
        self.part
    }

    /// The flash, from address 0 up to the last byte that is given. What is not given is 0xFF.
    pub fn flash(&self) -> &[u8] {
        &self.flash
    }

    /// The EEPROM, from address 0 up to the last byte that is given; empty if the file has none.
    pub fn eeprom(&self) -> &[u8] {
        &self.eeprom
    }

    /// The fuse bytes low, high and extended, if the file has them.
    pub const fn fuses(&self) -> Option<[u8; 3]> {
        self.fuses
    }

    /// The part that the compiler built it for, such as `atmega328p`, if the file states it.
    pub fn device(&self) -> Option<&str> {
        self.device.as_deref()
    }

    /// The data address behind the last variable (`.bss` and `.noinit`), if the file states it. A stack that reaches
    /// it overwrites variables.
    pub const fn data_end(&self) -> Option<u16> {
        self.data_end
    }

    fn finish(
        part: Part,
        flash: image::Image,
        eeprom: image::Image,
        elf::Found { fuses, data_end, device }: elf::Found,
    ) -> Result<Self, ProgramError> {
        let flash = flash.into_bytes();
        if flash.is_empty() {
            return Err(ProgramError::Empty);
        }
        Ok(Self { part, flash, eeprom: eeprom.into_bytes(), fuses, data_end, device })
    }
}

#[cfg(test)]
mod tests;
