//! What operators order.

use std::sync::Arc;
use std::time::Instant;

use baudbot_proto::{REASON, RESTART};
use baudbot_sim::{InterventionError, World};
use tokio::sync::oneshot;
use tonic::Status;
use tonic::metadata::MetadataValue;

use super::replay::Replaying;
use super::stopwatch::Stopwatch;
use super::{Host, Snapshot, senders};
use crate::letter::{Letter, Order, Report, SeatReport};
use crate::log::event;
use crate::observers::View;
use crate::pace::{Pace, Pacing};
use crate::recording::Recorder;
use crate::words::brief;

/// States that are kept for one world; the oldest goes when there would be more.
const MAX_SNAPSHOTS: usize = 64;

/// Changes by hand that wait for the end of a tick.
const MAX_INTERVENTIONS: usize = 64;

impl Host {
    pub(super) fn obey(&mut self, order: Order, reply: oneshot::Sender<Result<Report, Status>>) {
        if reply.is_closed() {
            return; // who ordered it is gone
        }
        if let Err(status) = self.check_order(&order) {
            return drop(reply.send(Err(status)));
        }
        let mut snapshot = 0;
        self.log_order(&order);
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
                self.answer_stepper();
            }
            Order::Step { ticks } => return self.step(ticks, reply),
            Order::Seek { tick } => return self.seek(tick, reply),
            Order::Fork(pace) => self.fork(pace),
            Order::Record(config) => {
                if let Err(status) = self.record(config) {
                    return drop(reply.send(Err(status)));
                }
            }
            Order::StopRecording(told) => {
                let stopped = self.stop_recording(told);
                return drop(reply.send(stopped.map(|world| Report { world, ..self.report(0) })));
            }
            Order::Save { snapshot } => return drop(reply.send(self.saved(snapshot))),
            Order::SetPace(pace) => self.set_pace(pace),
            Order::Reset => {
                let world = World::new(Arc::clone(self.world.origin()));
                self.senders = senders(&world);
                self.pacing = Pacing::default();
                self.running = Stopwatch::default();
                self.replace(world);
            }
            Order::Snapshot => snapshot = self.keep(),
            Order::Restore { snapshot } => {
                let (world, senders) = match self.kept(snapshot) {
                    Ok(kept) => (kept.world.clone(), kept.senders.clone()),
                    Err(status) => return drop(reply.send(Err(status))),
                };
                event!(self, info, snapshot, "world restored");
                self.senders = senders;
                self.replace(world);
            }
            Order::Intervene(intervention) => {
                if self.interventions.len() >= MAX_INTERVENTIONS {
                    let text = format!(
                        "intervention: {MAX_INTERVENTIONS} wait for the end of the tick, which is the limit"
                    );
                    return drop(reply.send(Err(Status::resource_exhausted(text))));
                }
                self.interventions.push((intervention, reply));
                if !self.begun {
                    self.intervene();
                }
                return;
            }
            Order::DetachBrain { robot, restart } => {
                return match self.detach_brain(&robot, restart) {
                    Ok(()) => self.open(Letter::Order(Order::Report, reply)),
                    Err(status) => drop(reply.send(Err(status))),
                };
            }
            Order::Delete => {
                // Who deletes a world and then ends the program finds its file whole.
                self.end_recording();
                self.over = Some(Status::aborted(format!("world `{}` was deleted", self.name)));
            }
        }
        drop(reply.send(Ok(self.report(snapshot))));
    }

    /// Changes things by hand, now that no tick is under way.
    pub(super) fn intervene(&mut self) {
        let mut any = false;
        for (intervention, reply) in std::mem::take(&mut self.interventions) {
            if reply.is_closed() {
                continue; // who ordered it has given up
            }
            let done = self.world.intervene(&intervention);
            event!(self, debug, ?intervention, done = done.is_ok(), "changed by hand");
            any |= done.is_ok();
            if done.is_ok() {
                self.record_change(&intervention);
            }
            let answer = done.map(|()| self.report(0)).map_err(|error| refused(&error));
            drop(reply.send(answer));
        }
        if any {
            let view = View {
                name: &self.name,
                world: &self.world,
                sessions: &self.sessions,
                beliefs: &self.beliefs,
            };
            self.observers.show_now(view);
        }
    }

    /// What was to be changed was to be changed in the world as it was.
    fn drop_interventions(&mut self) {
        let gone =
            || Err(Status::aborted("intervention: the world was reset or restored before it could be done"));
        for letter in std::mem::take(&mut self.held) {
            match letter {
                Letter::Order(Order::Intervene(_), reply) => drop(reply.send(gone())),
                letter => self.held.push_back(letter),
            }
        }
        for (_, reply) in std::mem::take(&mut self.interventions) {
            drop(reply.send(gone()));
        }
    }

    /// Throws a robot's brain off, for good or to begin anew.
    fn detach_brain(&mut self, robot: &str, restart: bool) -> Result<(), Status> {
        let robots = self.world.scenario().robots();
        let Some(i) = robots.iter().position(|spec| spec.name == robot) else {
            return Err(Status::not_found(format!(
                "detach_brain.robot: there is no robot `{}`",
                brief(robot)
            )));
        };
        let Some(session) = self.sessions.session(i) else {
            let text = format!("detach_brain.robot: robot `{robot}` has no brain");
            return Err(Status::failed_precondition(text));
        };
        let why = if restart { restarted() } else { Status::aborted("the operator has detached this brain") };
        self.close(session, why);
        Ok(())
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
        if self.is_at_replays_end() {
            let text = "the recording ends here; seek an earlier tick, or go on live by ForkReplay";
            return drop(reply.send(Err(Status::failed_precondition(text))));
        }
        if self.replaying.is_none() && !self.begun && self.sessions.has_awaited_empty_seat() {
            let text = "a robot has no brain, and the world waits for one; attach it, or go on without by StartWorld";
            return drop(reply.send(Err(Status::failed_precondition(text))));
        }
        if self.stepper.as_ref().is_some_and(|stepper| !stepper.is_closed()) {
            let text = format!(
                "world: `{}` does ticks for another StepWorld, {} are left; wait for them, or end them with PauseWorld",
                self.name, self.credits
            );
            return drop(reply.send(Err(Status::failed_precondition(text))));
        }
        self.paused = false;
        self.credits = ticks.max(1);
        self.stepper = Some(reply);
    }

    /// A tick is done. If nobody waits any more for those that are left of a StepWorld, there are no further ones.
    pub(super) fn spend_credit(&mut self) {
        let is_wanted = self.stepper.as_ref().is_some_and(|stepper| !stepper.is_closed());
        self.credits = if is_wanted { self.credits.saturating_sub(1) } else { 0 };
    }

    pub(super) fn answer_stepper(&mut self) {
        if let Some(reply) = self.stepper.take() {
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
        if let Some(recorder) = &mut self.recorder {
            recorder.set_pace(pace);
        }
        self.clock = None;
        self.credits = 0;
        self.answer_stepper();
        self.waiting_since = Instant::now();
    }

    /// The world goes on from another state.
    fn replace(&mut self, world: World) {
        let old = std::mem::replace(&mut self.world, world);
        self.record_anew(&old);
        self.begun = false;
        self.ending = false;
        self.clock = None;
        self.inputs.clear();
        self.sessions.forget_steps();
        self.sessions.void_turns();
        self.credits = 0;
        self.answer_stepper();
        self.drop_interventions();
        self.beliefs.forget_all();
        self.observers.begin_anew(&self.world);
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

    /// The state of this number.
    fn kept(&self, snapshot: u64) -> Result<&Snapshot, Status> {
        let found = self.snapshots.iter().find(|kept| kept.number == snapshot);
        let none =
            || Status::not_found(format!("snapshot: world `{}` keeps no snapshot {snapshot}", self.name));
        found.ok_or_else(none)
    }

    /// The present state, or one that was kept.
    fn saved(&self, snapshot: u64) -> Result<Report, Status> {
        let world = match snapshot {
            0 => self.world.clone(),
            snapshot => self.kept(snapshot)?.world.clone(),
        };
        Ok(Report { world, ..self.report(0) })
    }

    pub(super) fn report(&self, snapshot: u64) -> Report {
        let seats = self.sessions.seats().zip(self.beliefs.said()).map(|((seat, brain), said)| SeatReport {
            brain: brain.map(str::to_owned),
            lost_deliveries: seat.lost_deliveries,
            lost_steps: self.sessions.lost_steps(seat),
            said,
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
            replay: self.replaying.as_ref().map(Replaying::report),
            recording: self.recorder.as_ref().map(Recorder::report),
        }
    }
}

/// Why the stream of a brain ends that is to begin anew. Who does not know the trailer goes as if thrown off.
fn restarted() -> Status {
    let mut status = Status::aborted("the operator restarts this brain");
    status.metadata_mut().insert(REASON, MetadataValue::from_static(RESTART));
    status
}

fn refused(error: &InterventionError) -> Status {
    let text = format!("intervention: {error}");
    match error {
        InterventionError::Unknown { .. } => Status::not_found(text),
        // The host knows of no tick, so the state was restored.
        InterventionError::WithinTick => Status::failed_precondition(format!(
            "{text}: a state was restored that was kept within one; it can be changed after a step"
        )),
        InterventionError::Place { .. } | InterventionError::Baud { .. } => Status::invalid_argument(text),
        _ => Status::failed_precondition(text),
    }
}
