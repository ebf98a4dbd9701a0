//! Reports: the data of a world that operators get.

use std::sync::Arc;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_sim::coverage::Coverage;
use baudbot_sim::{Scenario, World};
use tokio::sync::oneshot;
use tonic::Status;

use crate::limits::Held;
use crate::pace::Pace;
use crate::thinking::Thought;

/// A world as it stands.
pub(crate) struct Report {
    /// A copy of its state: the rest of its status is made of it where no world waits for that.
    pub(crate) world: World,
    /// The memory of the copy.
    pub(crate) held: Option<Held>,
    pub(crate) pace: Pace,
    /// The rest of its status that is not in its state.
    pub(crate) beside: v1::WorldStatus,
    /// One for each robot.
    pub(crate) slots: Vec<SlotReport>,
    /// The number of the snapshot that was just taken; 0 if none was.
    pub(crate) snapshot: u64,
    /// The number of resets, restored states and changes of pace.
    pub(crate) era: u64,
}

impl Report {
    /// Adds how the world's recording has ended, once its file is closed.
    ///
    /// # Errors
    /// If the thread that writes it is gone.
    pub(crate) async fn end_recording(
        &mut self,
        file: oneshot::Receiver<v1::RecordingStatus>,
    ) -> Result<(), Status> {
        let gone = |_| Status::internal("the recording's thread is gone");
        self.beside.recording = Some(file.await.map_err(gone)?);
        Ok(())
    }
}

/// The parts that have to be the same for the status of a world to be the same, but for the time for which it has
/// been running.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Version {
    /// Ticks, and messages that change something.
    pub(crate) changes: u64,
    /// Beliefs that its brains have published.
    pub(crate) beliefs: u64,
    /// Steps of its brains that were thrown away, also outside the world's own thread.
    pub(crate) lost_steps: u64,
    /// Bytes and ticks of its recording, and whether that has a problem.
    pub(crate) recording: Option<(u64, u64, bool)>,
}

/// The standing of a world, for a caller who may know that already.
pub(crate) struct Standing {
    pub(crate) version: Version,
    pub(crate) running: Duration,
    /// `None` if nothing has changed since the version that is known.
    pub(crate) report: Option<Report>,
}

/// The activity of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Activity {
    WaitingForBrains,
    Running,
    Paused,
    Ended,
}

/// Whether the state of a world is kept, for monitoring.
#[derive(Clone, Debug)]
pub(crate) struct Keeping {
    /// Something could not be written, and a new journal could not be begun since.
    pub(crate) is_lost: bool,
    /// The last tick that is in the journal.
    pub(crate) tick: u64,
}

/// A robot's slot: the brain that holds it, and what was lost on the way to and from its brains.
pub(crate) struct SlotReport {
    pub(crate) brain: Option<String>,
    pub(crate) lost_deliveries: u64,
    pub(crate) lost_steps: u64,
    /// The state that its brain last published, in words.
    pub(crate) said: String,
    /// The thinking times of its brains, if anything was measured.
    pub(crate) thought: Option<Box<Thought>>,
}

/// The cells of the floor that are covered and sensed.
pub(crate) struct CoverageReport {
    pub(crate) tick: u64,
    /// The era as in [`Report`].
    pub(crate) era: u64,
    pub(crate) scenario: Arc<Scenario>,
    /// `None` if the scenario counts no coverage.
    pub(crate) coverage: Option<Coverage>,
}

impl CoverageReport {
    /// A copy of the world's bits. They are made into runs of cells where no world waits for that.
    pub(crate) fn of(world: &World, era: u64) -> Self {
        let scenario = Arc::clone(world.scenario());
        Self { tick: world.tick(), era, scenario, coverage: world.score().coverage().cloned() }
    }
}
