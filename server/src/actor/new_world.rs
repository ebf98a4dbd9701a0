//! What a world is made of.

use std::sync::Arc;

use baudbot_recording::Replay;
use baudbot_sim::World;

use super::progress::Progress;
use crate::message::RecordConfig;
use crate::pace::Pace;
use crate::state::{Resumed, StateFolder};
use crate::thinking::ProcessorTime;

/// Called at the start of every tick, when the sensors have been read, on the world's own thread.
pub type OnTick = Box<dyn FnMut(&World) + Send>;

/// A world that is about to be made.
pub(crate) struct NewWorld {
    pub(crate) name: String,
    pub(crate) world: World,
    /// The recording that it replays; `None` for a live world.
    pub(crate) replay: Option<Replay>,
    pub(crate) pace: Pace,
    pub(crate) paused: bool,
    pub(crate) on_tick: Option<OnTick>,
    pub(crate) progress: Option<Arc<Progress>>,
    /// Where it is recorded from its beginning on.
    pub(crate) record: Option<RecordConfig>,
    /// How much processor time its brains have used; `None` if that is not known.
    pub(crate) processor: Option<ProcessorTime>,
    /// What it has besides its state, if it has outlived a server.
    pub(crate) resumed: Option<Resumed>,
    /// Where its state is kept; `None` if it is not.
    pub(crate) state: Option<StateFolder>,
}

impl NewWorld {
    /// A live world that is not recorded.
    pub(crate) fn new(name: String, world: World, pace: Pace) -> Self {
        Self {
            name,
            world,
            replay: None,
            pace,
            paused: false,
            on_tick: None,
            progress: None,
            record: None,
            processor: None,
            resumed: None,
            state: None,
        }
    }
}
