//! The parts of a world, and the making of one.

use std::sync::Arc;
use std::sync::atomic::AtomicU32;

use baudbot_proto::v1;
use baudbot_recording::Replay;
use baudbot_sim::World;
use tonic::Status;

use super::WorldActor;
use super::progress::Progress;
use crate::limits::{Charges, Exceeded, InForce};
use crate::mailbox::Mailbox;
use crate::message::{RecordConfig, WorldHandle};
use crate::pace::Pace;
use crate::pool::Pool;
use crate::state::{Resumed, StateFolder};
use crate::thinking::ProcessorTime;

/// Called at the start of every tick, when the sensors have been read, on the world's own thread.
pub type OnTick = Box<dyn FnMut(&World) + Send>;

/// Called with a robot's place and what its brain has published, just before [`OnTick`] of the tick behind. In lockstep it is the
/// same on any machine, if the world has an [`OnTick`], too.
pub type OnBelief = Box<dyn FnMut(&World, usize, &v1::Belief) + Send>;

/// A world that is about to be made.
pub(crate) struct NewWorld {
    pub(crate) name: String,
    pub(crate) world: World,
    /// The recording that it replays; `None` for a live world.
    pub(crate) replay: Option<Replay>,
    pub(crate) pace: Pace,
    pub(crate) paused: bool,
    pub(crate) on_tick: Option<OnTick>,
    pub(crate) on_belief: Option<OnBelief>,
    pub(crate) progress: Option<Arc<Progress>>,
    /// The recording from its beginning on.
    pub(crate) record: Option<RecordConfig>,
    /// The processor time of its brains; `None` if that is not known.
    pub(crate) processor: Option<ProcessorTime>,
    /// The parts besides its state, if it has outlived a server.
    pub(crate) resumed: Option<Resumed>,
    /// The folder of its state; `None` if that is not kept.
    pub(crate) state: Option<StateFolder>,
}

impl NewWorld {
    /// The memory that it takes.
    ///
    /// # Errors
    /// If there is not so much.
    pub(crate) fn charges(&self, limits: &InForce) -> Result<Charges, Exceeded> {
        let recording = self.replay.as_ref().map(|replay| replay.recorded().memory_bytes() as u64);
        Charges::new(limits, &self.world, recording)
    }

    /// A live world that is not recorded.
    pub(crate) fn new(name: String, world: World, pace: Pace) -> Self {
        Self {
            name,
            world,
            replay: None,
            pace,
            paused: false,
            on_tick: None,
            on_belief: None,
            progress: None,
            record: None,
            processor: None,
            resumed: None,
            state: None,
        }
    }
}

/// Makes a world, which this pool runs, with this memory. `neighbours` is how many worlds there are on the server.
///
/// # Errors
/// If its recording cannot begin, or the pool has no thread for it.
pub(crate) fn start(
    mut new: NewWorld,
    charges: Charges,
    neighbours: Arc<AtomicU32>,
    pool: &mut Pool,
) -> Result<WorldHandle, Status> {
    let (name, record): (Arc<str>, _) = (new.name.as_str().into(), new.record.clone());
    let (robots, paused) = (new.world.robots().len(), new.paused);
    let resumed = new.resumed.take();
    let made = resumed.as_ref().map_or_else(|| Arc::clone(new.world.origin()), |it| Arc::clone(&it.made));
    let (tick, time_s, room) = (new.world.tick(), new.world.time().as_seconds(), charges.room());
    let mut actor = WorldActor::new(Arc::clone(&name), new, charges, neighbours);
    if let Some(record) = record {
        actor.record(record)?;
    }
    if let Some(resumed) = resumed {
        actor.resume(resumed);
    }
    actor.begin_to_keep();
    let mailbox = pool
        .add(|waker| {
            actor.wakes_if_lost(&waker);
            Arc::new(Mailbox::new(actor, waker))
        })
        .map_err(|error| Status::resource_exhausted(format!("no thread for another world: {error}")))?;
    tracing::info!(world = &*name, tick, time_s, robots, paused, "world made");
    Ok(WorldHandle::new(name, made, room, mailbox))
}
