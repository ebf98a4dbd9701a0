//! Timing diagrams: what happened when on a robot, its cables and its brain (Fig. 3.2 of the notes).
//!
//! [`LaneId`] says on which lines an event is, [`words`] what it is, and [`Class`] what it looks like: the table of all classes, which
//! pictures, traces and tables share. [`lanes`] makes lanes of a robot's events, and [`pin_lanes`] of what is on the pins of its chip. A
//! [`Diagram`] draws lanes of bars, whatever they stand for: `rows` finds places for bars that overlap, `bars` draws a row, `wave` the signal
//! of a wire, `axis` is the axis of time, and `key` explains the colours.

mod axis;
mod bars;
mod class;
mod diagram;
mod key;
mod lane_id;
mod lanes;
mod pins;
mod rows;
#[cfg(test)]
mod tests;
mod wave;
pub mod words;

pub use axis::ms;
pub use class::{Class, Style};
pub use diagram::{Bar, Diagram, Group, Lane, Mark};
pub use lane_id::LaneId;
pub(crate) use lane_id::signal;
pub use lanes::{is_in, lanes, what};
pub use pins::{
    Shot, finest_ns, has_lane, hz_in_words, percent, pin_lanes, printable, pulses_in_words, turns_in_words,
};
