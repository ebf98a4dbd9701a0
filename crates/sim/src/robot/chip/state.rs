//! The state of a robot's chip.

use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_board::far_end::Receiver;
use baudbot_board::{Board, Wheel};
use serde::{Deserialize, Serialize};

use super::motors::Output;
use super::probe::Socket;
use super::senses::{Around, Senses};
use super::uart;
use crate::chip::{ChipSpec, Probe, Side};
use crate::drive::Wheels;
use crate::link::{Line, Link};
use crate::model::RobotSpec;
use crate::sound;
use crate::time::{SECOND_NS, SimTime};

/// A chip, what is on its pins, and what the robot knows of the two.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ChipState {
    pub(super) board: Board,
    /// The world's instant at which the board's time is 0, or would have been: it stands while the chip is held in reset.
    offset_ns: u64,
    /// Up to when it has run.
    now: SimTime,
    /// The UART at the laptop's end of the cable.
    pub(super) laptop: Receiver,
    /// The start of the tick that what follows is of.
    pub(super) tick: SimTime,
    /// The roll of the wheels for encoders: as in the tick before.
    pub(super) wheels: [Wheel; 2],
    /// The distance that they had rolled when this tick began, in metres.
    travel_m: Wheels,
    /// Whether each part that is a switch is closed.
    pub(super) contacts: Vec<bool>,
    /// The effect of the pins on the motors, for each substep of this tick that has begun.
    pub(super) outputs: Vec<Output>,
    /// The motors' present supply.
    pub(super) given: Output,
    #[serde(skip)]
    probe: Socket,
}

/// The tick in which a chip runs, and until when.
#[derive(Clone, Copy)]
pub(crate) struct Span {
    /// The tick's length, in nanoseconds.
    pub(crate) tick_ns: u64,
    /// The length of a substep, in nanoseconds.
    pub(crate) substep_ns: u64,
    /// The instant beyond which it does not go.
    pub(crate) until: SimTime,
}

impl ChipState {
    pub(crate) fn new(spec: &ChipSpec, robot: &RobotSpec) -> Self {
        Self {
            board: spec.board().clone(),
            offset_ns: robot.processor.bootloader_ns,
            now: SimTime::ZERO,
            laptop: uart::receiver(&robot.link),
            tick: SimTime::NEVER,
            wheels: [Wheel::default(); 2],
            travel_m: Wheels::default(),
            contacts: vec![false; spec.attached().len()],
            outputs: Vec::new(),
            given: Output::default(),
            probe: Socket::default(),
        }
    }

    /// Whether a chip that is as this one at its start may have come to that state by `now`.
    pub(crate) fn may_become(&self, other: &Self, link: &Link, now: SimTime) -> bool {
        // A time that is over has been run, or there would be years to make up for.
        let soon = now + SOON_NS;
        let held = other.held_until();
        other.board.is_of(self.board.wiring(), self.board.clock())
            && (now..=soon).contains(&held)
            && other.now <= soon
            && other.laptop.is_possible(&uart::settings(link), soon.as_ns())
            && self.contacts.len() == other.contacts.len()
            && other.outputs.len() <= MOST_SUBSTEPS
            && other.outputs.iter().chain([&other.given]).all(Output::is_sound)
            && sound::wheels(&other.travel_m)
            && other.wheels.iter().all(|wheel| sound::numbers([wheel.angle_rad, wheel.rate_rad_s]))
            && sound::count(other.offset_ns)
    }

    /// Puts the chip under a debugger from now on.
    pub(crate) fn put_on(&mut self, probe: Arc<dyn Probe>) {
        self.probe.put_on(probe);
    }

    /// Up to when it has run.
    pub(crate) fn now(&self) -> SimTime {
        self.now
    }

    /// The world's instant of one of the board's, in nanoseconds.
    pub(crate) fn world(&self, board_ns: u64) -> SimTime {
        SimTime::from_ns(self.offset_ns.saturating_add(board_ns))
    }

    /// An instant of the world's for the board, in nanoseconds.
    pub(super) fn local(&self, at: SimTime) -> u64 {
        at.as_ns().saturating_sub(self.offset_ns)
    }

    /// The instant until which the chip is held in reset.
    pub(super) fn held_until(&self) -> SimTime {
        self.world(self.board.now_ns())
    }

    /// The board.
    pub(crate) fn board(&self) -> &Board {
        &self.board
    }

    /// Keeps what a logic analyser on the pins would see, with the world's instants, or no longer does.
    pub(crate) fn keep_edges(&mut self, keep: bool) {
        self.board.keep_edges(keep.then_some(self.offset_ns));
    }

    /// Counts the rounds of the program's main loop, or no longer does.
    pub(crate) fn keep_rounds(&mut self, keep: bool) {
        self.board.keep_rounds(keep);
    }

    /// The chip is reset at `now`, and starts at an instant.
    pub(crate) fn reset(&mut self, now: SimTime, start: SimTime, link: &Link) {
        self.board.reset();
        self.offset_ns = start.max(now).as_ns().saturating_sub(self.board.now_ns());
        self.laptop = uart::receiver(link);
        if self.board.edges().is_some() {
            self.keep_edges(true);
        }
    }

    /// The laptop's UART has the rate of this cable from now on; a character that it was reading is lost.
    pub(crate) fn set_rate(&mut self, link: &Link) {
        self.laptop = uart::receiver(link);
    }

    /// Runs until something may come from outside or a substep ends. Gives what the laptop's UART reads to `uplink`; the answer
    /// is when characters were on the line, and how many.
    pub(crate) fn run(
        &mut self,
        spec: &ChipSpec,
        span: Span,
        around: &mut Around<'_>,
        (uplink, downlink): (&mut Line, &mut Line),
    ) -> Option<(SimTime, SimTime, u32)> {
        let link = around.link();
        if self.tick != around.tick_start() {
            self.begin_tick(spec, span, around);
        }
        let next = self.hear(link, downlink);
        let into = self.now.since(self.tick);
        let substep = into / span.substep_ns;
        let end = self.tick + (substep + 1) * span.substep_ns;
        let until = end.min(span.until).min(next);
        let mut begun = self.now;
        self.now = until;
        if until <= self.held_until() {
            self.note_output(spec, substep, until.since(begun), span.substep_ns);
            return None;
        }
        begun = begun.max(self.held_until());
        let local = self.local(until);
        let (wheels, contacts, offset_ns) = (self.wheels, &self.contacts, self.offset_ns);
        let mut senses = Senses { spec, around, wheels, contacts, offset_ns };
        self.probe.run(&mut self.board, local, &mut senses);
        self.note_output(spec, substep, until.since(begun), span.substep_ns);
        self.speak(link, uplink)
    }

    /// A tick begins: what its parts feel throughout.
    fn begin_tick(&mut self, spec: &ChipSpec, span: Span, around: &mut Around<'_>) {
        self.tick = around.tick_start();
        self.now = self.tick;
        self.outputs.clear();
        let (travel_m, radius_m) = (around.travel_m(), around.wheel_radius_m());
        let seconds = span.tick_ns as f64 / SECOND_NS as f64;
        for (wheel, side) in self.wheels.iter_mut().zip([Side::Left, Side::Right]) {
            let (before, after) = (*side.of(&mut self.travel_m), *side.of(&mut travel_m.clone()));
            *wheel =
                Wheel { angle_rad: before / radius_m, rate_rad_s: (after - before) / (radius_m * seconds) };
        }
        self.travel_m = travel_m;
        for (closed, attached) in self.contacts.iter_mut().zip(spec.attached()) {
            *closed = around.is_closed(spec, *attached, *closed).unwrap_or(*closed);
        }
    }
}

/// A chip is held in reset for less, and a tick and a character are shorter.
const SOON_NS: u64 = 120 * SECOND_NS;

/// No tick has more substeps.
const MOST_SUBSTEPS: usize = 1 << 20;
