//! A compass on the I²C bus: Honeywell HMC5883L.
//!
//! Source: Honeywell, *3-Axis Digital Compass IC HMC5883L*, sections *Register Access*, *Data Output Registers* and the
//! tables of its registers. A measurement takes 6 ms.
//!
//! # Deviations
//!
//! The lock of the data registers while they are read, self-test and the averaging of samples are not simulated.

use baudbot_avr::Direction;
use serde::{Deserialize, Serialize};

use super::Instant;
use crate::clock::ChipClock;

/// HMC5883L.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Compass;

impl Compass {
    /// The address of the compass on the bus, 7 bits.
    pub const ADDRESS: u8 = 0x1E;
}

/// The time from the command to the value, in nanoseconds.
pub(crate) const MEASUREMENT_NS: u64 = 6_000_000;

const CONFIGURATION_A: u8 = 0;
const CONFIGURATION_B: u8 = 1;
const MODE: u8 = 2;
const DATA: u8 = 3;
const STATUS: u8 = 9;
const IDENTIFICATION: u8 = 10;
const REGISTERS: u8 = 13;
const READY: u8 = 1;
/// DO2 to DO0: measurements in 100 seconds. The last one is reserved.
const RATES: [u64; 8] = [75, 150, 300, 750, 1500, 3000, 7500, 7500];
/// GN2 to GN0: counts per gauss.
const GAINS: [f64; 8] = [1370.0, 1090.0, 820.0, 660.0, 440.0, 390.0, 330.0, 230.0];
const RATE_NS: u64 = 100_000_000_000;
/// An oscillator starts in less.
const LATE_NS: u64 = 1_000_000_000;
/// A value that does not fit into 12 bits.
const OVERFLOW: i16 = -4096;
const LARGEST: f64 = 2047.0;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Mode {
    Idle,
    Single,
    Continuous,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    /// Configuration A and B.
    configuration: [u8; 2],
    /// The last value of the mode register.
    mode_bits: u8,
    mode: Mode,
    pointer: u8,
    /// The next byte written is a register's number.
    names_register: bool,
    /// X, Z, Y.
    data: [i16; 3],
    ready: bool,
    /// A measurement that is over at this cycle.
    coming: Option<(u64, [i16; 3])>,
    /// The instant at which the first measurement of the mode ends, in nanoseconds, and how many came before the next
    /// one.
    first_ns: u64,
    measured: u64,
}

impl State {
    pub(crate) const fn new() -> Self {
        Self {
            configuration: [0x10, 0x20],
            mode_bits: 0x01,
            mode: Mode::Idle,
            pointer: 0,
            names_register: false,
            data: [0; 3],
            ready: false,
            coming: None,
            first_ns: 0,
            measured: 0,
        }
    }

    /// Up to the present instant measurements have been made, but for the time in which the chip's oscillator started.
    pub(crate) fn is_possible(&self, now: Instant<'_>) -> bool {
        let since_ns = now.ns().saturating_sub(LATE_NS);
        self.pointer < REGISTERS
            && self.first_ns <= now.ns().saturating_add(RATE_NS)
            && self.due(now.clock).is_none_or(|due| due >= now.clock.cycle(since_ns))
    }

    /// The cycle of the next measurement.
    pub(crate) fn due(&self, clock: &ChipClock) -> Option<u64> {
        self.due_ns().map(|due_ns| clock.cycle(due_ns))
    }

    fn due_ns(&self) -> Option<u64> {
        let rate = RATES[usize::from(self.configuration[0] >> 2 & 7)];
        let since = match self.mode {
            Mode::Idle => return None,
            Mode::Single => 0,
            Mode::Continuous => u128::from(self.measured) * u128::from(RATE_NS) / u128::from(rate),
        };
        Some(u64::try_from(since).map_or(u64::MAX, |since| self.first_ns.saturating_add(since)))
    }

    /// Measures what is due by a cycle.
    pub(crate) fn prepare(&mut self, until: Instant<'_>, mut gauss: impl FnMut(u64) -> [f64; 3]) {
        while let Some(due) = self.due(until.clock).filter(|&due| due <= until.cycle) {
            self.take_over(due);
            let [x, y, z] = gauss(until.clock.ns(due)).map(|component| self.counts(component));
            self.coming = Some((due, [x, z, y]));
            self.measured += 1;
            if self.mode == Mode::Single {
                self.mode = Mode::Idle;
                self.mode_bits = 0x03;
            }
        }
    }

    fn counts(&self, gauss: f64) -> i16 {
        let counts = libm::round(gauss * GAINS[usize::from(self.configuration[1] >> 5)]);
        // Not a number does not fit, either.
        if counts.abs() <= LARGEST { counts as i16 } else { OVERFLOW }
    }

    /// A measurement that is over by now is what the registers have.
    fn take_over(&mut self, now: u64) {
        if let Some((_, data)) = self.coming.take_if(|(at, _)| *at <= now) {
            self.data = data;
            self.ready = true;
        }
    }

    pub(crate) fn address(&mut self, direction: Direction) {
        self.names_register = direction == Direction::Write;
    }

    pub(crate) fn write(&mut self, byte: u8, at: Instant<'_>) {
        if core::mem::take(&mut self.names_register) {
            self.pointer = byte % REGISTERS;
            return;
        }
        match self.pointer {
            CONFIGURATION_A => {
                // The measurement that goes on ends when it would have; the new rate is for the next.
                if let Some(due_ns) = self.due_ns() {
                    (self.first_ns, self.measured) = (due_ns, 0);
                }
                self.configuration[0] = byte & 0x7F;
            }
            CONFIGURATION_B => self.configuration[1] = byte & 0xE0,
            MODE => self.set_mode(byte, at),
            _ => {}
        }
        self.pointer = (self.pointer + 1) % REGISTERS;
    }

    fn set_mode(&mut self, byte: u8, at: Instant<'_>) {
        self.mode_bits = byte & 0x83;
        self.mode = match byte & 3 {
            0 => Mode::Continuous,
            1 => Mode::Single,
            _ => Mode::Idle,
        };
        (self.first_ns, self.measured) = (at.ns().saturating_add(MEASUREMENT_NS), 0);
        (self.ready, self.coming) = (false, None);
    }

    pub(crate) fn read(&mut self, at: u64) -> u8 {
        self.take_over(at);
        let register = self.pointer;
        // The pointer returns from the last byte of the data to their first.
        self.pointer = if register == STATUS - 1 { DATA } else { (register + 1) % REGISTERS };
        match register {
            CONFIGURATION_A | CONFIGURATION_B => self.configuration[usize::from(register)],
            MODE => self.mode_bits,
            DATA..STATUS => {
                self.ready = false;
                let place = usize::from(register - DATA);
                self.data[place / 2].to_be_bytes()[place % 2]
            }
            STATUS => {
                if self.ready {
                    READY
                } else {
                    0
                }
            }
            _ => b"H43"[usize::from(register - IDENTIFICATION) % 3],
        }
    }
}
