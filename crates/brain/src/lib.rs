//! The inputs and outputs of a brain, without any network. A brain is a function from what has arrived to what is sent: it
//! implements [`Brain`], has no clock and does no input or output, and can be tested with turns that are made up.
//!
//! 1. [`Body`] is the robot's data sheet: which sensors, where, how often, in which units.
//! 2. A [`Turn`] is one step of the brain: each sensor's last [`Reading`], and whether it is new.
//! 3. The answer is an [`Action`]: [`Signals`] for the motors, a request for readings, how long the brain thought, and
//!    [`Until`] when it waits.
//! 4. A [`Belief`] is what the brain shows to people.
//! 5. A raw brain reads and writes the bytes of the cable. With [`RawReadings`] and [`RawCommands`] it sees and does
//!    what a brain of messages does; [`WireLayout`] is what both ends of the cable have agreed on.
//!
//! `baudbot-client` brings a brain to its robot and re-exports all of this. This crate is `no_std`, so that brains also run
//! in browsers and on microcontrollers.
//!
//! ```
//! use baudbot_brain::{Action, Brain, Turn};
//!
//! /// Drives on, and turns on the spot while something is near in front.
//! struct Timid;
//!
//! impl Brain for Timid {
//!     fn step(&mut self, turn: &Turn) -> Action {
//!         let action = match turn.value("ir_front") {
//!             None => turn.body.request(),
//!             Some(nearness) if nearness > 0.25 => Action::drive(0.5, -0.5),
//!             Some(_) => Action::drive(0.4, 0.4),
//!         };
//!         // One command for each message, and another if none comes for 0.1 s: the cable may have lost the last.
//!         action.until_message_or(turn.at_ns + 100_000_000)
//!     }
//! }
//! ```

#![no_std]

extern crate alloc;

mod action;
mod belief;
mod body;
mod brain;
mod each_run;
mod layout;
mod raw;
mod turn;

pub use baudbot_wire::create::Version as CreateVersion;
pub use baudbot_wire::{Encoding, LayoutError, Protocol, WireLayout};

pub use action::{Action, Signals, Until};
pub use belief::{
    Belief, BelievedPose, GridMap, Motivation, Particle, Point, StateVariable, Tendency, Utility,
};
pub use body::{
    Actuator, ActuatorKind, Body, Component, Firmware, MotorKind, Mount, Port, PortFormat, Sensor,
    SensorKind, Sweep,
};
pub use brain::Brain;
pub use each_run::EachRun;
pub use raw::{RawCommands, RawReadings, RawTurn};
pub use turn::{Reading, Turn};
