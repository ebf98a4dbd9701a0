//! The events on a robot, its cables and its brain (Fig. 3.2), for display.
//!
//! The events are those of [`baudbot_sim::timeline`].
//!
//! 1. [`Lane`] is a line of a timing diagram: which events are on it, and what it is called.
//! 2. [`words`] says what an event is.
//! 3. [`TraceWriter`] writes events as a trace that <https://ui.perfetto.dev> shows; `packet` is the part of its
//!    format that is needed, `track` finds places for what overlaps, and `signal` writes what is on the pins of chips.

mod lane;
mod packet;
mod signal;
#[cfg(test)]
mod tests;
mod track;
pub mod words;
mod writer;

pub use lane::Lane;
pub use writer::TraceWriter;
