//! The registers of an AVR as GDB numbers them.
//!
//! Source: `gdb/avr-tdep.c`, of which the numbers are from memory: r0 to r31 are 0 to 31, SREG is 32, SP is 33 (two bytes), and the
//! program counter is 34, a byte address of four bytes. GDB reads no target description for an AVR; it has these from its own.

use std::num::NonZeroUsize;

use gdbstub::arch::{Arch, RegId, Registers};

/// AVR with a program counter of at most 22 bits.
pub(crate) enum Avr {}

impl Arch for Avr {
    type Usize = u32;
    type Registers = AvrRegisters;
    type BreakpointKind = usize;
    type RegId = AvrRegister;
}

/// All registers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct AvrRegisters {
    pub(crate) general: [u8; 32],
    pub(crate) sreg: u8,
    pub(crate) sp: u16,
    /// A byte address.
    pub(crate) pc: u32,
}

impl Registers for AvrRegisters {
    type ProgramCounter = u32;

    fn pc(&self) -> u32 {
        self.pc
    }

    fn gdb_serialize(&self, mut write_byte: impl FnMut(Option<u8>)) {
        let (sp, pc) = (self.sp.to_le_bytes(), self.pc.to_le_bytes());
        let bytes = self.general.iter().chain([&self.sreg]).chain(&sp).chain(&pc);
        bytes.for_each(|&byte| write_byte(Some(byte)));
    }

    fn gdb_deserialize(&mut self, bytes: &[u8]) -> Result<(), ()> {
        let &[ref general @ .., sreg, sp_low, sp_high, pc_0, pc_1, pc_2, pc_3] = bytes else {
            return Err(());
        };
        let general = general.try_into().map_err(|_| ())?;
        let (sp, pc) = (u16::from_le_bytes([sp_low, sp_high]), u32::from_le_bytes([pc_0, pc_1, pc_2, pc_3]));
        *self = Self { general, sreg, sp, pc };
        Ok(())
    }
}

/// A register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AvrRegister {
    General(u8),
    Sreg,
    Sp,
    Pc,
}

impl RegId for AvrRegister {
    fn from_raw_id(id: usize) -> Option<(Self, Option<NonZeroUsize>)> {
        let (register, bytes) = match id {
            0..32 => (Self::General(id as u8), 1),
            32 => (Self::Sreg, 1),
            33 => (Self::Sp, 2),
            34 => (Self::Pc, 4),
            _ => return None,
        };
        Some((register, NonZeroUsize::new(bytes)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_are_39_bytes_and_come_back_as_they_were() {
        let mut general = [0; 32];
        general.iter_mut().zip(1..).for_each(|(register, value)| *register = value);
        let registers = AvrRegisters { general, sreg: 0x82, sp: 0x08FF, pc: 0x1234 };
        let mut bytes = Vec::new();
        registers.gdb_serialize(|byte| bytes.extend(byte));
        assert_eq!(bytes.len(), 39);
        assert_eq!(bytes[32..], [0x82, 0xFF, 0x08, 0x34, 0x12, 0, 0]);
        let mut read = AvrRegisters::default();
        read.gdb_deserialize(&bytes).unwrap();
        assert_eq!(read, registers);
        assert!(read.gdb_deserialize(&bytes[1..]).is_err());
    }
}
