//! Timing diagrams: what happened when on a robot, its cables and its brain (Fig. 3.2 of the notes).
//!
//! [`lanes`] makes lanes of a robot's events, and [`pin_lanes`] of what is on the pins of its chip. A [`Diagram`] draws lanes of bars, whatever they stand for: `rows` finds places
//! for bars that overlap, `bars` draws a row, `wave` the signal of a wire, `axis` is the axis of time, [`Class`] has the colours and `key` explains them.

mod axis;
mod bars;
mod class;
mod diagram;
mod key;
mod lanes;
mod pins;
mod rows;
#[cfg(test)]
mod tests;
mod wave;

pub use axis::ms;
pub use class::Class;
pub use diagram::{Bar, Diagram, Group, Lane, Mark};
pub use lanes::{is_in, lanes, what};
pub use pins::{
    Shot, finest_ns, has_lane, hz_in_words, percent, pin_lanes, printable, pulses_in_words, turns_in_words,
};
