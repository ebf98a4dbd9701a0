//! Errors: why a file cannot be replayed, or could not be written.

use std::io;

use baudbot_scenario::ScenarioError;
use baudbot_sim::SavedError;
use thiserror::Error;

/// A reason why a recording cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The file is something else.
    #[error("is not an MCAP file: {0}")]
    NotMcap(String),
    /// The file is an MCAP file of another program.
    #[error(
        "is an MCAP file, but not a recording of baudbot: its first message is not a header on {}",
        crate::topic::HEADER
    )]
    Foreign,
    /// The beginning is damaged.
    #[error("cannot be replayed: {0}, and the header with the scenario is missing")]
    Headless(String),
    /// The file is packed in a way that is not read here.
    #[error("is packed with {0}")]
    Packed(Packing),
    /// The file is of a later version.
    #[error(
        "is of format {found}, which a newer version of baudbot wrote ({program}); this one reads format {}",
        crate::FORMAT
    )]
    Newer {
        /// The version of its format.
        found: u32,
        /// The version of the program that wrote it.
        program: String,
    },
    /// A message differs from the type of its topic.
    #[error("has a message on {topic} that cannot be read: {source}")]
    Message {
        /// The topic.
        topic: String,
        /// The decoder's error.
        source: prost::DecodeError,
    },
    /// The file unpacks to more bytes than the limit.
    #[error("has more than {limit} bytes in it, which is the limit here")]
    TooLong {
        /// The limit.
        limit: usize,
    },
    /// The file is cut off before anything was recorded.
    #[error("is cut off before the first state: there is nothing to replay")]
    Empty,
    /// The file's scenario is not sound.
    #[error("has a scenario that cannot be used: {0}")]
    Scenario(#[from] ScenarioError),
    /// The file's header contradicts its scenario.
    #[error(
        "has a header of another scenario: its step is {found} ns there, and {step_ns} ns in the scenario"
    )]
    Step {
        /// The header's step, in nanoseconds.
        found: u64,
        /// The scenario's, in nanoseconds.
        step_ns: u64,
    },
    /// The file has more in one message than there can be.
    #[error("has a message on {topic} with {found} entries in field {field}; there are at most {limit}")]
    Crowded {
        /// The topic.
        topic: String,
        /// The number of the field.
        field: u32,
        /// The number that there are.
        found: usize,
        /// The number that there may be.
        limit: usize,
    },
    /// The file's first state cannot be used.
    #[error("begins with a state (tick {tick}, of baudbot {program}) that {source}")]
    State {
        /// The state's tick.
        tick: u64,
        /// The version of the program that wrote it.
        program: String,
        /// The error in the state.
        source: SavedError,
    },
}

/// A reason why a recording could not be written on.
#[derive(Debug, Error)]
#[error("{}", self.words())]
pub struct WriteError(#[from] mcap::McapError);

impl WriteError {
    fn words(&self) -> String {
        // The system's message has more than the fact of an error.
        if let mcap::McapError::Io(error) = &self.0 { error.to_string() } else { self.0.to_string() }
    }
}

/// The packing of a file that cannot be read here, and the remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Packing {
    /// The data are packed by Zstandard.
    #[error("`zstd`; repack it with `lz4` (mcap compress --compression lz4)")]
    Zstd,
    /// The data are packed by LZ4, in a build without it.
    #[error("`lz4`, and this program was built without the feature `lz4`; unpack it (mcap decompress)")]
    Lz4,
}
