//! What operators order.

use std::sync::Arc;
use std::time::Instant;

use baudbot_sim::World;
use tokio::sync::oneshot;
use tonic::Status;

use super::stopwatch::Stopwatch;
use super::{Host, Snapshot, sender};
use crate::letter::{Order, Report, SeatReport};
use crate::pace::{Pace, Pacing};

/// States that are kept for one world; the oldest goes when there would be more.
const MAX_SNAPSHOTS: usize = 64;

impl Host {
    pub(super) fn obey(&mut self, order: Order, reply: oneshot::Sender<Result<Report, Status>>) {
        if reply.is_closed() {
            return; // who ordered it is gone
        }
        let mut snapshot = 0;
        match order {
            Order::Report => {}
            Order::Start => {
                self.paused = false;
                self.sessions.excuse_empty_seats();
            }
            Order::Pause => {
                self.paused = true;
                self.clock = None;
                self.credits = 0;
                self.answer_steppers();
            }
            Order::Step { ticks } => return self.step(ticks, reply),
            Order::SetPace(pace) => self.set_pace(pace),
            Order::Reset => {
                let world = World::new(Arc::clone(self.world.scenario()));
                self.senders = world.robots().map(|robot| sender(&robot)).collect();
                self.pacing = Pacing::default();
                self.running = Stopwatch::default();
                self.replace(world);
            }
            Order::Snapshot => snapshot = self.keep(),
            Order::Restore { snapshot } => {
                let Some(kept) = self.snapshots.iter().find(|kept| kept.number == snapshot) else {
                    let text = format!("snapshot: world `{}` keeps no snapshot {snapshot}", self.name);
                    return drop(reply.send(Err(Status::not_found(text))));
                };
                let world = kept.world.clone();
                self.senders.clone_from(&kept.senders);
                self.replace(world);
            }
            Order::Delete => self.deleted = true,
        }
        drop(reply.send(Ok(self.report(snapshot))));
    }

    fn step(&mut self, ticks: u64, reply: oneshot::Sender<Result<Report, Status>>) {
        if !matches!(self.pace, Pace::Stepped(_)) {
            let text = "the world's pace is not stepped; set it with SetPace";
            return drop(reply.send(Err(Status::failed_precondition(text))));
        }
        if let Some(ending) = self.world.ending() {
            let text = format!("the run has ended ({ending}); reset or restore the world");
            return drop(reply.send(Err(Status::failed_precondition(text))));
        }
        if !self.begun && self.sessions.has_awaited_empty_seat() {
            let text = "a robot has no brain, and the world waits for one; attach it, or go on without by StartWorld";
            return drop(reply.send(Err(Status::failed_precondition(text))));
        }
        self.paused = false;
        self.credits = self.credits.saturating_add(ticks.max(1));
        self.steppers.push(reply);
    }

    pub(super) fn answer_steppers(&mut self) {
        for reply in std::mem::take(&mut self.steppers) {
            drop(reply.send(Ok(self.report(0))));
        }
    }

    fn set_pace(&mut self, pace: Pace) {
        // From lockstep to lockstep, Turns that are open stay open.
        if self.pace.watchdog().is_none() || pace.watchdog().is_none() {
            for session in self.sessions.numbers_behind() {
                self.give_up(session);
            }
            self.sessions.void_turns();
        }
        self.pace = pace;
        self.clock = None;
        self.credits = 0;
        self.answer_steppers();
        self.waiting_since = Instant::now();
    }

    /// The world goes on from another state.
    fn replace(&mut self, world: World) {
        self.world = world;
        self.begun = false;
        self.ending = false;
        self.clock = None;
        self.inputs.clear();
        self.permits.clear();
        self.sessions.void_turns();
        self.credits = 0;
        self.answer_steppers();
    }

    fn keep(&mut self) -> u64 {
        self.last_snapshot += 1;
        if self.snapshots.len() == MAX_SNAPSHOTS {
            self.snapshots.pop_front();
        }
        let senders = if self.begun { &self.senders_at_begin } else { &self.senders };
        let (number, world, senders) = (self.last_snapshot, self.world.clone(), senders.clone());
        self.snapshots.push_back(Snapshot { number, world, senders });
        number
    }

    fn report(&self, snapshot: u64) -> Report {
        let seats = self.sessions.seats().map(|(seat, brain)| SeatReport {
            brain: brain.map(str::to_owned),
            lost_deliveries: seat.lost_deliveries,
        });
        Report {
            name: Arc::clone(&self.name),
            world: self.world.clone(),
            pace: self.pace,
            activity: self.activity(),
            pacing: self.pacing.clone(),
            running: self.running.elapsed(),
            seats: seats.collect(),
            snapshot,
        }
    }
}
