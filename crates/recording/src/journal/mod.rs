//! Journals: what a world is and what has happened to it since, entry by entry, so that it is there again after its program
//! was killed at any instant.
//!
//! # Why not a recording
//!
//! All that a brain gets must be in the file before it gets it. In lockstep that is a write for each tick. A recording
//! collects its messages in chunks, which are packed, and read only up to the last fingerprint of the whole state: with
//! a chunk and a fingerprint for each tick it would cost more than the tick. A journal has the same messages as they
//! are.
//!
//! # Format
//!
//! The line `baudbot-journal 2`, then entries: a byte for the kind, the length of the body in four bytes, a CRC-32 of the entry's
//! place in the file (eight bytes) and of these five, the body, and its CRC-32. Numbers are little-endian, bodies are Protocol
//! Buffers. The first entry is the header; a state follows before anything else happens. Each write ends with how far the world
//! has come ([`At`]), and counts only with that. In format 1 checksums know no place, and each entry counts.
//!
//! # A torn tail
//!
//! A disk that loses its power keeps of the last writes what it has got to: nothing, a part, the parts in another order, zeros or
//! old blocks in place of others. So what is behind the last sound write is an unfinished one, and the journal ends before it.
//! It is damage only if an entry behind it says that the place was on the disk for good by then ([`At::on_disk`]): that was lost
//! later. A block that stands twice is not taken for another one, as the checksums know their places.
//! [`Journal::salvage`] reads what is left of a damaged one.

mod entries;
mod read;
mod restore;
mod salvage;

use baudbot_proto::v1;
use prost::Message;

pub use entries::Entries;
pub use read::{Journal, JournalError};
pub use restore::Restored;
pub use salvage::Salvaged;

/// Version of the format. A reader knows this one and those before it.
pub const JOURNAL_FORMAT: u32 = 2;

/// The text with which a journal begins; the version and a line's end follow.
const MAGIC: &str = "baudbot-journal ";

/// Bytes before a body: the kind, the length, and their checksum.
const HEAD: usize = 9;

/// Bytes of the checksum behind a body.
const TAIL: usize = 4;

/// The kinds of entries.
mod kind {
    pub(super) const HEADER: u8 = 1;
    pub(super) const SETTINGS: u8 = 2;
    pub(super) const STATE: u8 = 3;
    pub(super) const INPUTS: u8 = 4;
    pub(super) const PORTS: u8 = 5;
    pub(super) const AT: u8 = 6;
}

/// The text of a scenario.
#[derive(Clone, PartialEq, Message)]
pub struct ScenarioText {
    /// The text that was parsed.
    #[prost(string, tag = "1")]
    pub toml: String,
    /// The changes of fields, in the form of `--set`.
    #[prost(string, repeated, tag = "2")]
    pub overrides: Vec<String>,
}

/// The first entry: what the world is.
#[derive(Clone, PartialEq, Message)]
pub struct JournalHeader {
    /// The version of the program that wrote the journal.
    #[prost(string, tag = "1")]
    pub program_version: String,
    /// The name of the world.
    #[prost(string, tag = "2")]
    pub world: String,
    /// The scenario of the present run.
    #[prost(message, optional, tag = "3")]
    pub origin: Option<ScenarioText>,
    /// The scenario with which the world was made, if a reset has changed it since.
    #[prost(message, optional, tag = "4")]
    pub made: Option<ScenarioText>,
}

/// The settings with which the world is run.
#[derive(Clone, PartialEq, Message)]
pub struct Settings {
    /// The pace.
    #[prost(message, optional, tag = "1")]
    pub pace: Option<v1::Pace>,
    /// Whether it is paused.
    #[prost(bool, tag = "2")]
    pub paused: bool,
    /// A byte for each robot: 0 if the world waits for its brain, 1 if it has none and the world does not wait for one, 2 if it
    /// has one.
    #[prost(bytes = "vec", tag = "3")]
    pub slots: Vec<u8>,
    /// The recording that is being written.
    #[prost(message, optional, tag = "4")]
    pub recording: Option<KeptRecording>,
}

/// A recording that is being written.
#[derive(Clone, PartialEq, Message)]
pub struct KeptRecording {
    /// The name that operators know, without the number of a run.
    #[prost(string, tag = "1")]
    pub name: String,
    /// The file, without the number of a run.
    #[prost(string, tag = "2")]
    pub path: String,
    /// Frames a simulated second.
    #[prost(double, tag = "3")]
    pub look_hz: f64,
}

/// The writing ends of some robots' ports.
#[derive(Clone, PartialEq, Message)]
pub struct Ports {
    /// One for each robot of which something has changed.
    #[prost(message, repeated, tag = "1")]
    pub ports: Vec<PortState>,
}

/// The writing end of a robot's port.
#[derive(Clone, PartialEq, Message)]
pub struct PortState {
    /// The robot's place.
    #[prost(uint32, tag = "1")]
    pub robot: u32,
    /// The sequence number of the next message.
    #[prost(uint32, tag = "2")]
    pub sequence: u32,
    /// Whether its brain writes bytes.
    #[prost(bool, tag = "3")]
    pub raw: bool,
    /// The last signals of the actuators besides the wheels.
    #[prost(double, repeated, tag = "4")]
    pub others: Vec<f64>,
}

/// The progress of the world: all that entered it before is in the journal.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct At {
    /// The tick.
    #[prost(uint64, tag = "1")]
    pub tick: u64,
    /// Whether it has begun.
    #[prost(bool, tag = "2")]
    pub begun: bool,
    /// The fingerprint of the whole state, now and then.
    #[prost(fixed64, optional, tag = "3")]
    pub state_hash: Option<u64>,
    /// Bytes of the journal that were on the disk for good before this was written.
    #[prost(uint64, tag = "4")]
    pub on_disk: u64,
}

/// The checksum of the first five bytes of an entry at this place; those of format 1 know no place.
fn head_sum(at: Option<u64>, head: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    if let Some(at) = at {
        sum.update(&at.to_le_bytes());
    }
    sum.update(head);
    sum.finalize()
}

#[cfg(test)]
mod tests;
