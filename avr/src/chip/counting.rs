//! Loops that read a counter.
//!
//! `delay` asks a timer for the time again and again, so that no state comes back. But what an iteration finds, apart from
//! counters and the flags of their timers, can be the same as in the one before; it then depends on nothing but what it
//! reads there, and that is known until the next event. So the coming iterations are computed together, instruction by
//! instruction. Those that go the way of the first one, and leave all as they found it that they read before they wrote it,
//! are passed over but for the last.

use alloc::vec::Vec;

use super::Chip;
use super::lanes::{Byte, LANES, Operation};
use crate::address::Place;
use crate::instruction::Op;
use crate::timer;

/// Instructions of the longest iteration.
const LONGEST: u32 = 400;
/// Bytes of the memory that an iteration may use.
const MOST_CELLS: usize = 40;
/// With fewer iterations there is nothing to win.
const LEAST: usize = 4;
/// With fewer cycles until the next event there is nothing to win.
const WORTH_CYCLES: u64 = 256;
/// What has failed so often is not tried again before the next event.
const MOST_FAILURES: u8 = 3;

/// What is looked for between two events. It is no part of the chip's state.
#[derive(Debug)]
pub(super) struct Counting {
    /// Where a counter was read.
    place: u32,
    failures: u8,
    iterations: Option<alloc::boxed::Box<Iterations>>,
}

impl Default for Counting {
    fn default() -> Self {
        Self { place: u32::MAX, failures: 0, iterations: None }
    }
}

impl Counting {
    pub(super) const fn restart(&mut self) {
        (self.place, self.failures) = (u32::MAX, 0);
    }

    pub(super) const fn give_up(&mut self) {
        self.failures = MOST_FAILURES;
    }

    /// Has the memory ready, so that a run allocates none.
    pub(super) fn allocate(&mut self) {
        self.iterations.get_or_insert_with(|| alloc::boxed::Box::new(Iterations::new()));
    }
}

/// The coming iterations, all at the same instruction.
#[derive(Debug)]
pub(super) struct Iterations {
    pub(super) count: usize,
    pub(super) pc: u32,
    pub(super) sp: u16,
    /// Cycles since the start of each.
    pub(super) elapsed: u64,
    /// The cycle with which the first one starts.
    start: u64,
    /// Cycles of each.
    period: u64,
    registers: [Byte; 32],
    pub(super) operation: Operation,
    /// Registers that were written, and those that were read before.
    written: u32,
    found: u32,
    pub(super) flags_written: u8,
    pub(super) flags_found: u8,
    cells: Vec<Cell>,
    /// The high byte of the counter that was read last.
    latched: Option<Byte>,
}

/// A byte of the data memory.
#[derive(Debug)]
struct Cell {
    address: u16,
    /// It was read before it was written.
    found: bool,
    byte: Byte,
}

impl Iterations {
    fn new() -> Self {
        Self {
            count: 0,
            pc: 0,
            sp: 0,
            elapsed: 0,
            start: 0,
            period: 0,
            registers: [const { Byte::steady(0) }; 32],
            operation: Operation::new(),
            written: 0,
            found: 0,
            flags_written: 0,
            flags_found: 0,
            cells: Vec::with_capacity(MOST_CELLS),
            latched: None,
        }
    }

    fn begin(&mut self, chip: &Chip, head: Head, count: usize, period: u64) {
        (self.count, self.period) = (count, period);
        (self.pc, self.sp, self.start, self.elapsed) = (head.pc, chip.sp, head.cycle, 0);
        (self.written, self.found, self.flags_written, self.flags_found) = (0, 0, 0, 0);
        self.cells.clear();
        self.latched = None;
        for (byte, value) in self.registers.iter_mut().zip(chip.registers) {
            byte.set(value);
        }
        self.operation.sreg.set(chip.sreg);
    }

    /// Goes through the iterations; the cycles of one, if what the first leaves is what it has found.
    fn go_round(&mut self, chip: &Chip, head: Head) -> Option<u64> {
        for _ in 0..LONGEST {
            self.step(chip)?;
            if (self.pc, self.sp) == (head.pc, chip.sp) && self.leaves_what_it_found(chip, 1) == 1 {
                self.count = self.leaves_what_it_found(chip, self.count);
                return Some(self.elapsed);
            }
        }
        None
    }

    /// How many of so many iterations find what the first one has found.
    fn leaves_what_it_found(&self, chip: &Chip, count: usize) -> usize {
        let registers = self.registers.iter().zip(chip.registers).enumerate();
        let found = registers.filter(|(at, _)| self.found & self.written & 1 << at != 0);
        let registers = found.map(|(_, (byte, value))| byte.equal(count, value, 0xFF));
        let cells = self.cells.iter().filter(|cell| cell.found);
        let cells = cells.map(|cell| cell.byte.equal(count, chip.in_sram(cell.address).unwrap_or(0), 0xFF));
        let flags = self.operation.sreg.equal(count, chip.sreg, self.flags_found);
        registers.chain(cells).min().unwrap_or(count).min(flags)
    }

    pub(super) fn register(&mut self, register: u8) -> &Byte {
        let bit = 1 << (register & 31);
        if self.written & bit == 0 {
            self.found |= bit;
        }
        &self.registers[usize::from(register & 31)]
    }

    pub(super) fn written(&mut self, register: u8) -> &mut Byte {
        self.written |= 1 << (register & 31);
        &mut self.registers[usize::from(register & 31)]
    }

    /// The value that a register has in the first iteration. Those in which it has other bits are not passed over.
    pub(super) fn only(&mut self, register: u8, mask: u8) -> u8 {
        let (count, byte) = (self.count, self.register(register));
        let value = byte.at(0);
        self.count = byte.equal(count, value, mask);
        value
    }

    /// The same for the operation's result.
    pub(super) fn only_result(&mut self, mask: u8) -> u8 {
        let value = self.operation.low.at(0);
        self.count = self.operation.low.equal(self.count, value, mask);
        value
    }

    /// The same for whether bits are set.
    pub(super) fn only_flag(&mut self, mask: u8) -> bool {
        self.flags_found |= mask & !self.flags_written;
        let value = self.operation.sreg.at(0);
        self.count = self.operation.sreg.equal(self.count, value, mask);
        value & mask != 0
    }

    /// Reads a byte of the data space into the operation's result, so many cycles after the start of the instruction.
    pub(super) fn load(&mut self, chip: &Chip, address: u16, after: u64) -> Option<()> {
        if let Some(cell) = self.cells.iter().find(|cell| cell.address == address) {
            self.operation.low.copy(&cell.byte);
        } else if let Some(value) = chip.in_sram(address) {
            self.operation.low.set(value);
            self.add_cell(address, true)?;
        } else {
            let place = Place::at(u8::try_from(address).ok().filter(|&address| address >= 0x20)?);
            if let Place::Timer(_, timer::Register::CountHigh) = place {
                self.operation.low.copy(self.latched.as_ref()?);
                return Some(());
            }
            let cycle = self.start + self.elapsed + after;
            self.operation.read(chip, place, cycle, self.period, self.count)?;
            if let Place::Timer(timer::Which::T1, timer::Register::Count) = place {
                self.latched.get_or_insert(Byte::steady(0)).copy(&self.operation.high);
            }
        }
        Some(())
    }

    /// Writes the operation's result to the memory.
    pub(super) fn store(&mut self, chip: &Chip, address: u16) -> Option<()> {
        chip.in_sram(address)?;
        if let Some(cell) = self.cells.iter_mut().find(|cell| cell.address == address) {
            cell.byte.copy(&self.operation.low);
            return Some(());
        }
        self.add_cell(address, false)
    }

    fn add_cell(&mut self, address: u16, found: bool) -> Option<()> {
        if self.cells.len() == MOST_CELLS {
            return None;
        }
        self.cells.push(Cell { address, found, byte: self.operation.low.clone() });
        Some(())
    }

    pub(super) fn push(&mut self, chip: &Chip) -> Option<()> {
        self.store(chip, self.sp)?;
        self.sp -= 1;
        // Where the stack has been already, nobody has to be told.
        (self.sp >= chip.stack.lowest).then_some(())
    }

    pub(super) fn pop(&mut self, chip: &Chip) -> Option<()> {
        self.sp = self.sp.wrapping_add(1);
        self.load(chip, self.sp, 1)
    }
}

/// Where an iteration starts: with the instruction that reads a counter.
#[derive(Clone, Copy, Debug)]
struct Head {
    pc: u32,
    cycle: u64,
}

impl Chip {
    /// Iterations that start with this read of a counter are passed over, if that can be.
    #[inline(never)]
    pub(super) fn pass_iterations(&mut self, address: u8) {
        let counting = &mut self.repeat.counting;
        if counting.failures == MOST_FAILURES
            || core::mem::replace(&mut counting.place, self.pc) != self.pc
            || self.limit.saturating_sub(self.cycle) < WORTH_CYCLES
        {
            return;
        }
        counting.allocate();
        let Some(mut iterations) = counting.iterations.take() else { return };
        if self.compute(&mut iterations, address).is_some() {
            self.pass_all_but_one(&iterations);
            self.repeat.counting.place = u32::MAX;
        } else {
            self.repeat.counting.failures += 1;
        }
        self.repeat.counting.iterations = Some(iterations);
    }

    /// The instruction that is reading this register: its second word, if it has one, is the address.
    fn head(&self, address: u8) -> Option<Head> {
        let before = |words: u32| self.pc.wrapping_sub(words) & self.pc_mask;
        match (self.flash.op(before(2)), self.flash.op(before(1))) {
            (Op::Lds { address: at, .. }, _) if at == address.into() => {
                Some(Head { pc: before(2), cycle: self.cycle - 1 })
            }
            (_, Op::In { address: at, .. }) if at == address => {
                Some(Head { pc: before(1), cycle: self.cycle })
            }
            _ => None,
        }
    }

    fn compute(&self, iterations: &mut Iterations, address: u8) -> Option<()> {
        let head = self.head(address)?;
        if self.requests() != 0 {
            return None;
        }
        // One alone tells how long it is, and mostly, if that fails, that it does.
        iterations.begin(self, head, 1, 0);
        let period = iterations.go_round(self, head)?;
        let count = ((self.limit - head.cycle) / period).min(LANES as u64) as usize;
        iterations.begin(self, head, count, period);
        iterations.go_round(self, head)?;
        (iterations.count >= LEAST).then_some(())
    }

    /// The last one is gone through, and so does to timers and flags what all do.
    fn pass_all_but_one(&mut self, iterations: &Iterations) {
        let passed = iterations.count - 1;
        for (at, byte) in iterations.registers.iter().enumerate() {
            if iterations.written >> at & 1 == 1 {
                self.registers[at] = byte.at(passed - 1);
            }
        }
        let sreg = iterations.operation.sreg.at(passed - 1);
        self.sreg = self.sreg & !iterations.flags_written | sreg & iterations.flags_written;
        for cell in &iterations.cells {
            if let Some(byte) = self.sram.get_mut(usize::from(cell.address - crate::part::SRAM_START)) {
                *byte = cell.byte.at(passed - 1);
            }
        }
        self.cycle += passed as u64 * iterations.period;
        #[cfg(test)]
        {
            self.repeat.passed += 1;
        }
    }

    pub(super) fn in_sram(&self, address: u16) -> Option<u8> {
        self.sram.get(usize::from(address.wrapping_sub(crate::part::SRAM_START))).copied()
    }
}
