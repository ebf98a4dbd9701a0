//! The world of baudbot: an arena, the robots in it, and the cables to their brains.
//!
//! One tick is Fig. 3.1 of Wahde's "Introduction to Autonomous Robots" (2016) in two halves, with the brains
//! between them:
//!
//! 1. sensors sample the frozen scene ([`sensor`]), the microcontroller reads and sends (`microcontroller`,
//!    [`schedule`], [`firmware`]), bytes travel the cable ([`link`]) or past the microcontroller ([`sensor::port`]):
//!    [`World::begin`]
//! 2. the brain processes what has arrived: a program elsewhere, never here
//! 3. its bytes travel back and are obeyed ([`robot`]): [`World::finish`], which also does the rest
//! 4. motors push, bodies and turrets move ([`motor`], [`drive`], [`actuator`]), batteries run down ([`battery`])
//! 5. things are pushed ([`movable`]) or move by themselves ([`mover`]), contacts are found ([`collision`],
//!    [`arena`])
//! 6. what is to be counted is counted ([`coverage`], [`rules`]); the run ends, or goes on
//!
//! A [`Scenario`] is the world before the first tick, and `baudbot-scenario` makes it from a text: walls in the
//! [`arena`], zones, lights and fields in the [`surroundings`]. Chance comes from named streams ([`random`]).
//! [`raycast`] shows what sensors see.
//!
//! A user needs [`Scenario`] and [`World`]. This crate has no clock, no file, no socket and no thread: time,
//! bytes and seeds come in, bytes and instants go out. The same scenario, seed and inputs give the same bits
//! on every machine ([`World::hash`]).

#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod actuator;
pub mod arena;
pub mod battery;
#[cfg(feature = "brain")]
mod brain_turn;
pub mod cable;
pub mod chip;
mod clearance;
pub mod collision;
mod columns;
pub mod coverage;
mod curve;
#[cfg(feature = "brain")]
mod data_sheet;
mod decoder;
pub mod drive;
pub mod fault;
pub mod firmware;
mod freshness;
mod hash;
mod heap;
mod heard;
mod histogram;
mod laptop;
pub mod link;
mod memory;
mod microcontroller;
pub mod model;
pub mod motor;
pub mod movable;
pub mod mover;
mod nearness;
mod open_interface;
mod optional;
mod parallel;
mod port_use;
pub mod processor;
pub mod random;
pub mod raycast;
mod registers;
pub mod robot;
pub mod rules;
pub mod scenario;
mod scene;
pub mod schedule;
pub mod sensor;
mod sound;
#[cfg(test)]
#[path = "../tests/common/statistics.rs"]
mod statistics;
pub mod surroundings;
pub mod time;
pub mod timeline;
pub mod trail;
mod values;
mod view;
mod wheels;
mod world;

pub use baudbot_geometry::Pose;
pub use columns::{sensor_columns, sensor_columns_with_units, state_columns, state_values};
pub use freshness::Freshness;
pub use heard::{AgeSpan, Heard};
pub use histogram::Histogram;
pub use laptop::Reading;
pub use nearness::{Least, Nearness};
pub use robot::Written;
pub use scenario::Scenario;
pub use time::SimTime;
pub use values::ReadingValues;
pub use view::{Outline, RobotView, SensorView, ThingView};
pub use world::{Answer, Ending, Input, Intervention, InterventionError, SavedError, Score, Turn, World};
