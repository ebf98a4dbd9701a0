//! Running: instructions between events.

use super::{Chip, Pending, State};
use crate::board::Board;
use crate::clock::LATEST;
use crate::flash::Code;
use crate::vector::Vector;

/// The reason for the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The instant has been reached.
    Reached,
    /// The instruction `BREAK` was executed. A further run goes on behind it.
    Break,
    /// The next instruction is one at which the run was to stop.
    Breakpoint,
}

/// Cycles from an interrupt to the first instruction at its vector.
const RESPONSE_CYCLES: u64 = 4;
/// Cycles more if the processor slept.
const WAKE_CYCLES: u64 = 4;

impl Chip {
    /// Runs until this instant, in periods of the clock source, and stops at the first boundary of an instruction at or
    /// after it. A chip that sleeps stops exactly there, and none goes on after [`LATEST`].
    pub fn run<B: Board>(&mut self, until: u64, board: &mut B) -> Stop {
        self.run_with(until, board, |chip, code, board| {
            while chip.cycle < chip.limit {
                chip.execute(code.op(chip.pc), code, board);
            }
            false
        })
    }

    /// The same as [`run`](Self::run), but slower, and stops before an instruction at one of these word addresses, but
    /// not at the first one.
    pub fn run_to<B: Board>(&mut self, until: u64, breakpoints: &[u32], board: &mut B) -> Stop {
        let mut first = true;
        self.run_unless(until, board, |chip| !core::mem::take(&mut first) && breakpoints.contains(&chip.pc()))
    }

    /// The same as [`run`](Self::run), but slower, and asks before each instruction whether to stop there. Interrupts
    /// that are due have been taken then.
    pub fn run_unless<B: Board>(
        &mut self,
        until: u64,
        board: &mut B,
        mut stops: impl FnMut(&Self) -> bool,
    ) -> Stop {
        self.run_with(until, board, |chip, code, board| {
            while chip.cycle < chip.limit {
                if stops(chip) {
                    return true;
                }
                chip.repeat.forget();
                chip.execute(code.op(chip.pc), code, board);
            }
            false
        })
    }

    fn run_with<B: Board>(
        &mut self,
        until: u64,
        board: &mut B,
        mut instructions: impl FnMut(&mut Self, &Code, &mut B) -> bool,
    ) -> Stop {
        let until = until.min(LATEST);
        self.repeat.watch(self.watched.0.is_some());
        self.repeat.forget();
        self.repeat.restart();
        let mut code = self.flash.code();
        let stop = loop {
            self.service(board);
            match core::mem::replace(&mut self.pending, Pending::Nothing) {
                Pending::Nothing => {}
                Pending::Break => break Stop::Break,
                Pending::Reset(cause) => self.reset(cause as u8, board),
            }
            if self.now() >= until {
                break Stop::Reached;
            }
            if self.pass_time(until, board) || self.interrupt(board) {
                self.repeat.restart();
                continue;
            }
            let one_only = core::mem::take(&mut self.inhibited);
            self.limit =
                if one_only { self.cycle + 1 } else { self.next_event.min(self.clock.cycle_from(until)) };
            if instructions(self, &code, board) {
                // The one instruction has not been executed.
                self.inhibited |= one_only;
                break Stop::Breakpoint;
            }
            if !self.flash.is(&code) {
                code = self.flash.code();
            }
        };
        self.limit = 0;
        stop
    }

    /// The present instant, in periods of the clock source.
    pub fn now(&self) -> u64 {
        self.clock.period_of(self.cycle)
    }

    /// Cycles of the system clock since the chip was made. None pass in deep sleep.
    pub const fn cycles(&self) -> u64 {
        self.cycle
    }

    /// Lets time pass in which no instructions are executed; false if the processor is awake.
    fn pass_time<B: Board>(&mut self, until: u64, board: &mut B) -> bool {
        let sleep = match self.state {
            State::Awake => return false,
            State::Held(held) => {
                self.skip_to(held.min(until));
                if held <= until {
                    self.state = State::Awake;
                }
                return true;
            }
            State::Asleep(sleep) => sleep,
        };
        let since = self.now();
        if self.can_wake(sleep) {
            self.wake(sleep, board);
            return true;
        }
        if sleep.is_deep() {
            let period = self.next_period().clamp(self.now(), until);
            self.skip_to(period);
        } else {
            self.cycle = self.next_event.min(self.clock.cycle_from(until)).max(self.cycle);
        }
        self.watch_sleep(since);
        true
    }

    /// The clock stands until this period.
    pub(super) fn skip_to(&mut self, period: u64) {
        self.clock.skip_to(self.cycle, period);
        self.usart.clock_changed(self.cycle);
        self.schedule();
    }

    /// Takes the first interrupt that is requested and allowed.
    fn interrupt<B: Board>(&mut self, board: &mut B) -> bool {
        if self.inhibited || self.sreg & crate::alu::I == 0 {
            return false;
        }
        let Some(vector) = Vector::first_of(self.requests()) else { return false };
        self.push_pc(self.pc, board);
        self.sreg &= !crate::alu::I;
        self.cycle += RESPONSE_CYCLES + u64::from(self.return_bytes - 2);
        let base = if self.system.vectors_in_boot() { self.fuses.boot_start(self.part) } else { 0 };
        self.pc = base + vector.number() * self.part.properties().vector_words;
        self.acknowledge(vector);
        self.schedule();
        true
    }

    /// The processor goes on behind `SLEEP` after the interrupt that has woken it.
    fn wake<B: Board>(&mut self, sleep: crate::system::Sleep, board: &mut B) {
        self.state = State::Awake;
        self.leave_sleep(sleep, board);
        self.cycle += WAKE_CYCLES;
    }
}
