//! Loops that come back to where they were.
//!
//! A program that asks again and again for a variable, a pin or a flag goes round until an event or an interrupt changes it.
//! If the registers and the memory are the same at two jumps back, if in between nothing was read that changes by itself, and
//! nothing was written that a peripheral sees, then all goes on like that until the next event, and can be passed over.
//!
//! The choice of jumps to compare: R. P. Brent, *An Improved Monte Carlo Factorization Algorithm*, BIT 20, 1980,
//! section 2. A state is marked, and each of the next 1, 2, 4, … jumps is compared with the last mark.

use alloc::vec::Vec;

use super::Chip;
use crate::address::{Core, Place};
use crate::board::Board;
use crate::ports;
use crate::{adc, spi, system, timer, twi, usart};

/// The number of jumps without the state that was marked, after which nothing is looked for until the next event.
const LONGEST_SPAN: u16 = 256;
/// Cycles of a jump that is taken.
pub(super) const JUMP: u64 = 2;
/// A repetition does not pay with fewer cycles until the next event.
const WORTH_CYCLES: u64 = 256;

/// The search for a repeated state. It is no part of the chip's state: nothing in a chip's run depends on it.
#[derive(Debug, Default)]
pub(super) struct Repeat {
    phase: Phase,
    /// The phase in which nothing is looked for.
    over: Over,
    /// Jumps since the mark, and with how many it is renewed.
    jumps: u16,
    span: u16,
    mark: Processor,
    /// The instant at which the mark was set.
    cycle: u64,
    /// The memory then.
    sram: Vec<u8>,
    /// The same for the shortest loops, whose instructions are known to wait only.
    pub(super) waiting: Waiting,
    /// The number of times that a loop was passed over.
    #[cfg(test)]
    pub(super) passed: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    /// The state is not marked yet.
    #[default]
    New,
    Looking,
    /// The search is over until the next event.
    Over,
    /// Neither, but jumps are watched.
    Watched,
}

/// The phase that a jump back ends when nothing is looked for: [`Phase::Over`] unless jumps are watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Over(Phase);

impl Default for Over {
    fn default() -> Self {
        Self(Phase::Over)
    }
}

/// The state that an instruction starts from, but for the memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Processor {
    pc: u32,
    sp: u16,
    sreg: u8,
    registers: [u8; 32],
}

/// The loop that waits and was gone through last: when, and up to which cycle nothing else would happen then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Waiting {
    pub(super) pc: u32,
    pub(super) limit: u64,
    pub(super) cycle: u64,
}

impl Waiting {
    const NOWHERE: Self = Self { pc: u32::MAX, limit: 0, cycle: 0 };
}

impl Default for Waiting {
    fn default() -> Self {
        Self::NOWHERE
    }
}

impl Repeat {
    pub(super) fn new(sram_bytes: u16) -> Self {
        Self { sram: Vec::with_capacity(sram_bytes.into()), ..Self::default() }
    }

    /// Something has happened: what was marked before does not come again.
    #[inline]
    pub(super) const fn restart(&mut self) {
        self.phase = Phase::New;
    }

    /// The program does something that another time may do something else.
    #[inline]
    pub(super) const fn give_up(&mut self) {
        self.phase = self.over.0;
    }

    /// Jumps back are watched from now on, or no longer.
    pub(super) const fn watch(&mut self, watch: bool) {
        self.over = Over(if watch { Phase::Watched } else { Phase::Over });
    }

    /// Whether what is done now may be found to repeat.
    pub(super) fn is_looking(&self) -> bool {
        self.phase == Phase::Looking
    }

    /// Whether the last jump has set a mark.
    fn has_marked(&self) -> bool {
        self.phase == Phase::Looking && self.jumps == 0
    }

    /// The next iteration of a loop that waits may be another, without an event.
    pub(super) const fn forget(&mut self) {
        self.waiting = Waiting::NOWHERE;
        self.give_up();
    }

    /// The cycles from an equal state to this one.
    fn period(&mut self, now: Processor, sram: &[u8], cycle: u64) -> Option<u64> {
        if self.phase == Phase::New {
            self.span = 1;
            self.mark(now, sram, cycle);
            return None;
        }
        if self.mark == now && self.sram == sram {
            return Some(cycle - self.cycle);
        }
        self.jumps += 1;
        if self.jumps == LONGEST_SPAN {
            self.give_up();
        } else if self.jumps == self.span {
            self.span *= 2;
            self.mark(now, sram, cycle);
        }
        None
    }

    fn mark(&mut self, now: Processor, sram: &[u8], cycle: u64) {
        self.phase = Phase::Looking;
        self.jumps = 0;
        (self.mark, self.cycle) = (now, cycle);
        self.sram.clear();
        self.sram.extend_from_slice(sram);
    }
}

/// A copy begins anew.
impl Clone for Repeat {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Chips that do the same are equal.
impl PartialEq for Repeat {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Chip {
    /// A jump back has been made by the instruction before `behind`, and ends with this cycle. The answer is how many cycles the same can
    /// go on.
    #[inline(always)]
    pub(super) fn jumped_back<B: Board>(&mut self, behind: u32, now: u64, board: &mut B) -> u64 {
        if self.repeat.phase == Phase::Over { 0 } else { self.look_at_jump(behind, now, board) }
    }

    #[inline(never)]
    fn look_at_jump<B: Board>(&mut self, behind: u32, now: u64, board: &mut B) -> u64 {
        if self.watched.0.is_none() {
            return self.look_for_repeat(now).map_or(0, |(period, times)| period * times);
        }
        self.watch_jump(behind, now, board);
        if self.repeat.phase == Phase::Watched {
            return 0;
        }
        let repeat = self.look_for_repeat(now);
        if self.repeat.has_marked() {
            self.forget_arrivals();
        }
        let Some((period, times)) = repeat else { return 0 };
        self.watch_repeats(now, period, times, board);
        period * times
    }

    /// The number of cycles that are repeated, and of repetitions.
    fn look_for_repeat(&mut self, now: u64) -> Option<(u64, u64)> {
        let left = self.limit.saturating_sub(now);
        if left < WORTH_CYCLES {
            return None;
        }
        let processor = Processor { pc: self.pc, sp: self.sp, sreg: self.sreg, registers: self.registers };
        let period = self.repeat.period(processor, &self.sram, now)?;
        self.repeat.give_up();
        #[cfg(test)]
        {
            self.repeat.passed += 1;
        }
        Some((period, left / period))
    }

    /// A jump back to the start of a loop that only waits. If the last one was an iteration ago and nothing else has happened
    /// since, the loop is gone through until something happens: all these iterations are the same.
    #[inline(always)]
    pub(super) fn wait<B: Board>(&mut self, behind: u32, cycles: u8, board: &mut B) -> u64 {
        let period = u64::from(cycles);
        let now = self.cycle + JUMP;
        let left = if self.was_here(now.wrapping_sub(period)) { self.limit.saturating_sub(now) } else { 0 };
        let passed = left - left % period;
        if self.watched.0.is_some() {
            self.watch_wait(behind, period, passed, board);
        }
        self.pass(now, passed)
    }

    /// A jump back to the start of a loop that counts two or three registers down by one, the low one first. All iterations
    /// that have room are passed over but one, and that with which the registers become 0: they leave the flags behind.
    #[inline(never)]
    pub(super) fn count_down<const COUNT: usize>(&mut self, registers: [u8; COUNT]) -> u64 {
        let period = COUNT as u64 + JUMP;
        let now = self.cycle + JUMP;
        let room =
            if self.was_here(now.wrapping_sub(period)) { self.limit.saturating_sub(now) / period } else { 0 };
        let mut bytes = [0; 4];
        for (byte, register) in bytes.iter_mut().zip(registers) {
            *byte = self.register(register);
        }
        let left = u32::from_le_bytes(bytes);
        let passed = u64::from(left).min(room).saturating_sub(1);
        for (byte, register) in (left - passed as u32).to_le_bytes().into_iter().zip(registers) {
            self.set_register(register, byte);
        }
        self.pass(now, passed * period)
    }

    /// Whether the last jump of a loop that waits was to this place at this cycle, and nothing has happened since.
    #[inline(always)]
    fn was_here(&self, cycle: u64) -> bool {
        self.repeat.waiting == Waiting { pc: self.pc, limit: self.limit, cycle }
    }

    #[inline(always)]
    fn pass(&mut self, now: u64, cycles: u64) -> u64 {
        self.repeat.waiting = Waiting { pc: self.pc, limit: self.limit, cycle: now + cycles };
        JUMP + cycles
    }

    /// A register is read. Those that change with events alone may be read by a loop that repeats.
    #[inline]
    pub(super) const fn note_read(&mut self, place: Place) {
        let steady = matches!(
            place,
            Place::Timer(_, timer::Register::ControlA | timer::Register::ControlB)
                | Place::Core(Core::Flags | Core::StackLow | Core::StackHigh)
                | Place::Port(..)
                | Place::Usart(usart::Register::ControlA)
                | Place::Adc(adc::Register::ControlA)
                | Place::Twi(twi::Register::Control)
                | Place::Spi(spi::Register::Status)
                | Place::System(system::Register::General(_))
        );
        if !steady {
            self.repeat.give_up();
        }
    }

    /// A register of a peripheral is written. What an output port or the mode of a timer is already may be written again.
    #[inline]
    pub(super) fn note_write(&mut self, place: Place, value: u8) {
        let same = match place {
            Place::Port(port, register @ ports::Register::Port) => {
                self.ports.read(port, register, self.cycle) == value
            }
            Place::Timer(which, register) => self.timers[which as usize].holds(register, value),
            Place::Reserved => true,
            Place::Core(_)
            | Place::Port(..)
            | Place::Usart(_)
            | Place::Adc(_)
            | Place::Eeprom(_)
            | Place::External(_)
            | Place::Spi(_)
            | Place::Twi(_)
            | Place::System(_)
            | Place::Comparator
            | Place::Watchdog
            | Place::SelfProgramming => false,
        };
        if !same {
            self.repeat.give_up();
        }
    }
}
