//! A byte, and the status register, in all of the coming iterations of a loop at once.

use super::Chip;
use crate::address::Place;
use crate::ports;
use crate::timer::{self, Which};
use crate::{system, usart};

/// Iterations that are computed together.
pub(super) const LANES: usize = 256;

/// What a byte is in each iteration. If it is the same in all, only the first value is kept.
#[derive(Clone, Debug)]
pub(super) struct Byte {
    of: [u8; LANES],
    /// Bits that are not the same in all iterations.
    varies: u8,
}

impl Byte {
    pub(super) const fn steady(value: u8) -> Self {
        Self { of: [value; LANES], varies: 0 }
    }

    pub(super) const fn set(&mut self, value: u8) {
        (self.of[0], self.varies) = (value, 0);
    }

    pub(super) fn copy(&mut self, other: &Self) {
        self.set(other.of[0]);
        if other.varies != 0 {
            self.clone_from(other);
        }
    }

    pub(super) fn at(&self, lane: usize) -> u8 {
        self.of[if self.varies == 0 { 0 } else { lane }]
    }

    /// How many of the first iterations have what the first one has in these bits.
    pub(super) fn equal(&self, count: usize, value: u8, mask: u8) -> usize {
        let equal = |&of: &u8| (of ^ value) & mask == 0;
        if self.varies & mask == 0 {
            return if equal(&self.of[0]) { count } else { 0 };
        }
        self.of[..count].iter().take_while(|of| equal(of)).count()
    }

    fn spread(&mut self, count: usize) {
        if self.varies == 0 {
            let value = self.of[0];
            self.of[..count].fill(value);
        }
    }

    fn settle(&mut self, count: usize) {
        let first = self.of[0];
        self.varies = self.of[..count].iter().fold(0, |varies, of| varies | (of ^ first));
    }

    /// Bits become the same in all iterations.
    fn set_bits(&mut self, count: usize, mask: u8, value: u8) {
        let lanes = if self.varies & !mask == 0 { 1 } else { count };
        for of in &mut self.of[..lanes] {
            *of = *of & !mask | value & mask;
        }
        self.varies &= !mask;
    }
}

/// Bits of the status register on which the results of an instruction depend, and bits that it writes.
#[derive(Clone, Copy)]
pub(super) struct Uses {
    pub(super) reads: u8,
    pub(super) writes: u8,
}

/// Where an operation takes its operands from, and its two results.
#[derive(Debug)]
pub(super) struct Operation {
    pub(super) a: Byte,
    pub(super) b: Byte,
    pub(super) low: Byte,
    pub(super) high: Byte,
    pub(super) sreg: Byte,
}

impl Operation {
    pub(super) const fn new() -> Self {
        const ZERO: Byte = Byte::steady(0);
        Self { a: ZERO, b: ZERO, low: ZERO, high: ZERO, sreg: ZERO }
    }

    /// Applies a function of the status register and both operands in each iteration.
    pub(super) fn apply(&mut self, count: usize, uses: Uses, function: impl Fn(u8, u8, u8) -> (u16, u8)) {
        if self.a.varies | self.b.varies | (self.sreg.varies & uses.reads) == 0 {
            let (value, sreg) = function(self.sreg.of[0], self.a.of[0], self.b.of[0]);
            let [low, high] = value.to_le_bytes();
            self.low.set(low);
            self.high.set(high);
            return self.sreg.set_bits(count, uses.writes, sreg);
        }
        self.a.spread(count);
        self.b.spread(count);
        self.sreg.spread(count);
        for lane in 0..count.min(LANES) {
            let (value, sreg) = function(self.sreg.of[lane], self.a.of[lane], self.b.of[lane]);
            [self.low.of[lane], self.high.of[lane]] = value.to_le_bytes();
            self.sreg.of[lane] = sreg;
        }
        self.low.settle(count);
        self.high.settle(count);
        self.sreg.settle(count);
    }

    /// What a register of a peripheral is in each iteration, if nothing but a timer's clock changes it: `low`, and behind a
    /// counter its high byte. The first iteration reads it at this cycle.
    pub(super) fn read(
        &mut self,
        chip: &Chip,
        place: Place,
        cycle: u64,
        period: u64,
        count: usize,
    ) -> Option<()> {
        match place {
            Place::Timer(_, timer::Register::Capture | timer::Register::CaptureHigh) => return None,
            Place::Timer(which, register) => self.read_timer(chip, which, register, cycle, period, count),
            Place::Port(port, register) => self.low.set(chip.steady_port(port, register)?),
            Place::System(register @ system::Register::General(_)) => {
                self.low.set(chip.system.read(register))
            }
            Place::Usart(usart::Register::ControlA) => self.low.set(chip.usart.status()),
            _ => return None,
        }
        Some(())
    }

    fn read_timer(
        &mut self,
        chip: &Chip,
        which: Which,
        register: timer::Register,
        cycle: u64,
        period: u64,
        count: usize,
    ) {
        let mut timer = chip.timers[which as usize].clone();
        timer.advance(chip.timer_time(which, cycle));
        let mut ahead = timer.ahead();
        let mut value = timer.read(register);
        for lane in 0..count.min(LANES) {
            let now = chip.timer_time(which, cycle + period * lane as u64);
            if now >= ahead.until {
                timer.advance(now);
                (ahead, value) = (timer.ahead(), timer.read(register));
            }
            let counter = if register == timer::Register::Count { ahead.count(now) } else { value.into() };
            [self.low.of[lane], self.high.of[lane]] = counter.to_le_bytes();
        }
        self.low.settle(count);
        self.high.settle(count);
    }
}

impl Chip {
    /// Whether a pin will be told to float, when this bit is asked for.
    pub(super) fn floats(&self, address: u8, mask: u8) -> bool {
        matches!(Place::at(address), Place::Port(port, ports::Register::Pin) if self.ports.will_float(port, mask) != 0)
    }

    /// What a register of a port is until the next event, if that can be told.
    fn steady_port(&self, port: crate::pin::Port, register: ports::Register) -> Option<u8> {
        let shaped = self.outputs.shapes.iter().flatten().any(Option::is_some);
        if register != ports::Register::Pin {
            return Some(self.ports.read(port, register, self.cycle));
        }
        if shaped || self.ports.is_synchronising(port, self.cycle) {
            return None;
        }
        Some(self.ports.read(port, register, self.cycle) & !self.digital_off(port))
    }
}
