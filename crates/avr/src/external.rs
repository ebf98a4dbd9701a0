//! External interrupts INT0 and INT1, and pin-change interrupts.
//!
//! Source: data sheet, chapter *External Interrupts*.
//!
//! # Deviations
//!
//! A flag is set with the edge, not after the cycles of the synchroniser. A pulse shorter than a cycle is not lost.

use serde::{Deserialize, Serialize};

/// A register of the external interrupts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    Sense,
    Mask,
    Flags,
    ChangeControl,
    ChangeFlags,
    /// PCMSK0, 1 and 2, for the ports B, C and D.
    ChangeMask(usize),
}

/// The registers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct External {
    sense: u8,
    mask: u8,
    flags: u8,
    change_control: u8,
    change_flags: u8,
    change_masks: [u8; 3],
    /// The levels of INT1 and INT0.
    levels: u8,
}

impl External {
    /// The state after a reset, with the levels that the pins have.
    pub(crate) fn new(levels: u8) -> Self {
        Self { levels, ..Self::default() }
    }

    pub(crate) const fn levels(&self) -> u8 {
        self.levels
    }

    /// INT1 and INT0 that are requested: by their flags, or by a low level.
    pub(crate) fn requests(&self) -> u8 {
        let low = (0..2).filter(|&line| self.sense_of(line) == 0 && self.levels >> line & 1 == 0);
        (self.flags | low.fold(0, |lines, line| lines | 1 << line)) & self.mask
    }

    /// The interrupts that are requested by a low level, which also wakes from deep sleep.
    pub(crate) fn low_requests(&self) -> u8 {
        self.requests() & !self.flags
    }

    /// PCINT2, 1 and 0 that are requested.
    pub(crate) const fn change_requests(&self) -> u8 {
        self.change_flags & self.change_control
    }

    pub(crate) const fn flags(&self) -> u8 {
        self.flags
    }

    pub(crate) fn acknowledge(&mut self, line: u8) {
        self.flags &= !(1 << line);
    }

    pub(crate) fn acknowledge_change(&mut self, port: u8) {
        self.change_flags &= !(1 << port);
    }

    /// Pins of a port that are watched for changes.
    pub(crate) const fn watched(&self, port: usize) -> u8 {
        self.change_masks[port]
    }

    /// Whether the edges of a line matter.
    pub(crate) const fn watches_line(&self, line: u8) -> bool {
        self.mask >> line & 1 == 1
    }

    /// Pins of a port have changed.
    pub(crate) fn pins_changed(&mut self, port: usize, changed: u8) {
        if changed & self.change_masks[port] != 0 {
            self.change_flags |= 1 << port;
        }
    }

    /// The line INT0 or INT1 has another level. Edges are seen only while the clock runs.
    pub(crate) fn line_changed(&mut self, line: u8, level: bool, clock_runs: bool) {
        self.levels = self.levels & !(1 << line) | u8::from(level) << line;
        let edge = match self.sense_of(line) {
            0 => false,
            1 => true,
            2 => !level,
            _ => level,
        };
        if edge && clock_runs {
            self.flags |= 1 << line;
        }
    }

    pub(crate) const fn read(&self, register: Register) -> u8 {
        match register {
            Register::Sense => self.sense,
            Register::Mask => self.mask,
            Register::Flags => self.flags,
            Register::ChangeControl => self.change_control,
            Register::ChangeFlags => self.change_flags,
            Register::ChangeMask(port) => self.change_masks[port],
        }
    }

    pub(crate) fn write(&mut self, register: Register, value: u8) {
        match register {
            Register::Sense => self.sense = value & 0x0F,
            Register::Mask => self.mask = value & 3,
            Register::Flags => self.flags &= !value,
            Register::ChangeControl => self.change_control = value & 7,
            Register::ChangeFlags => self.change_flags &= !value,
            Register::ChangeMask(port) => self.change_masks[port] = value,
        }
    }

    const fn sense_of(&self, line: u8) -> u8 {
        self.sense >> (2 * line) & 3
    }
}
