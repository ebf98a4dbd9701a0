//! The state of a world that outlives its server: when it is kept, and how a world begins that has outlived one.

use std::sync::Arc;
use std::time::Instant;

use baudbot_proto::v1;
use baudbot_recording::journal::PortState;
use baudbot_sim::{Intervention, Scenario};

use super::ports::senders;
use super::{Phase, WorldActor};
use crate::endpoint::Sender;
use crate::log::event;
use crate::pool::Waker;
use crate::report::Keeping;
use crate::state::{Keeper, Now, Resumed, StateFolder};

/// The state of a world, as far as it is kept.
pub(super) struct State {
    /// The folder; `None` if nothing is kept.
    folder: Option<StateFolder>,
    /// `None` in a replay, too.
    keeper: Option<Keeper>,
    /// The scenario with which the world was made.
    made: Arc<Scenario>,
}

/// The world at the moment: a macro, so that the keeper can be borrowed meanwhile.
macro_rules! now {
    ($actor:expr) => {
        Now {
            name: &$actor.name,
            world: &$actor.world,
            sessions: &$actor.sessions,
            pace: $actor.pacer.pace,
            paused: $actor.pacer.paused,
            senders: match $actor.phase {
                Phase::Begun => &$actor.ports.senders_at_begin,
                Phase::Between | Phase::Ending => &$actor.ports.senders,
            },
            coming_back: &$actor.ports.resumed,
            recording: $actor.recording.config(),
        }
    };
}

impl State {
    /// The state of a world that is not kept yet.
    pub(super) fn new(folder: Option<StateFolder>, made: Arc<Scenario>) -> Self {
        Self { folder, keeper: None, made }
    }

    /// Whether it is kept, or is attempted to be.
    pub(super) fn is_kept(&self) -> bool {
        self.keeper.is_some()
    }

    /// Whether requests may have to wait for a disk because of it.
    pub(super) fn needs_disk(&self) -> bool {
        self.folder.is_some()
    }

    /// The state of keeping, for monitoring.
    pub(super) fn keeping(&self) -> Option<Keeping> {
        self.keeper.as_ref().map(Keeper::keeping)
    }

    /// Collects what entered the world.
    pub(super) fn inputs(&mut self, inputs: &v1::RecordedInputs) {
        if let Some(keeper) = &mut self.keeper {
            keeper.inputs(inputs);
        }
    }

    /// Collects a manual change before this tick.
    pub(super) fn change(&mut self, tick: u64, intervention: &Intervention) {
        if let Some(keeper) = &mut self.keeper {
            let changes = vec![baudbot_recording::change(intervention)];
            keeper.inputs(&v1::RecordedInputs { tick, changes, inputs: Vec::new() });
        }
    }

    /// The instant at which something is to be attempted that has failed, if it is before `until`.
    pub(super) fn until(&self, until: Option<Instant>) -> Option<Instant> {
        let retry = self.keeper.as_ref().and_then(Keeper::retry_at);
        retry.into_iter().chain(until).min()
    }
}

impl WorldActor {
    /// The world begins as its server has left it.
    pub(super) fn resume(&mut self, resumed: Resumed) {
        let Resumed { made, ports, slots, snapshots, recording } = resumed;
        self.state.made = made;
        restore(&mut self.ports.senders, &ports);
        self.ports.senders_at_begin.clone_from(&self.ports.senders);
        self.sessions.resume(&slots);
        self.ports.resumed = self.sessions.held(&slots);
        for snapshot in snapshots {
            let mut senders = senders(&snapshot.world);
            restore(&mut senders, &snapshot.ports);
            match self.charges.snapshot() {
                Ok(mut charge) => {
                    charge.count(&self.charges, &snapshot.world);
                    self.snapshots.resume(snapshot.number, snapshot.world, senders, charge);
                }
                // The snapshot's file stays.
                Err(exceeded) => {
                    event!(self, warn, snapshot = snapshot.number, %exceeded, "a snapshot is not there again");
                }
            }
            self.resumed_snapshots.push((snapshot.number, snapshot.bytes));
        }
        if let Some(config) = recording {
            self.record_on(config);
        }
    }

    /// Keeps the state from now on, if there is a folder for it and the world is no replay.
    pub(super) fn begin_to_keep(&mut self) {
        let Some(folder) = self.state.folder.clone() else { return };
        if self.replaying.is_some() {
            event!(self, info, "a replay is not there again after a restart");
            return;
        }
        let most = self.most_snapshots();
        let mut keeper = folder.keep(Arc::clone(&self.state.made), &now!(self));
        for (number, bytes) in std::mem::take(&mut self.resumed_snapshots) {
            keeper.note_snapshot(number, bytes, most);
        }
        self.state.keeper = Some(keeper);
    }

    /// Registers the waker of the world: a disk that fails while there is no other work wakes it, so that keeping is
    /// attempted again.
    pub(super) fn wakes_if_lost(&self, waker: &Waker) {
        if let Some(keeper) = &self.state.keeper {
            keeper.wakes_if_lost(waker.clone());
        }
    }

    /// Keeps the state if it is due, at the start of a tick or before an observer gets it.
    pub(super) fn keep(&mut self) {
        if let Some(keeper) = &mut self.state.keeper {
            keeper.keep(&now!(self));
        }
    }

    /// Keeps a change before its caller is answered.
    pub(super) fn keep_now(&mut self) {
        if let Some(keeper) = &mut self.state.keeper {
            keeper.keep_now(&now!(self));
        }
    }

    /// The world goes on from another state.
    pub(super) fn keep_anew(&mut self) {
        if let Some(keeper) = &mut self.state.keeper {
            keeper.begin(&now!(self));
        }
    }

    /// Keeps a snapshot of the present state.
    pub(super) fn keep_snapshot(&mut self, number: u64) {
        let most = self.most_snapshots();
        if let Some(keeper) = &mut self.state.keeper {
            keeper.snapshot(&now!(self), number, most);
        }
    }

    /// Ends keeping when the server stops.
    pub(super) fn close_state(&mut self) {
        if let Some(mut keeper) = self.state.keeper.take() {
            keeper.close(&now!(self));
        }
    }

    /// The world is deleted.
    pub(super) fn remove_state(&mut self) {
        if let Some(keeper) = self.state.keeper.take() {
            keeper.remove(&now!(self));
        }
    }
}

/// The senders as they were.
fn restore(senders: &mut [Sender], ports: &[PortState]) {
    for PortState { robot, sequence, raw, others } in ports {
        if let Some(sender) = senders.get_mut(*robot as usize) {
            *sender = Sender::from_parts(u8::try_from(*sequence).unwrap_or_default(), *raw, others.clone());
        }
    }
}
