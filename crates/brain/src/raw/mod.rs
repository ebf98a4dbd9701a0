//! A brain that reads and writes the bytes of the cable itself, and the codec with which it sees the turns and does what
//! a brain of messages does.

mod commands;
mod listener;
mod readings;

use alloc::vec::Vec;

pub use commands::RawCommands;
pub use readings::RawReadings;

/// A raw brain's step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawTurn {
    /// Number of the tick.
    pub tick: u64,
    /// The instant of the step, by the laptop's clock, in nanoseconds of simulated time since the start.
    pub at_ns: u64,
    /// The bytes that arrived since the last step.
    pub bytes: Vec<u8>,
    /// The bytes that arrived since the last step on the cables of sensors' own, with the sensor's place in
    /// [`Body::sensors`](crate::Body::sensors); ports on which nothing came are left out.
    pub ports: Vec<(usize, Vec<u8>)>,
}

impl RawTurn {
    /// The bytes that arrived on the cable of the sensor in this place.
    pub fn port(&self, sensor: usize) -> &[u8] {
        self.ports.iter().find(|(place, _)| *place == sensor).map_or(&[], |(_, bytes)| bytes)
    }
}
