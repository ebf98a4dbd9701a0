//! The view of a debugger: it reads and changes the chip between two instructions.

use super::Chip;
use crate::board::Board;
use crate::pin::{Drive, Pin};

impl Chip {
    /// The word address of the next instruction.
    pub const fn pc(&self) -> u32 {
        self.pc & self.pc_mask
    }

    /// Goes on at this word address, taken modulo the size of the flash.
    pub fn set_pc(&mut self, pc: u32) {
        self.pc = pc & self.pc_mask;
    }

    /// The general registers.
    pub const fn general_registers(&self) -> &[u8; 32] {
        &self.registers
    }

    /// The general registers, to be changed.
    pub fn general_registers_mut(&mut self) -> &mut [u8; 32] {
        &mut self.registers
    }

    /// The status register SREG.
    pub const fn status_register(&self) -> u8 {
        self.sreg
    }

    /// Sets the status register SREG.
    pub fn set_status_register(&mut self, sreg: u8) {
        self.sreg = sreg;
    }

    /// The stack pointer.
    pub const fn stack_pointer(&self) -> u16 {
        self.sp
    }

    /// Sets the stack pointer.
    pub fn set_stack_pointer(&mut self, sp: u16) {
        self.sp = sp;
    }

    /// The static memory, from data address [`SRAM_START`](crate::part::SRAM_START) on.
    pub fn sram(&self) -> &[u8] {
        &self.sram
    }

    /// The static memory, to be changed.
    pub fn sram_mut(&mut self) -> &mut [u8] {
        &mut self.sram
    }

    /// Reads a byte of the data space as an instruction would, with all that this does to a peripheral.
    pub fn read_data<B: Board>(&mut self, address: u16, board: &mut B) -> u8 {
        self.load(address, board)
    }

    /// Writes a byte of the data space as an instruction would.
    pub fn write_data<B: Board>(&mut self, address: u16, value: u8, board: &mut B) {
        self.store(address, value, board);
        self.schedule();
    }

    /// The words of the flash.
    pub fn flash(&self) -> &[u16] {
        self.flash.words()
    }

    /// Writes words of the flash from a word address on, as a programmer does.
    pub fn write_flash(&mut self, address: u32, words: &[u16]) {
        self.flash.write(address, |at, _| words[at], words.len());
    }

    /// The EEPROM.
    pub fn eeprom(&self) -> &[u8] {
        self.eeprom.bytes()
    }

    /// The EEPROM, to be changed.
    pub fn eeprom_mut(&mut self) -> &mut [u8] {
        self.eeprom.bytes_mut()
    }

    /// The pin's effect on its wire.
    pub fn drive(&self, pin: Pin) -> Drive {
        self.ports.drive(pin)
    }

    /// The level at a pin. One that floats is low.
    pub fn level(&self, pin: Pin) -> bool {
        self.ports.level(pin)
    }
}
