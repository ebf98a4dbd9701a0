//! A chip with parts on its pins, in motion.

mod analyser;
mod debug;
mod outputs;
mod pins;
mod saved;
mod surroundings;
mod uart;
mod watch;
mod wave;

use baudbot_avr::{Channel, Chip, InputError, LATEST, Pin, Port, PwmReport, ResetCause, Stop, Timer};
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use debug::Debugger;
pub use outputs::{Light, Motor, ServoOutput, Tone};
pub use uart::ReceiveError;

use crate::clock::ChipClock;
use crate::parts::Change;
use crate::physics::{PartId, Physics};
use crate::warning::{Warning, WarningKind};
use crate::wiring::{Terminal, Wiring};
use surroundings::{Surroundings, View};

/// A world for acts that ask nothing of it: a reset, a debugger.
struct Nothing;

impl Physics for Nothing {}

/// The longest time that the chip runs without a look at its parts, in nanoseconds.
const SLICE_NS: u64 = 1_000_000;

/// A chip with parts on its pins. A clone that goes on with the same physics does the same, bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Board {
    chip: Chip,
    around: Surroundings,
    /// The end of the last step.
    now_ns: u64,
    slice_cycles: u64,
    watchdog_resets: u32,
}

/// A chip and a clock do not go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum BoardError {
    /// The chip counts on another frequency.
    #[error("the chip is supplied with {chip} Hz, and the clock has {clock} Hz")]
    OtherFrequency {
        /// The chip's, in hertz.
        chip: u32,
        /// The clock's, in hertz.
        clock: u32,
    },
    /// The chip has run already.
    #[error("the chip has run for {cycles} cycles without its board")]
    HasRun {
        /// Periods of the clock source.
        cycles: u64,
    },
}

/// The next instant of an event on a board to which nothing comes from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Next {
    /// The chip executes instructions.
    Awake,
    /// The next event is not before this instant, in nanoseconds.
    At(u64),
    /// The next event never comes, unless something comes from outside.
    Never,
}

impl Board {
    /// The bytes of its chip's program memory, which clones share until they change it.
    #[must_use]
    pub fn program_bytes(&self) -> usize {
        self.chip.program_bytes()
    }

    /// A board whose supply is switched on at instant 0.
    ///
    /// # Errors
    ///
    /// A clock of another frequency than the chip's, a chip that has run.
    pub fn new(mut chip: Chip, clock: ChipClock, wiring: Wiring) -> Result<Self, BoardError> {
        let supply = chip.supply();
        if supply.clock_hz != clock.hz() {
            return Err(BoardError::OtherFrequency { chip: supply.clock_hz, clock: clock.hz() });
        }
        if chip.now() != 0 {
            return Err(BoardError::HasRun { cycles: chip.now() });
        }
        report_shapes(&mut chip, &wiring);
        let around = Surroundings::new(wiring, clock, supply.avcc_uv);
        let slice_cycles = slice_cycles(&around);
        Ok(Self { chip, around, now_ns: 0, slice_cycles, watchdog_resets: 0 })
    }

    /// Runs until an instant, in nanoseconds: a step, throughout which the world is that of `physics`. An instant that
    /// is over makes a step of no length.
    pub fn run_until<P: Physics>(&mut self, at_ns: u64, physics: &mut P) {
        self.run_slices(at_ns, physics, |board, until, physics| {
            let stop = board.chip.run(until, &mut View { around: &mut board.around, physics });
            if stop == Stop::Break {
                board.warn(WarningKind::Break, 1);
            }
        });
    }

    /// Lets `run` run the chip until an instant: it is given the cycle that it must not run beyond.
    fn run_slices<P: Physics>(
        &mut self,
        at_ns: u64,
        physics: &mut P,
        mut run: impl FnMut(&mut Self, u64, &mut P),
    ) {
        let end = self.around.clock.cycle(at_ns).min(LATEST);
        self.around.begin(self.now_ns, physics);
        while self.chip.now() < end {
            let until = self.chip.now().saturating_add(self.slice_cycles).min(end);
            self.around.prepare(until, physics);
            let until = self.feed(until);
            run(self, until, physics);
            self.around.look_for_shorts(self.chip.now());
            self.around.settle(self.chip.now());
            self.count_resets();
        }
        self.around.finish(self.chip.now());
        self.now_ns = self.now_ns.max(at_ns);
    }

    /// Gives the chip what the parts do up to a cycle; the answer is an earlier cycle if not all has room.
    fn feed(&mut self, until: u64) -> u64 {
        while let Some((part, change)) = self.around.next_change(until) {
            let terminal = Terminal { part, role: change.role };
            let pin = self.around.wiring.net(terminal).and_then(|net| net.pin());
            if let Some(pin) = pin
                && let Err(full) = self.set_pin(pin, change)
            {
                return full;
            }
            self.around.change_taken(part, pin, change, self.chip.now());
        }
        until
    }

    /// The instant of a change that finds no room is the error.
    fn set_pin(&mut self, pin: Pin, change: Change) -> Result<(), u64> {
        let now = self.chip.now();
        let at = change.at.max(now);
        self.chip.set_pin(pin, change.external, at).map_err(|error| match error {
            // The chip runs on in any case, and makes room.
            InputError::Full | InputError::Past { .. } => at.max(now + 1),
        })
    }

    /// The pin RESET is low for a moment at the end of the last step: the button of the board is pressed, or the serial port of
    /// an Arduino is opened.
    pub fn reset(&mut self) {
        let mut view = View { around: &mut self.around, physics: &mut Nothing };
        self.chip.reset_now(ResetCause::External, &mut view);
        self.around.settle(self.chip.now());
    }

    fn count_resets(&mut self) {
        let resets = self.chip.watchdog_resets();
        let more = resets.wrapping_sub(self.watchdog_resets);
        self.watchdog_resets = resets;
        if more > 0 {
            self.warn(WarningKind::WatchdogReset, more.into());
        }
    }

    /// The other end of the cable reads at another rate than the chip sends.
    pub fn warn_of_rate(&mut self) {
        self.warn(WarningKind::OtherRate, 1);
    }

    fn warn(&mut self, kind: WarningKind, count: u64) {
        let at_ns = self.around.clock.ns(self.chip.now());
        self.around.warnings.add(kind, None, None, at_ns, count);
    }

    /// The chip.
    pub const fn chip(&self) -> &Chip {
        &self.chip
    }

    /// The wiring.
    pub fn wiring(&self) -> &Wiring {
        &self.around.wiring
    }

    /// The clock of the chip.
    pub const fn clock(&self) -> &ChipClock {
        &self.around.clock
    }

    /// The end of the last step, in nanoseconds.
    pub const fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// All that was suspicious up to now, in the order in which it came first; 48 different warnings at most.
    pub fn warnings(&self) -> &[Warning] {
        self.around.warnings.list()
    }

    /// Up to when a step can last in which nothing happens, if the world stays as it was.
    pub fn next_event_ns(&self) -> Next {
        let Some(chip) = self.chip.next_event() else { return Next::Awake };
        match self.around.next_event().map_or(chip, |part| part.min(chip)) {
            u64::MAX => Next::Never,
            cycle => Next::At(self.around.clock.ns(cycle)),
        }
    }
}

/// Cycles that the chip may run without a look at its parts.
fn slice_cycles(around: &Surroundings) -> u64 {
    around.clock.cycle(around.reaction_ns().min(SLICE_NS)).max(1)
}

/// Edges of a timer's output are not simulated if all parts on it are content with the shape of its signal.
fn report_shapes(chip: &mut Chip, wiring: &Wiring) {
    for (timer, channel, port, bit) in [
        (Timer::T0, Channel::A, Port::D, 6),
        (Timer::T0, Channel::B, Port::D, 5),
        (Timer::T1, Channel::A, Port::B, 1),
        (Timer::T1, Channel::B, Port::B, 2),
        (Timer::T2, Channel::A, Port::B, 3),
        (Timer::T2, Channel::B, Port::D, 3),
    ] {
        if Pin::new(port, bit).is_some_and(|pin| wiring.takes_shapes(pin)) {
            chip.set_pwm_report(timer, channel, PwmReport::Shape);
        }
    }
}

impl Surroundings {
    /// The part that does something first, up to a cycle.
    fn next_change(&self, until: u64) -> Option<(PartId, Change)> {
        self.changes().filter(|(_, change)| change.at <= until).min_by_key(|(_, change)| change.at)
    }
}
