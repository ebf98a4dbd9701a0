//! The events on a robot, its cables and its brain, and what is on the pins of its chip, as a trace that
//! <https://ui.perfetto.dev> shows.
//!
//! The lanes are those of [timing diagrams](crate::timing). `packet` is the part of the format that is needed, `track` finds places
//! for what overlaps, and `signal` writes what is on the pins of chips.

mod packet;
mod signal;
#[cfg(test)]
mod tests;
mod track;
mod writer;

pub use writer::TraceWriter;
