//! The electrical side of a robot's board: a microcontroller and the parts on its pins.
//!
//! A [`Wiring`] says which terminal of which part is on which pin. A [`Board`] joins it with a chip and runs; what its
//! sensors feel comes from a [`Physics`], and what its motors, servos, lamps and buzzers do can be read after each step.
//!
//! Instants are integer nanoseconds since the board was made. Within a call of [`Board::run_until`] each edge is at its own
//! cycle; an edge of a part that falls into the instruction with which a step ends is seen behind it.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod board;
mod clock;
mod edges;
pub mod far_end;
mod parts;
mod physics;
mod role;
mod sent;
mod warning;
mod wiring;

pub use board::{Board, BoardError, Debugger, Light, Motor, Next, ReceiveError, ServoOutput, Tone};
pub use clock::{ChipClock, ClockError};
pub use edges::{By, Edge, Edges, Level, RoundsOver, Seen};
pub use parts::{
    BridgeKind, Channels, Compass, Decay, Encoder, HcSr04, Kind, Led, LitBy, MotorDrive, Piezo, Ping, Pull,
    Pulse, RangeFinder, Reflectance, ServoKind, ShieldMotor, Switch, Voltage,
};
pub use physics::{PartId, Physics, Wheel};
pub use role::Role;
pub use sent::Sent;
pub use warning::{Warning, WarningKind};
pub use wiring::{Builder, Net, Placed, Terminal, Wiring, WiringError};
