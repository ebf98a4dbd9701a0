//! The analog comparator.
//!
//! Source: data sheet, chapter *Analog Comparator*.
//!
//! # Deviations
//!
//! It compares when the program reads or writes ACSR, and when the embedder reports a change of voltages, of which it
//! has no other sign. It has neither delay nor hysteresis.

use serde::{Deserialize, Serialize};

const DISABLED: u8 = 1 << 7;
const BANDGAP: u8 = 1 << 6;
const OUTPUT: u8 = 1 << 5;
const FLAG: u8 = 1 << 4;
const INTERRUPT: u8 = 1 << 3;
const CAPTURE: u8 = 1 << 2;

/// The comparator with its register.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Comparator {
    control: u8,
}

impl Comparator {
    pub(crate) const fn is_on(self) -> bool {
        self.control & DISABLED == 0
    }

    /// The positive input is the bandgap reference.
    pub(crate) const fn takes_bandgap(self) -> bool {
        self.control & BANDGAP != 0
    }

    /// The output goes to the input capture of timer 1.
    pub(crate) const fn captures(self) -> bool {
        self.control & CAPTURE != 0
    }

    pub(crate) const fn requests(self) -> bool {
        self.control & (FLAG | INTERRUPT) == FLAG | INTERRUPT
    }

    pub(crate) const fn flag(self) -> bool {
        self.control & FLAG != 0
    }

    pub(crate) fn acknowledge(&mut self) {
        self.control &= !FLAG;
    }

    /// Takes a new output; the answer is the edge, if it is one.
    pub(crate) fn set_output(&mut self, high: bool) -> Option<bool> {
        if !self.is_on() || (self.control & OUTPUT != 0) == high {
            return None;
        }
        self.control ^= OUTPUT;
        let edge = match self.control & 3 {
            0 => true,
            2 => !high,
            3 => high,
            _ => false,
        };
        if edge {
            self.control |= FLAG;
        }
        Some(high)
    }

    pub(crate) const fn read(self) -> u8 {
        self.control
    }

    pub(crate) fn write(&mut self, value: u8) {
        let output = if value & DISABLED == 0 { self.control & OUTPUT } else { 0 };
        self.control = value & !(OUTPUT | FLAG) | output | self.control & FLAG & !value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flag_is_set_on_the_edges_that_were_chosen() {
        for (mode, rising, falling) in [(0, true, true), (2, false, true), (3, true, false)] {
            let mut comparator = Comparator::default();
            comparator.write(mode | INTERRUPT);
            assert_eq!(comparator.set_output(true), Some(true));
            assert_eq!(comparator.requests(), rising);
            comparator.write(mode | INTERRUPT | FLAG);
            assert_eq!(comparator.set_output(true), None);
            comparator.set_output(false);
            assert_eq!(comparator.requests(), falling);
        }
    }
}
