//! Snapshots: states that are kept, and another state to go on from.

use std::collections::VecDeque;
use std::sync::Arc;

use baudbot_sim::{Scenario, World};
use tonic::Status;

use super::{Phase, WorldActor};
use crate::endpoint::Sender;
use crate::limits::{Limit, SnapshotCharge};
use crate::log::event;
use crate::report::Report;

/// The snapshots of a world, oldest first. The oldest goes when there would be too many.
#[derive(Default)]
pub(super) struct Snapshots {
    kept: VecDeque<Snapshot>,
    last_number: u64,
}

struct Snapshot {
    number: u64,
    world: World,
    senders: Vec<Sender>,
    /// The memory of the snapshot.
    charge: SnapshotCharge,
}

impl Snapshots {
    /// Keeps a state. Gives its number.
    fn keep(&mut self, world: World, senders: Vec<Sender>, charge: SnapshotCharge) -> u64 {
        self.last_number += 1;
        self.kept.push_back(Snapshot { number: self.last_number, world, senders, charge });
        self.last_number
    }

    /// Forgets the oldest, if there are so many. Gives its number, and its memory for another one.
    fn make_room(&mut self, most: usize) -> Option<(u64, SnapshotCharge)> {
        let is_full = self.kept.len() >= most.max(1);
        let oldest = if is_full { self.kept.pop_front() } else { None };
        oldest.map(|Snapshot { number, charge, .. }| (number, charge))
    }

    /// A state that was kept has outlived its server.
    pub(super) fn resume(&mut self, number: u64, world: World, senders: Vec<Sender>, charge: SnapshotCharge) {
        self.last_number = number - 1;
        self.keep(world, senders, charge);
    }

    fn find(&self, number: u64) -> Option<&Snapshot> {
        self.kept.iter().find(|kept| kept.number == number)
    }
}

impl WorldActor {
    /// Snapshots that it keeps, at most.
    pub(super) fn most_snapshots(&self) -> usize {
        self.charges.limits().count(Limit::SnapshotsPerWorld)
    }

    /// Keeps the present state. Gives the snapshot's number.
    ///
    /// # Errors
    /// If there is no memory for it, or the server has too many.
    pub(super) fn take_snapshot(&mut self) -> Result<u64, Status> {
        let most = self.most_snapshots();
        let mut charge = match self.snapshots.make_room(most) {
            None => self.charges.snapshot()?,
            Some((oldest, charge)) => {
                event!(self, info, oldest, most, "the oldest snapshot has gone, as there are too many");
                let what = format!("the world `{}` has {most} snapshots", self.name);
                self.charges.limits().note(Limit::SnapshotsPerWorld, &what);
                charge
            }
        };
        let senders = match self.phase {
            Phase::Begun => &self.ports.senders_at_begin,
            Phase::Between | Phase::Ending => &self.ports.senders,
        };
        let world = self.world.clone();
        charge.count(&self.charges, &world);
        Ok(self.snapshots.keep(world, senders.clone(), charge))
    }

    fn snapshot(&self, number: u64) -> Result<&Snapshot, Status> {
        let none =
            || Status::not_found(format!("snapshot: world `{}` keeps no snapshot {number}", self.name));
        self.snapshots.find(number).ok_or_else(none)
    }

    /// Goes on from a snapshot.
    pub(super) fn restore(&mut self, number: u64) -> Result<(), Status> {
        let Snapshot { world, senders, .. } = self.snapshot(number)?;
        // Both states are there until the old one is gone.
        let _both = self.charges.another()?;
        let (world, senders) = (world.clone(), senders.clone());
        event!(self, info, snapshot = number, "world restored");
        self.ports.senders = senders;
        self.replace(world);
        Ok(())
    }

    /// Goes back to the beginning, of a run of this scenario.
    ///
    /// # Errors
    /// If there is no memory for it.
    pub(super) fn reset(&mut self, scenario: Arc<Scenario>) -> Result<(), Status> {
        let _both = self.charges.another()?;
        let world = World::new(scenario);
        self.ports.reset(&world);
        self.pacer.reset_statistics();
        self.replace(world);
        Ok(())
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
        self.charges.count(&self.world);
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
