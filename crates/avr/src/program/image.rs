//! A memory that is being filled from a file.

use alloc::vec;
use alloc::vec::Vec;

use super::{Memory, ProgramError};
use crate::part::Part;

pub(super) struct Image {
    part: Part,
    memory: Memory,
    bytes: Vec<u8>,
    given: Vec<bool>,
}

impl Image {
    pub(super) fn new(part: Part, memory: Memory) -> Self {
        let properties = part.properties();
        let len = match memory {
            Memory::Flash => properties.flash_bytes as usize,
            Memory::Eeprom => usize::from(properties.eeprom_bytes),
        };
        Self { part, memory, bytes: vec![0xFF; len], given: vec![false; len] }
    }

    /// Stores bytes from this address on.
    pub(super) fn put(&mut self, address: u32, bytes: &[u8]) -> Result<(), ProgramError> {
        for (&byte, address) in bytes.iter().zip(u64::from(address)..) {
            let address = u32::try_from(address).unwrap_or(u32::MAX);
            let at = address as usize;
            if at >= self.bytes.len() {
                return Err(self.beyond(address));
            }
            if self.given[at] {
                return Err(ProgramError::Overlap { memory: self.memory, address });
            }
            self.bytes[at] = byte;
            self.given[at] = true;
        }
        Ok(())
    }

    /// All bytes up to the last one that was given.
    pub(super) fn into_bytes(mut self) -> Vec<u8> {
        let len = self.given.iter().rposition(|&given| given).map_or(0, |last| last + 1);
        self.bytes.truncate(len);
        self.bytes
    }

    fn beyond(&self, address: u32) -> ProgramError {
        ProgramError::Beyond {
            memory: self.memory,
            address,
            part: self.part.properties().name,
            bytes: u32::try_from(self.bytes.len()).unwrap_or(u32::MAX),
        }
    }
}
