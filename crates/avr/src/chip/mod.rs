//! A chip: processor, memories and peripherals, as one value.

mod crystal;
mod debug;
mod events;
mod execute;
mod floating;
mod input;
mod interrupts;
mod main_loop;
mod memory;
mod outputs;
mod power;
mod programming;
mod registers;
mod repeat;
mod run;
mod saved;

use alloc::vec;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::adc::Adc;
use crate::board::Supply;
use crate::clock::Clock;
use crate::comparator::Comparator;
use crate::eeprom::Eeprom;
use crate::external::External;
use crate::flash::Flash;
use crate::fuses::Fuses;
use crate::part::{Part, SRAM_START};
use crate::pin::{Pwm, PwmReport};
use crate::ports::Ports;
use crate::program::Program;
use crate::spi::Spi;
use crate::spm::SelfProgramming;
use crate::system::{ResetCause, Sleep, System};
use crate::timer::{Timer, Which};
use crate::twi::Twi;
use crate::usart::Usart;
use crate::watchdog::Watchdog;

pub use input::InputError;
pub use run::Stop;

use input::Inputs;
use main_loop::Watched;
use repeat::Repeat;

/// A chip with its whole state. A clone that goes on does the same as the original, bit for bit.
///
/// Instants at the border are periods of the clock source since the chip was made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Chip {
    registers: [u8; 32],
    sreg: u8,
    pc: u32,
    sp: u16,
    /// Cycles of the system clock.
    cycle: u64,
    /// Instructions are executed until this cycle without looking at anything else. Zero between runs.
    limit: u64,
    /// The next cycle at which a peripheral does something.
    next_event: u64,
    sram: Vec<u8>,
    flash: Flash,
    pc_mask: u32,
    stack: StackWatch,
    return_bytes: u8,
    /// The next instruction is executed before any interrupt: it follows `SEI` or `RETI`.
    inhibited: bool,
    state: State,
    #[serde(skip)]
    repeat: Repeat,
    #[serde(skip)]
    watched: Watched,
    /// The request that the loop has to meet before the next instruction.
    pending: Pending,
    watchdog_resets: u32,
    clock: Clock,
    ports: Ports,
    timers: [Timer; 3],
    usart: Usart,
    adc: Adc,
    comparator: Comparator,
    external: External,
    spi: Spi,
    twi: Twi,
    eeprom: Eeprom,
    watchdog: Watchdog,
    programming: SelfProgramming,
    system: System,
    inputs: Inputs,
    outputs: Outputs,
    part: Part,
    fuses: Fuses,
    supply: Supply,
}

impl Chip {
    /// The bytes of its program memory, which clones share until they change it.
    #[must_use]
    pub fn program_bytes(&self) -> usize {
        self.flash.bytes()
    }

    /// A chip with this program, whose supply is switched on at instant 0.
    ///
    /// The program's own fuses, if it has any, are not used unless they are given here.
    pub fn new(program: &Program, fuses: Fuses, supply: Supply) -> Self {
        let mut chip = Self::without_power(program, fuses, supply);
        chip.begin(ResetCause::PowerOn as u8);
        chip
    }

    fn without_power(program: &Program, fuses: Fuses, supply: Supply) -> Self {
        let (part, properties) = (program.part(), program.part().properties());
        Self {
            registers: [0; 32],
            sreg: 0,
            pc: 0,
            sp: 0,
            cycle: 0,
            limit: 0,
            next_event: 0,
            sram: vec![0; usize::from(properties.sram_bytes)],
            flash: Flash::new(part.flash_words(), program.flash()),
            pc_mask: part.flash_words() - 1,
            stack: StackWatch { lowest: part.ram_end(), mark: program.data_end().unwrap_or(SRAM_START) },
            return_bytes: properties.return_bytes,
            inhibited: false,
            state: State::Awake,
            repeat: Repeat::new(properties.sram_bytes),
            watched: Watched::default(),
            pending: Pending::Nothing,
            watchdog_resets: 0,
            clock: Clock::new(0),
            ports: Ports::default(),
            timers: [Which::T0, Which::T1, Which::T2].map(|which| Timer::new(which, 0)),
            usart: Usart::new(0),
            adc: Adc::new(0),
            comparator: Comparator::default(),
            external: External::default(),
            spi: Spi::new(),
            twi: Twi::new(),
            eeprom: Eeprom::new(properties.eeprom_bytes, program.eeprom()),
            watchdog: Watchdog::new(1, false, false, 0),
            programming: SelfProgramming::new(properties.page_words),
            system: System::new(0, 0),
            inputs: Inputs::default(),
            outputs: Outputs::default(),
            part,
            fuses,
            supply: Supply { clock_hz: supply.clock_hz.max(1), ..supply },
        }
    }

    /// The part.
    pub const fn part(&self) -> Part {
        self.part
    }

    /// The fuses.
    pub const fn fuses(&self) -> Fuses {
        self.fuses
    }

    /// The chip's clock source and supply.
    pub const fn supply(&self) -> Supply {
        self.supply
    }

    /// Sets the kind of report for an output of a timer from now on: OCnA is channel 0, OCnB 1. All begin with
    /// [`PwmReport::Edges`].
    pub fn set_pwm_report(&mut self, timer: Which, channel: Channel, report: PwmReport) {
        let now = self.timer_time(timer, self.cycle);
        self.timers[timer as usize].advance(now);
        self.outputs.reports[timer as usize][channel as usize] = report;
        self.watch_timers();
        self.schedule();
    }

    /// A mark in the data memory that the stack should not grow below. It begins with the end of the program's
    /// variables, if the program's file has that address.
    pub fn watch_stack(&mut self, mark: u16) {
        self.stack.mark = mark;
    }

    /// The number of resets by the watchdog since the chip was made, modulo 2³².
    pub const fn watchdog_resets(&self) -> u32 {
        self.watchdog_resets
    }

    /// The lowest value that the stack pointer had when something was pushed.
    pub const fn lowest_sp(&self) -> u16 {
        self.stack.lowest
    }
}

/// The processor's state: it runs, sleeps or has halted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum State {
    Awake,
    Asleep(Sleep),
    /// The chip is held in reset until this period.
    Held(u64),
}

/// A request of an instruction or an event to the loop that executes instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Pending {
    Nothing,
    /// `BREAK` was executed.
    Break,
    Reset(ResetCause),
}

/// The greatest depth of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct StackWatch {
    lowest: u16,
    mark: u16,
}

/// The kinds of report for the outputs of each timer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Outputs {
    reports: [[PwmReport; 2]; 3],
    /// The shapes that were reported last.
    shapes: [[Option<Pwm>; 2]; 3],
}

/// An output of a timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// OCnA.
    A,
    /// OCnB.
    B,
}

#[cfg(test)]
mod tests;
