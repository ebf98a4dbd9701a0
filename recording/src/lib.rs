//! Runs as files: what is recorded, read, replayed and held against the recording.
//!
//! A recording is an MCAP file. What makes the run again is in messages of `baudbot.v1` ([`topic`] lists them): the scenario,
//! states, and every input with its tick. What people look at beside that is there for other tools; [`Frames`] reads it. A [`Writer`] writes one,
//! a [`RecordedRun`] is what was read of one, a [`Replay`] is the world that does it again and is held against it. A single state
//! by value is the shortest of recordings: [`saved`].

mod change;
mod digest;
mod error;
mod file;
pub mod foxglove;
mod frames;
mod reader;
mod recorded_run;
mod replay;
pub mod saved;
mod schema;
pub mod topic;
mod writer;

pub use change::{change, intervention};
pub use digest::Digests;
pub use error::{Packing, RecordingError, WriteError};
pub use file::RecordingFile;
pub use frames::Frames;
pub use recorded_run::{RecordedRun, Stretch};
pub use replay::{Difference, Replay};
pub use writer::{Writer, checksum, header};

/// Version of the format. A reader refuses a newer one.
pub const FORMAT: u32 = 1;

/// Version of the program, as recordings have it.
pub const PROGRAM_VERSION: &str = env!("CARGO_PKG_VERSION");
