//! A program of the user's own on a robot's microcontroller (Figs. 1.18 and 1.19): an ATmega with the robot's sensors and motors
//! on its pins, which runs cycle by cycle.
//!
//! Such a robot has the chip in place of the model of a microcontroller: nothing
//! is due by a schedule, and no task has a cost of its own. A sensor is measured when the program asks for it, and motors do
//! what the pins say. On the cable is what the program sends.
//!
//! Within a tick the scene is frozen, as it is for all robots: a sensor that the program reads ten times in a tick sees the same
//! scene ten times, with noise of its own each time. Switches have the state of the tick's start. Encoders turn as the wheels did
//! in the tick before, so that their edges come one by one, and a tick late. Motors get in a substep what the pins did in it.
//!
//! Instants of the chip are floor(cycles · 10⁹ / f) after its start, which [`ChipClock`] computes.

mod comparator;
mod control;
mod pulses;
mod scope;
mod signals;
mod turns;
mod wheels;

use alloc::vec::Vec;

pub use baudbot_avr::Rounds;
use baudbot_avr::{Chip, Fuses, Program, Supply};
pub use baudbot_board::{
    Board, By, Edge, Edges, Kind, Level, LitBy, Net, Role, RoundsOver, Seen, Terminal, Warning,
};
use baudbot_board::{BoardError, ChipClock, PartId, Physics, Wiring};
pub use comparator::{Comparator, LowWhen, Source};
pub use control::{Control, Operation};
pub use pulses::{Condenser, Pulses, Stretch, add};
pub use scope::{News, Scope, Shown};
pub use signals::{Line, Signal, identifier};
pub use turns::Turns;
pub use wheels::WheelPins;

use crate::drive::Wheels;

/// A chip with its program, and what is on its pins.
#[derive(Clone, Debug, PartialEq)]
pub struct ChipSpec {
    /// The board before its supply is switched on.
    start: Board,
    /// The place on the robot of each part of the wiring, in the parts' order.
    attached: Vec<Attached>,
    controls: Vec<Control>,
    /// Whether the meaning of the bytes is known only to the user's own programs.
    is_opaque: bool,
}

/// The device that a part on the chip's pins belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attached {
    /// A value of a sensor, as a voltage.
    Voltage(Source),
    /// The same before a comparator.
    Comparator(Comparator),
    /// What a person operates: its place among the chip's controls.
    Control(usize),
    /// A sensor that is a switch.
    Contact {
        /// The sensor's place.
        sensor: usize,
    },
    /// The encoder of a wheel.
    Wheel(Side),
    /// A sonar, whose value is a distance.
    Sonar {
        /// The sensor's place.
        sensor: usize,
    },
    /// A value of a floor sensor, in [0, 1], as the time in which a capacitor discharges.
    Reflectance {
        /// The sensor's place.
        sensor: usize,
        /// The place of the value in its readings.
        value: usize,
    },
    /// A compass.
    Compass {
        /// The sensor's place.
        sensor: usize,
    },
    /// A wheel's motor at a channel of an H-bridge.
    Motor(Side),
    /// A wheel that is a servo for continuous rotation.
    WheelServo(Side),
    /// An actuator's place.
    Actuator(usize),
    /// The part belongs to nothing of the robot's: a light-emitting diode or a buzzer on the board.
    Board,
}

/// A wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The left one.
    Left,
    /// The right one.
    Right,
}

impl Side {
    pub(crate) fn of(self, wheels: &mut Wheels) -> &mut f64 {
        match self {
            Self::Left => &mut wheels.left,
            Self::Right => &mut wheels.right,
        }
    }
}

/// A debugger at a robot's chip: it runs the chip in place of [`Board::run_until`]. While a call of it lasts, the world stands.
pub trait Probe: Send + Sync {
    /// Runs the board until an instant, in nanoseconds. What the debugger does to the chip is part of no state.
    fn run(&self, board: &mut Board, until_ns: u64, physics: &mut dyn Physics);
}

impl ChipSpec {
    /// The bytes that it has on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        crate::heap::of(&self.start)
            + self.start.program_bytes()
            + crate::heap::elements(&self.attached)
            + crate::heap::elements(&self.controls)
            + self
                .controls
                .iter()
                .map(|control| control.name.capacity() + crate::heap::elements(&control.operations))
                .sum::<usize>()
    }

    /// A chip with this program and these parts on its pins; `attached` has an entry for each part of the wiring, in order. An
    /// opaque chip's bytes mean nothing to brains of messages.
    ///
    /// # Errors
    /// A clock that the chip cannot have.
    pub fn new(
        program: &Program,
        (fuses, clock): (Fuses, ChipClock),
        wiring: Wiring,
        attached: Vec<Attached>,
        is_opaque: bool,
    ) -> Result<Self, BoardError> {
        let supply = Supply { clock_hz: clock.hz(), ..Supply::ARDUINO };
        let mut chip = Chip::new(program, fuses, supply);
        if let Some(end) = program.data_end() {
            chip.watch_stack(end);
        }
        Ok(Self { start: Board::new(chip, clock, wiring)?, attached, controls: Vec::new(), is_opaque })
    }

    /// The chip with these controls on its board.
    #[must_use]
    pub fn with_controls(self, controls: Vec<Control>) -> Self {
        Self { controls, ..self }
    }

    /// What a person operates on its board.
    pub fn controls(&self) -> &[Control] {
        &self.controls
    }

    /// The board as it is before its supply is switched on.
    pub fn board(&self) -> &Board {
        &self.start
    }

    /// The device of each part of the wiring, in the parts' order.
    pub fn attached(&self) -> &[Attached] {
        &self.attached
    }

    /// Whether its bytes mean nothing to brains of messages.
    pub fn is_opaque(&self) -> bool {
        self.is_opaque
    }

    /// Whether the program asks for the readings of the sensor in this place. Switches and comparators are looked at by the world in
    /// each tick.
    pub fn asks_for(&self, sensor: usize) -> bool {
        let is_seen = |attached: &Attached| {
            let is_compared = matches!(attached, Attached::Comparator(Comparator { source, .. }) if source.sensor == sensor);
            is_compared || *attached == Attached::Contact { sensor }
        };
        !self.attached.iter().any(is_seen)
    }

    /// The device of a part.
    pub(crate) fn attached_to(&self, part: PartId) -> Attached {
        self.attached.get(part.index()).copied().unwrap_or(Attached::Board)
    }
}
