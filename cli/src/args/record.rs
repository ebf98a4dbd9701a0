//! The options of recording, and of work with recordings.

use std::path::PathBuf;

use clap::Args;

use super::places::ListenArgs;
use super::value::{Bounds, ValueError};
use super::{PaceName, WatchdogArgs, instant};

/// Heading of the options of recordings.
pub(super) const HEADING: &str = "Recordings";

#[derive(Debug, Args)]
#[command(next_help_heading = HEADING)]
pub(crate) struct RecordArgs {
    /// Record the run into this file, which must not exist yet: for `baudbot replay` and other programs
    #[arg(long, value_name = "FILE.mcap", value_parser = file)]
    pub(crate) record: Option<PathBuf>,
    /// Frames recorded per simulated second, for other programs; a replay does not need them
    #[arg(long, value_name = "HZ", default_value_t = 10.0, value_parser = rate, requires = "record")]
    pub(crate) record_hz: f64,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// A recording, from `--record` or from a server's folder
    #[arg(value_name = "FILE.mcap")]
    pub(crate) recording: PathBuf,
    /// Show the recording in a browser, with a timeline, until Ctrl-C
    #[arg(long, conflicts_with = "fork")]
    pub(crate) view: bool,
    /// Replay up to this simulated time
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = instant)]
    pub(crate) to: Option<f64>,
    /// After the replay, serve the world live from the last tick replayed, for new brains, until Ctrl-C
    #[arg(long)]
    pub(crate) fork: bool,
    /// With --fork: when a tick ends, lockstep, real-time, scaled:X or free [default: the recorded pace]
    #[arg(long, value_name = "PACE", requires = "fork", help_heading = super::PACE)]
    pub(crate) pace: Option<PaceName>,
    /// Write the result as one JSON object
    #[arg(long, conflicts_with_all = ["view", "fork"])]
    pub(crate) json: bool,
    /// Suppress the progress bar and notes
    #[arg(long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) watchdog: WatchdogArgs,
    #[command(flatten)]
    pub(crate) again: RecordArgs,
    #[command(flatten)]
    pub(crate) listen: ListenArgs,
}

fn file(text: &str) -> Result<PathBuf, ValueError> {
    match text {
        "-" => Err(ValueError::Form("must be a file, as a recording cannot be written to stdout")),
        _ => Ok(text.into()),
    }
}

fn rate(text: &str) -> Result<f64, ValueError> {
    Bounds::Between(0.0, MOST_HZ).parsed(text)
}

/// The greatest rate: more than any viewer shows.
const MOST_HZ: f64 = 1000.0;
