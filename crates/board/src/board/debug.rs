//! The view of a debugger, which also changes the chip and chooses the instructions at which it stops.

use baudbot_avr::{Bare, Chip, Stop};

use super::{Board, Nothing, View};
use crate::physics::Physics;
use crate::warning::WarningKind;

/// A debugger: it chooses where a chip stops, and reads it there.
pub trait Debugger {
    /// Whether the chip is to stop before the instruction that comes next. It is asked before each one.
    fn stops(&mut self, chip: &Chip) -> bool;

    /// The chip stands before an instruction at which it was to stop, or behind a `BREAK`. When this returns, the instruction
    /// that comes next is asked about again.
    fn stopped(&mut self, board: &mut Board, why: Stop);
}

impl Board {
    /// The same as [`run_until`](Self::run_until), but slower, and stops where a debugger wants it. Nothing passes
    /// while it is stopped.
    pub fn debug_until<P: Physics>(&mut self, at_ns: u64, physics: &mut P, debugger: &mut impl Debugger) {
        self.run_slices(at_ns, physics, |board, until, physics| {
            // A slice is as long as it is without a debugger: the chip does the same, to the last bit.
            loop {
                let mut view = View { around: &mut board.around, physics: &mut *physics };
                match board.chip.run_unless(until, &mut view, |chip| debugger.stops(chip)) {
                    Stop::Reached => return,
                    Stop::Breakpoint => debugger.stopped(board, Stop::Breakpoint),
                    Stop::Break => {
                        board.warn(WarningKind::Break, 1);
                        return debugger.stopped(board, Stop::Break);
                    }
                }
            }
        });
    }

    /// The chip, to be changed where no pin changes by that: registers, memories, the next instruction.
    pub fn chip_mut(&mut self) -> &mut Chip {
        &mut self.chip
    }

    /// Reads a byte of the chip's data space, as a debugger does. Reading a register may have an effect.
    pub fn read_data(&mut self, address: u16) -> u8 {
        self.chip.read_data(address, &mut Bare)
    }

    /// Writes a byte of the chip's data space as an instruction would: the parts feel what it does to pins.
    pub fn write_data(&mut self, address: u16, value: u8) {
        let mut view = View { around: &mut self.around, physics: &mut Nothing };
        self.chip.write_data(address, value, &mut view);
    }
}
