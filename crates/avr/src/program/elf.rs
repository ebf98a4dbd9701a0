//! ELF32 as `avr-gcc` writes it: the flash from the loadable segments, sections for the EEPROM and the fuses.
//!
//! Addresses from 0x800000 on are data, from 0x810000 on the EEPROM, from 0x820000 on fuses. Initial values of variables
//! are loaded by their physical address, which is in the flash.
//!
//! Source: *Tool Interface Standard, Executable and Linking Format*, version 1.2; the memory map is that of `avr-ld`.

use alloc::string::{String, ToString};

use thiserror::Error;

use super::ProgramError;
use super::image::Image;

/// The first bytes of each ELF file.
pub(super) const MAGIC: [u8; 4] = *b"\x7FELF";

const CLASS_32: u8 = 1;
const LITTLE_ENDIAN: u8 = 1;
const MACHINE_AVR: u16 = 83;
const LOAD: u32 = 1;
const NOTE: u32 = 7;
/// EF_AVR_MACH.
const ARCHITECTURE: u32 = 0x7F;
/// The offset of the name in a note with one name.
const NOTED_NAME: usize = 0x31;
const NO_BITS: u32 = 8;
const SECTION_ALLOCATED: u32 = 2;
const DATA: u32 = 0x80_0000;
const EEPROM: u32 = 0x81_0000;
const FUSES: u32 = 0x82_0000;
const LOCK: u32 = 0x83_0000;

/// Bytes are no ELF file for one of these parts.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ElfError {
    /// The first four bytes are not those of an ELF file.
    #[error("the file does not begin like an ELF file")]
    Magic,
    /// The file is not of 32 bits, little-endian.
    #[error("the ELF file is not of 32 bits, little-endian")]
    Class,
    /// The file is for another processor.
    #[error("the ELF file is for machine {found}, but an AVR is machine {MACHINE_AVR}")]
    Machine {
        /// `e_machine` in the file.
        found: u16,
    },
    /// The file is for another family of AVRs.
    #[error(
        "the ELF file is for AVRs of architecture {found} (e_flags), and an ATmega48 to 328 is of 4 or 5"
    )]
    Family {
        /// The architecture in `e_flags`.
        found: u32,
    },
    /// The file is for another AVR.
    #[error("the ELF file is for an `{name}`, and not for one of ATmega48 to 328")]
    Device {
        /// The name of the device, as the compiler noted it.
        name: String,
    },
    /// The file refers to something behind its end.
    #[error("the ELF file has {found} bytes, but {needed} are needed")]
    Truncated {
        /// Bytes that there should be.
        needed: u64,
        /// Bytes that there are.
        found: usize,
    },
    /// The file is not linked: it has no loadable segments.
    #[error("the ELF file has no loadable segments; is it linked?")]
    NotLinked,
}

/// The content of a file besides its image.
#[derive(Default)]
pub(super) struct Found {
    pub(super) fuses: Option<[u8; 3]>,
    pub(super) data_end: Option<u16>,
    pub(super) device: Option<String>,
}

/// Reads the segments and sections of a file.
pub(super) fn read(file: &[u8], flash: &mut Image, eeprom: &mut Image) -> Result<Found, ProgramError> {
    let elf = Elf { file };
    elf.check()?;
    elf.segments(flash, eeprom)?;
    Ok(elf.sections()?)
}

struct Elf<'a> {
    file: &'a [u8],
}

impl<'a> Elf<'a> {
    fn check(&self) -> Result<(), ElfError> {
        if !self.file.starts_with(&MAGIC) {
            return Err(ElfError::Magic);
        }
        let head = self.bytes(0, 52)?;
        if head[4] != CLASS_32 || head[5] != LITTLE_ENDIAN {
            return Err(ElfError::Class);
        }
        let machine = self.half(18)?;
        if machine != MACHINE_AVR {
            return Err(ElfError::Machine { found: machine });
        }
        match self.word(36)? & ARCHITECTURE {
            // A linker by hand sets none.
            0 | 4 | 5 => Ok(()),
            found => Err(ElfError::Family { found }),
        }
    }

    /// The name of the part that the compiler noted: `.note.gnu.avr.deviceinfo`. Behind the note's head are six numbers, the length
    /// of a table of offsets, the table, and the names.
    fn device(&self, offset: u32, len: u32) -> Option<String> {
        let note = self.bytes(u64::from(offset), u64::from(len)).ok()?;
        if note.get(12..16)? != b"AVR\0" {
            return None;
        }
        let name = note.get(NOTED_NAME..)?.split(|&byte| byte == 0).next()?;
        let name = core::str::from_utf8(name).ok()?;
        name.starts_with("at").then(|| name.to_string())
    }

    fn segments(&self, flash: &mut Image, eeprom: &mut Image) -> Result<(), ProgramError> {
        let (table, size, count) = (self.word(28)?, self.half(42)?, self.half(44)?);
        let mut loaded = false;
        for at in entries(table, size, count) {
            let (kind, offset, physical, len) =
                (self.word(at)?, self.word(at + 4)?, self.word(at + 12)?, self.word(at + 16)?);
            if kind != LOAD || len == 0 {
                continue;
            }
            let bytes = self.bytes(u64::from(offset), u64::from(len))?;
            loaded = true;
            match physical {
                0..DATA => flash.put(physical, bytes)?,
                EEPROM..FUSES => eeprom.put(physical - EEPROM, bytes)?,
                // Variables are loaded from the flash; fuses are read with the sections.
                DATA..EEPROM | FUSES.. => {}
            }
        }
        if loaded { Ok(()) } else { Err(ElfError::NotLinked.into()) }
    }

    fn sections(&self) -> Result<Found, ElfError> {
        let (table, size, count) = (self.word(32)?, self.half(46)?, self.half(48)?);
        let mut found = Found::default();
        for at in entries(table, size, count) {
            let (kind, flags, address) = (self.word(at + 4)?, self.word(at + 8)?, self.word(at + 12)?);
            let (offset, len) = (self.word(at + 16)?, self.word(at + 20)?);
            if kind == NOTE
                && let Some(name) = self.device(offset, len)
            {
                if !is_known(&name) {
                    return Err(ElfError::Device { name });
                }
                found.device = Some(name);
            }
            if flags & SECTION_ALLOCATED == 0 || len == 0 {
                continue;
            }
            match address {
                DATA..EEPROM => {
                    let end = u64::from(address - DATA) + u64::from(len);
                    found.data_end = found.data_end.max(u16::try_from(end).ok());
                }
                FUSES..LOCK if kind != NO_BITS => {
                    let mut fuses = [0xFF; 3];
                    for (fuse, &byte) in fuses.iter_mut().zip(self.bytes(u64::from(offset), u64::from(len))?)
                    {
                        *fuse = byte;
                    }
                    found.fuses = Some(fuses);
                }
                _ => {}
            }
        }
        Ok(found)
    }

    fn bytes(&self, offset: u64, len: u64) -> Result<&'a [u8], ElfError> {
        let needed = offset.saturating_add(len);
        let range = usize::try_from(offset).ok().zip(usize::try_from(needed).ok());
        range
            .and_then(|(from, to)| self.file.get(from..to))
            .ok_or(ElfError::Truncated { needed, found: self.file.len() })
    }

    fn half(&self, offset: u64) -> Result<u16, ElfError> {
        let bytes = self.bytes(offset, 2)?;
        Ok(u16::from_le_bytes([bytes[0], bytes[1]]))
    }

    fn word(&self, offset: u64) -> Result<u32, ElfError> {
        let bytes = self.bytes(offset, 4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }
}

/// Whether a part is an ATmega48, 88, 168 or 328, whatever its suffix.
fn is_known(name: &str) -> bool {
    let Some(number) = name.strip_prefix("atmega") else { return false };
    let digits = number.trim_end_matches(|letter: char| letter.is_ascii_lowercase());
    ["48", "88", "168", "328"].contains(&digits)
}

/// The offsets of a table's entries.
fn entries(table: u32, size: u16, count: u16) -> impl Iterator<Item = u64> {
    (0..u64::from(count)).map(move |entry| u64::from(table) + entry * u64::from(size))
}
