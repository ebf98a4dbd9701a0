//! Runs as files: recordings are written, read, and replayed, and the replay is compared with the recording.
//!
//! A recording is an MCAP file. The data for a replay is in messages of `baudbot.v1` ([`topic`] lists them): the scenario,
//! states, and every input with its tick. The file may also hold what observers saw, for other tools; [`Frames`] reads that.
//! A [`Writer`] writes a recording, a [`RecordedRun`] is a recording that was read, and a [`Replay`] is a world that replays
//! one and is compared with it. The shortest recording is a single state by value: [`saved`].
//!
//! A [`journal`] keeps a world that goes on after its program was killed.

mod change;
mod digest;
mod error;
mod file;
pub mod foxglove;
mod frames;
pub mod journal;
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
pub use recorded_run::{Coverage, RecordedRun, Stretch};
pub use replay::{Difference, Replay, Watched};
pub use writer::{Writer, checksum, header};

/// Version of the format. A reader refuses a newer one.
pub const FORMAT: u32 = 1;

/// Version of the program in recordings.
pub const PROGRAM_VERSION: &str = env!("CARGO_PKG_VERSION");
