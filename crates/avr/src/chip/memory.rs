//! Data memory and the stack.

use super::Chip;
use crate::board::{Board, Warning};
use crate::flash::Code;
use crate::part::SRAM_START;

/// Illegal instructions and accesses beyond the memory that are reported between two resets.
const MOST_WARNINGS: u8 = 100;

impl Chip {
    /// Reads a byte of the data space.
    #[inline(always)]
    pub(super) fn load<B: Board>(&mut self, address: u16, board: &mut B) -> u8 {
        match self.in_sram(address) {
            Some(byte) => byte,
            None => self.load_other(address, board),
        }
    }

    #[inline(always)]
    pub(super) fn in_sram(&self, address: u16) -> Option<u8> {
        self.sram.get(usize::from(address.wrapping_sub(SRAM_START))).copied()
    }

    /// Writes a byte of the data space.
    #[inline(always)]
    pub(super) fn store<B: Board>(&mut self, address: u16, value: u8, board: &mut B) {
        match self.sram.get_mut(usize::from(address.wrapping_sub(SRAM_START))) {
            Some(byte) => *byte = value,
            None => self.store_other(address, value, board),
        }
    }

    #[inline(never)]
    fn load_other<B: Board>(&mut self, address: u16, board: &mut B) -> u8 {
        match u8::try_from(address) {
            Ok(register @ 0..32) => self.register(register),
            Ok(address) => self.read_io(address, board),
            Err(_) => {
                self.beyond_memory(address, board);
                0
            }
        }
    }

    /// Loads a register from a place that is not in the SRAM.
    #[inline(never)]
    pub(super) fn load_other_into<B: Board>(&mut self, d: u8, address: u16, code: &Code, board: &mut B) {
        let value = self.load_other(address, board);
        self.set_register(d, value);
        if let Ok(address) = u8::try_from(address) {
            self.note_pins(address, d, code, board);
        }
    }

    #[inline(never)]
    fn store_other<B: Board>(&mut self, address: u16, value: u8, board: &mut B) {
        match u8::try_from(address) {
            Ok(register @ 0..32) => self.set_register(register, value),
            Ok(address) => self.write_io(address, value, board),
            Err(_) => self.beyond_memory(address, board),
        }
    }

    #[cold]
    fn beyond_memory<B: Board>(&mut self, address: u16, board: &mut B) {
        self.repeat.give_up();
        let pc = self.pc & self.pc_mask;
        self.warn_often(Warning::BeyondMemory { pc, address }, board);
    }

    #[inline(always)]
    pub(super) fn push<B: Board>(&mut self, value: u8, board: &mut B) {
        let sp = self.sp;
        self.store(sp, value, board);
        self.sp = sp.wrapping_sub(1);
        if self.sp < self.stack.lowest {
            self.note_stack(board);
        }
    }

    #[inline(always)]
    pub(super) fn pop<B: Board>(&mut self, board: &mut B) -> u8 {
        self.sp = self.sp.wrapping_add(1);
        self.load(self.sp, board)
    }

    /// Pushes a return address, low byte first.
    #[inline(always)]
    pub(super) fn push_pc<B: Board>(&mut self, pc: u32, board: &mut B) {
        let [low, high, extended, _] = (pc & self.pc_mask).to_le_bytes();
        self.push(low, board);
        self.push(high, board);
        if self.return_bytes > 2 {
            self.push(extended, board);
        }
    }

    #[inline(always)]
    pub(super) fn pop_pc<B: Board>(&mut self, board: &mut B) -> u32 {
        let extended = if self.return_bytes > 2 { self.pop(board) } else { 0 };
        let high = self.pop(board);
        let low = self.pop(board);
        u32::from_le_bytes([low, high, extended, 0]) & self.pc_mask
    }

    #[inline(never)]
    fn note_stack<B: Board>(&mut self, board: &mut B) {
        let before = core::mem::replace(&mut self.stack.lowest, self.sp);
        // A byte at the stack pointer's place is free: the last one used is above it.
        let used = |sp: u16| sp.saturating_add(1);
        if used(self.sp) < self.stack.mark && used(before) >= self.stack.mark {
            self.warn(Warning::StackLow { sp: self.sp, mark: self.stack.mark }, board);
        }
    }

    pub(super) fn warn<B: Board>(&self, warning: Warning, board: &mut B) {
        board.warn(warning, self.now());
    }

    /// A warning that a program out of control would cause with each instruction.
    #[cold]
    pub(super) fn warn_often<B: Board>(&mut self, warning: Warning, board: &mut B) {
        if self.system.often_warned < MOST_WARNINGS {
            self.system.often_warned += 1;
            self.warn(warning, board);
        }
    }
}
