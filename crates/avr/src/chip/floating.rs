//! Inputs that nothing drives, and a program that looks at them.
//!
//! A program that reads a whole port means some of its pins, and the others may float. So a pin is reported only if
//! the program looks at it alone: by `SBIS` and `SBIC`, or by an instruction behind the one that reads the port, as
//! Arduino's `digitalRead` does.

use super::Chip;
use crate::address::Place;
use crate::board::{Board, Warning};
use crate::flash::Code;
use crate::instruction::Op;
use crate::pin::{Pin, Port};
use crate::ports;

impl Chip {
    /// The program has read a register into `d`, and goes on at the program counter.
    #[inline(always)]
    pub(super) fn note_pins<B: Board>(&mut self, address: u8, d: u8, code: &Code, board: &mut B) {
        if let Place::Port(port, ports::Register::Pin) = Place::at(address) {
            let mask = self.looked_at(d, code);
            self.note_look(port, mask, board);
        }
    }

    /// The program looks at a pin of a port.
    #[inline]
    pub(super) fn note_look<B: Board>(&mut self, port: Port, mask: u8, board: &mut B) {
        let floating = self.ports.floating(port, mask);
        if floating != 0 {
            let pin = Pin::of(port, floating.trailing_zeros() as u8);
            self.warn(Warning::FloatingInput { pin }, board);
        }
    }

    /// The one bit of a register that is looked at next; 0: none, or several.
    #[inline(never)]
    #[expect(clippy::wildcard_enum_match_arm, reason = "of all instructions only a few look at a bit")]
    fn looked_at(&self, d: u8, code: &Code) -> u8 {
        let next = match code.op(self.pc) {
            Op::Com { d: own } if own == d => code.op((self.pc + 1) & self.pc_mask),
            next => next,
        };
        let mask = match next {
            Op::Andi { d: own, k: mask } | Op::Sbrc { r: own, mask } | Op::Sbrs { r: own, mask }
                if own == d =>
            {
                mask
            }
            Op::Bst { d: own, bit } if own == d => 1 << (bit & 7),
            Op::And { d: own, r: other } | Op::And { d: other, r: own } if own == d && other != d => {
                self.register(other)
            }
            _ => 0,
        };
        if mask.is_power_of_two() { mask } else { 0 }
    }
}
