//! The charges of a world on the server's memory.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use baudbot_sim::World;

use super::memory::ScenarioHeld;
use super::{Exceeded, Held, InForce, Place};

/// The memory of a world, and the limits of the server that it is on.
pub(crate) struct Charges {
    limits: InForce,
    scenario: Arc<ScenarioHeld>,
    state: Held,
    /// The memory of a replay: the recording, and the world that it keeps.
    _recording: Option<Held>,
    /// The bytes of the state, for those who want to copy it.
    told: Arc<AtomicU64>,
    /// The tick at which it is counted again.
    again_at: u64,
    /// Events of each robot that it keeps, as it was last counted.
    events: usize,
}

/// The memory of a snapshot.
pub(crate) struct SnapshotCharge {
    _place: Place,
    scenario: Arc<ScenarioHeld>,
    state: Held,
}

impl Charges {
    /// The charges of a new world; `recording_bytes` is what it replays.
    ///
    /// # Errors
    /// If there is not so much memory.
    pub(crate) fn new(
        limits: &InForce,
        world: &World,
        recording_bytes: Option<u64>,
    ) -> Result<Self, Exceeded> {
        let scenario = limits.hold_scenario(world.origin())?;
        let bytes = world.memory_bytes() as u64;
        let state = limits.hold(bytes)?;
        let recording = recording_bytes.map(|recorded| limits.hold(recorded + bytes)).transpose()?;
        let told = Arc::new(AtomicU64::new(bytes));
        Ok(Self {
            limits: limits.clone(),
            scenario,
            state,
            _recording: recording,
            told,
            again_at: world.tick() + FIRST,
            events: world.usual_timeline(),
        })
    }

    pub(crate) fn limits(&self) -> &InForce {
        &self.limits
    }

    /// The limits for a copy of the state: the server's, and the bytes of the state as they were last counted.
    pub(crate) fn room(&self) -> (InForce, Arc<AtomicU64>) {
        (self.limits.clone(), Arc::clone(&self.told))
    }

    /// Memory for another state of this world.
    ///
    /// # Errors
    /// If there is not so much.
    pub(crate) fn another(&self) -> Result<Held, Exceeded> {
        self.limits.hold(self.state.bytes())
    }

    /// The memory of a copy of the state for a response, whatever the limit: of such copies there are few.
    pub(crate) fn copied(&self) -> Option<Held> {
        self.limits.count_memory(self.state.bytes())
    }

    /// Memory for a snapshot of this world, and its place.
    ///
    /// # Errors
    /// If there is none.
    pub(crate) fn snapshot(&self) -> Result<SnapshotCharge, Exceeded> {
        let (place, state) = (self.limits.snapshot()?, self.another()?);
        Ok(SnapshotCharge { _place: place, scenario: Arc::clone(&self.scenario), state })
    }

    /// The world is at the start of a tick. What it has grows in the first ticks of a run, and seldom later: it is counted after some,
    /// and whenever there are twice as many.
    pub(crate) fn follow(&mut self, world: &World) {
        if world.tick() >= self.again_at {
            self.count(world);
        }
    }

    /// The world keeps so many events of each robot by now.
    pub(crate) fn fit_timeline(&mut self, events: usize, world: &World) {
        if std::mem::replace(&mut self.events, events) != events {
            self.count(world);
        }
    }

    /// The world has gone on from another state. A scenario that came with it has been counted before.
    pub(crate) fn count(&mut self, world: &World) {
        if let Ok(scenario) = self.limits.hold_scenario(world.origin()) {
            self.scenario = scenario;
        }
        self.state.set(world.memory_bytes() as u64);
        self.told.store(self.state.bytes(), Ordering::Relaxed);
        self.again_at = (world.tick() * 2).max(FIRST);
    }
}

/// Ticks after which a world is counted again.
const FIRST: u64 = 64;

impl SnapshotCharge {
    /// A snapshot has been taken of a world with these charges.
    pub(crate) fn count(&mut self, charges: &Charges, world: &World) {
        self.scenario = Arc::clone(&charges.scenario);
        self.state.set(world.memory_bytes() as u64);
    }
}
