//! Snapshots: states that are kept, and another state to go on from.

use std::collections::VecDeque;
use std::sync::Arc;

use baudbot_sim::{Scenario, World};
use tonic::Status;

use super::{Phase, WorldActor};
use crate::endpoint::Sender;
use crate::log::event;
use crate::report::Report;

/// Snapshots that are kept of one world. The oldest goes when there would be more.
pub(super) const MAX_SNAPSHOTS: usize = 64;

/// The snapshots of a world, oldest first.
#[derive(Default)]
pub(super) struct Snapshots {
    kept: VecDeque<Snapshot>,
    last_number: u64,
}

struct Snapshot {
    number: u64,
    world: World,
    senders: Vec<Sender>,
}

impl Snapshots {
    /// Keeps a state. Gives its number.
    fn keep(&mut self, world: World, senders: Vec<Sender>) -> u64 {
        self.last_number += 1;
        if self.kept.len() == MAX_SNAPSHOTS {
            self.kept.pop_front();
        }
        self.kept.push_back(Snapshot { number: self.last_number, world, senders });
        self.last_number
    }

    /// A state that was kept has outlived its server.
    pub(super) fn resume(&mut self, number: u64, world: World, senders: Vec<Sender>) {
        self.last_number = number - 1;
        self.keep(world, senders);
    }

    fn find(&self, number: u64) -> Option<&Snapshot> {
        self.kept.iter().find(|kept| kept.number == number)
    }
}

impl WorldActor {
    /// Keeps the present state. Gives the snapshot's number.
    pub(super) fn take_snapshot(&mut self) -> u64 {
        let senders = match self.phase {
            Phase::Begun => &self.ports.senders_at_begin,
            Phase::Between | Phase::Ending => &self.ports.senders,
        };
        self.snapshots.keep(self.world.clone(), senders.clone())
    }

    fn snapshot(&self, number: u64) -> Result<&Snapshot, Status> {
        let none =
            || Status::not_found(format!("snapshot: world `{}` keeps no snapshot {number}", self.name));
        self.snapshots.find(number).ok_or_else(none)
    }

    /// Goes on from a snapshot.
    pub(super) fn restore(&mut self, number: u64) -> Result<(), Status> {
        let Snapshot { world, senders, .. } = self.snapshot(number)?;
        let (world, senders) = (world.clone(), senders.clone());
        event!(self, info, snapshot = number, "world restored");
        self.ports.senders = senders;
        self.replace(world);
        Ok(())
    }

    /// Goes back to the beginning, of a run of this scenario.
    pub(super) fn reset(&mut self, scenario: Arc<Scenario>) {
        let world = World::new(scenario);
        self.ports.reset(&world);
        self.pacer.reset_statistics();
        self.replace(world);
    }

    /// The present state, or that of a snapshot.
    pub(super) fn saved(&self, snapshot: u64) -> Result<Report, Status> {
        let world = match snapshot {
            0 => self.world.clone(),
            number => self.snapshot(number)?.world.clone(),
        };
        Ok(Report { world, ..self.report(0) })
    }

    /// The world goes on from another state.
    fn replace(&mut self, world: World) {
        let old = std::mem::replace(&mut self.world, world);
        self.record_next_run(&old);
        self.sessions.forget_thought();
        self.phase = Phase::Between;
        self.pacer.clock = None;
        self.ports.inputs.clear();
        self.ports.to_devices.clear();
        self.sessions.reset_quotas();
        self.sessions.void_turns(&self.world);
        self.end_stepping();
        self.drop_interventions();
        self.beliefs.forget_all();
        self.forget_seen();
        self.fit_timeline();
        self.ports.resumed.fill(false);
        self.keep_anew();
    }
}
