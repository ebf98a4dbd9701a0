//! Requests of operators to a world.

use std::path::PathBuf;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_sim::{Intervention, Scenario};
use tokio::sync::oneshot;

use crate::pace::Pace;

/// A request of an operator.
#[derive(Debug)]
pub(crate) enum Request {
    Report,
    Start,
    Pause,
    /// Makes ticks, in the stepped pace.
    Step {
        ticks: u64,
    },
    SetPace(Pace),
    /// Resets to the beginning of a run of this scenario, whose robots have the data sheets that brains have received.
    Reset(Arc<Scenario>),
    Snapshot,
    Restore {
        snapshot: u64,
    },
    /// Reports the present state, or that of a snapshot; 0 is the present one.
    Save {
        snapshot: u64,
    },
    Record(RecordConfig),
    /// The status of the recording comes when its file is closed.
    StopRecording(oneshot::Sender<v1::RecordingStatus>),
    /// Goes to a tick, of a replay only.
    Seek {
        tick: u64,
    },
    /// Makes a live world of a replay; of a replay only.
    Fork(Pace),
    /// A manual change, before the next tick.
    Intervene(Intervention),
    /// Detaches the brain of the robot of this name.
    DetachBrain {
        robot: String,
        /// The brain is to begin from its start, if its program can.
        restart: bool,
    },
    Delete,
}

impl Request {
    /// The name of the request in traces.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Start => "start",
            Self::Pause => "pause",
            Self::Step { .. } => "step",
            Self::SetPace(_) => "set_pace",
            Self::Reset(_) => "reset",
            Self::Snapshot => "snapshot",
            Self::Restore { .. } => "restore",
            Self::Save { .. } => "save",
            Self::Record(_) => "record",
            Self::StopRecording(_) => "stop_recording",
            Self::Seek { .. } => "seek",
            Self::Fork(_) => "fork",
            Self::Intervene(_) => "intervene",
            Self::DetachBrain { .. } => "detach_brain",
            Self::Delete => "delete",
        }
    }
}

impl Request {
    /// The name of the request in a recording, if it changes something in the world. Steps do not, as their ticks are
    /// in the recording and there may be thousands a second.
    pub(crate) fn order(&self) -> Option<&'static str> {
        match self {
            Self::Start => Some("starts the world"),
            Self::Pause => Some("pauses the world"),
            Self::SetPace(_) => Some("sets the pace"),
            Self::Reset(_) => Some("resets the world"),
            Self::Snapshot => Some("takes a snapshot"),
            Self::Restore { .. } => Some("restores a snapshot"),
            Self::Save { .. } => Some("saves the state"),
            Self::StopRecording(_) => Some("ends the recording"),
            Self::Intervene(_) => Some("changes the world"),
            Self::DetachBrain { .. } => Some("detaches a brain"),
            Self::Delete => Some("deletes the world"),
            Self::Report | Self::Step { .. } | Self::Record(_) | Self::Seek { .. } | Self::Fork(_) => None,
        }
    }
}

/// The place of a recording, and its content besides inputs.
#[derive(Clone, Debug)]
pub(crate) struct RecordConfig {
    /// The name that operators know.
    pub(crate) name: String,
    /// The file, which must not be there yet.
    pub(crate) path: PathBuf,
    /// Frames a simulated second; 0 for none.
    pub(crate) look_hz: f64,
}

impl RecordConfig {
    /// The recording after a reset: `run.mcap`, then `run-2.mcap`. Runs are counted from 1.
    pub(crate) fn of_run(&self, run: u32) -> Self {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let path = self.path.with_file_name(format!("{stem}-{run}.mcap"));
        Self { name: format!("{}-{run}", self.name), path, ..self.clone() }
    }
}
