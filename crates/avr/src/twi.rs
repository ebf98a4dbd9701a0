//! TWI as the only master of its bus.
//!
//! Each step begins when the program clears TWINT, takes cycles of SCL, and ends with a status and TWINT set: a start
//! condition takes one, an address or a byte with its acknowledgement nine. A cycle of SCL has 16 + 2 TWBR 4^TWPS cycles.
//!
//! Source: data sheet, chapter *2-wire Serial Interface*, sections *Bit Rate Generator Unit* and *Transmission Modes*.
//!
//! # Deviations
//!
//! As there is no other master, a program that makes the chip a slave waits for ever: its address is never called.
//! There is neither arbitration nor stretching of the clock. SDA and SCL do not move: the board is asked by whole
//! bytes. A stop condition is over at once.

use serde::{Deserialize, Serialize};

use crate::board::Direction;

/// A register of the TWI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Register {
    BitRate,
    Status,
    Address,
    Data,
    Control,
    Mask,
}

const FLAG: u8 = 1 << 7;
const ACKNOWLEDGE: u8 = 1 << 6;
const START: u8 = 1 << 5;
const STOP: u8 = 1 << 4;
const COLLISION: u8 = 1 << 3;
const ENABLE: u8 = 1 << 2;
const INTERRUPT: u8 = 1;
const BYTE_CLOCKS: u64 = 9;

/// The codes of TWSR.
mod status {
    pub(super) const NOTHING: u8 = 0xF8;
    pub(super) const START: u8 = 0x08;
    pub(super) const REPEATED_START: u8 = 0x10;
    pub(super) const WRITE_ADDRESS: [u8; 2] = [0x20, 0x18];
    pub(super) const WRITTEN: [u8; 2] = [0x30, 0x28];
    pub(super) const READ_ADDRESS: [u8; 2] = [0x48, 0x40];
    pub(super) const READ: [u8; 2] = [0x58, 0x50];
}

/// The next action of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Step {
    Start,
    /// SLA+R/W.
    Address,
    Write,
    /// A byte from the slave; with TWEA another one is wanted behind it.
    Read {
        acknowledge: bool,
    },
}

/// A write's immediate request to the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    Nothing,
    Stop,
}

/// The TWI with its registers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Twi {
    bit_rate: u8,
    prescaler: u8,
    status: u8,
    address: u8,
    mask: u8,
    data: u8,
    control: u8,
    /// The bus is held between start and stop.
    holds_bus: bool,
    step: Option<(Step, u64)>,
}

impl Twi {
    pub(crate) const fn new() -> Self {
        Self {
            bit_rate: 0,
            prescaler: 0,
            status: status::NOTHING,
            address: 0xFE,
            mask: 0,
            data: 0xFF,
            control: 0,
            holds_bus: false,
            step: None,
        }
    }

    pub(crate) const fn is_possible(&self) -> bool {
        self.prescaler <= 3
    }

    pub(crate) const fn requests(&self) -> bool {
        self.control & (FLAG | INTERRUPT) == FLAG | INTERRUPT
    }

    pub(crate) const fn is_enabled(&self) -> bool {
        self.control & ENABLE != 0
    }

    pub(crate) fn next_event(&self) -> u64 {
        self.step.map_or(u64::MAX, |(_, end)| end)
    }

    /// The step that is over at this cycle; [`done`](Self::done) must follow.
    pub(crate) fn event(&mut self, now: u64) -> Option<Step> {
        let (step, end) = self.step?;
        if end != now {
            return None;
        }
        self.step = None;
        Some(step)
    }

    /// The address and the direction in TWDR.
    pub(crate) const fn addressed(&self) -> (u8, Direction) {
        (self.data >> 1, if self.data & 1 == 0 { Direction::Write } else { Direction::Read })
    }

    pub(crate) const fn data(&self) -> u8 {
        self.data
    }

    /// Ends a step; `acknowledged` counts for addresses and written bytes, `byte` for those read.
    pub(crate) fn done(&mut self, step: Step, acknowledged: bool, byte: u8) {
        let (_, direction) = self.addressed();
        self.status = match step {
            Step::Start if self.holds_bus => status::REPEATED_START,
            Step::Start => status::START,
            Step::Address if direction == Direction::Write => {
                status::WRITE_ADDRESS[usize::from(acknowledged)]
            }
            Step::Address => status::READ_ADDRESS[usize::from(acknowledged)],
            Step::Write => status::WRITTEN[usize::from(acknowledged)],
            Step::Read { acknowledge } => {
                self.data = byte;
                status::READ[usize::from(acknowledge)]
            }
        };
        self.holds_bus = true;
        self.control |= FLAG;
    }

    pub(crate) const fn read(&self, register: Register) -> u8 {
        match register {
            Register::BitRate => self.bit_rate,
            Register::Status => self.status | self.prescaler,
            Register::Address => self.address,
            Register::Data => self.data,
            Register::Control => self.control,
            Register::Mask => self.mask,
        }
    }

    pub(crate) fn write(&mut self, register: Register, value: u8, now: u64) -> Wanted {
        match register {
            Register::BitRate => self.bit_rate = value,
            Register::Status => self.prescaler = value & 3,
            Register::Address => self.address = value,
            Register::Mask => self.mask = value,
            Register::Data if self.control & FLAG != 0 => {
                self.data = value;
                self.control &= !COLLISION;
            }
            Register::Data => self.control |= COLLISION,
            Register::Control => return self.write_control(value, now),
        }
        Wanted::Nothing
    }

    fn write_control(&mut self, value: u8, now: u64) -> Wanted {
        let flag = self.control & FLAG & !value;
        self.control = value & (ACKNOWLEDGE | START | ENABLE | INTERRUPT) | flag | self.control & COLLISION;
        if value & ENABLE == 0 {
            self.step = None;
            self.holds_bus = false;
            self.status = status::NOTHING;
            return Wanted::Nothing;
        }
        if value & FLAG == 0 && (flag != 0 || value & START == 0) || self.step.is_some() {
            return Wanted::Nothing;
        }
        let mut wanted = Wanted::Nothing;
        if value & STOP != 0 && self.holds_bus {
            self.holds_bus = false;
            self.status = status::NOTHING;
            wanted = Wanted::Stop;
        }
        if value & START != 0 {
            self.step = Some((Step::Start, now + self.clock()));
        } else if let Some(step) = self.following(value & ACKNOWLEDGE != 0).filter(|_| self.holds_bus) {
            self.step = Some((step, now + BYTE_CLOCKS * self.clock()));
        }
        wanted
    }

    /// The step behind the status once TWINT is cleared.
    const fn following(&self, acknowledge: bool) -> Option<Step> {
        Some(match self.status {
            status::START | status::REPEATED_START => Step::Address,
            0x18 | 0x20 | 0x28 | 0x30 => Step::Write,
            0x40 | 0x50 => Step::Read { acknowledge },
            _ => return None,
        })
    }

    /// Cycles in one of SCL.
    const fn clock(&self) -> u64 {
        16 + 2 * (self.bit_rate as u64) * (1 << (2 * self.prescaler))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lets the bus do its step, and gives the cycles it took and the status.
    fn step(twi: &mut Twi, now: u64, acknowledged: bool, byte: u8) -> (u64, u8) {
        let end = twi.next_event();
        let done = twi.event(end).unwrap();
        twi.done(done, acknowledged, byte);
        (end - now, twi.read(Register::Status))
    }

    #[test]
    fn a_register_is_read_with_the_statuses_of_the_data_sheet_at_100_khz() {
        let mut twi = Twi::new();
        twi.write(Register::BitRate, 72, 0);
        twi.write(Register::Control, FLAG | START | ENABLE, 0);
        assert_eq!(step(&mut twi, 0, false, 0), (160, 0x08));
        for (data, status) in [(0xD0, 0x18), (0x75, 0x28)] {
            twi.write(Register::Data, data, 0);
            twi.write(Register::Control, FLAG | ENABLE, 0);
            assert_eq!(step(&mut twi, 0, true, 0), (1440, status));
        }
        twi.write(Register::Control, FLAG | START | ENABLE, 0);
        assert_eq!(step(&mut twi, 0, false, 0), (160, 0x10));
        twi.write(Register::Data, 0xD1, 0);
        twi.write(Register::Control, FLAG | ENABLE, 0);
        assert_eq!(step(&mut twi, 0, true, 0), (1440, 0x40));
        twi.write(Register::Control, FLAG | ENABLE | ACKNOWLEDGE, 0);
        assert_eq!(step(&mut twi, 0, false, 0x71), (1440, 0x50));
        assert_eq!(twi.read(Register::Data), 0x71);
        twi.write(Register::Control, FLAG | ENABLE, 0);
        assert_eq!(step(&mut twi, 0, false, 0x72), (1440, 0x58));
        assert_eq!(twi.write(Register::Control, FLAG | ENABLE | STOP, 0), Wanted::Stop);
        assert_eq!((twi.next_event(), twi.read(Register::Status)), (u64::MAX, 0xF8));
    }

    #[test]
    fn a_slave_that_is_not_there_does_not_acknowledge() {
        let mut twi = Twi::new();
        twi.write(Register::Control, FLAG | START | ENABLE, 0);
        step(&mut twi, 0, false, 0);
        twi.write(Register::Data, 0x10, 0);
        twi.write(Register::Control, FLAG | ENABLE, 0);
        assert_eq!(step(&mut twi, 0, false, 0), (144, 0x20));
    }
}
