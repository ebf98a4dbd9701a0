//! The requests of operators.

use baudbot_proto::{REASON, RESTART, v1};
use tonic::Status;
use tonic::metadata::MetadataValue;

use super::WorldActor;
use super::replay::Replaying;
use crate::convert;
use crate::message::{Message, Reply, Request};
use crate::pace::Pace;
use crate::quote::brief;
use crate::report::{Activity, Report, Standing, Version};

impl WorldActor {
    /// Does what an operator requests, unless that is refused, and replies at once or when it is done.
    pub(super) fn handle_request(&mut self, request: Request, reply: Reply<Report>) {
        if reply.is_closed() {
            return; // its client is gone
        }
        if let Err(status) = self.check_request(&request) {
            return drop(reply.send(Err(status)));
        }
        self.log_request(&request);
        self.fulfil(request, reply);
    }

    /// Does what is requested and is not refused, and replies.
    fn fulfil(&mut self, request: Request, reply: Reply<Report>) {
        let answer = match request {
            Request::Step { ticks } => return self.step(ticks, reply),
            Request::Seek { tick } => return self.seek(tick, reply),
            Request::Intervene(intervention) => return self.request_intervention(intervention, reply),
            Request::DetachBrain { robot, restart } => match self.detach_brain(&robot, restart) {
                // The world may be ahead of other brains, and the report has to wait for them.
                Ok(()) => return self.handle(Message::Request(Request::Report, reply)),
                Err(status) => Err(status),
            },
            Request::Report => Ok(self.report(0)),
            Request::Save { snapshot } => self.saved(snapshot),
            Request::Snapshot => self.snapshot_now(),
            Request::Record(config) => self.record(config).map(|()| self.report(0)),
            Request::StopRecording(closed) => self.stop_recording(closed),
            Request::Restore { snapshot } => self.restore(snapshot).map(|()| self.report(0)),
            Request::Start => {
                self.check_load(self.pacer.pace).map(|()| self.start()).map(|()| self.report(0))
            }
            Request::Pause => {
                self.pause();
                return self.halted(reply);
            }
            Request::Reset(scenario) => self.reset(scenario).map(|()| self.report(0)),
            Request::Delete => self.reported(Self::delete),
            Request::SetPace(pace) => match self.check_load_at(pace) {
                Ok(()) => {
                    self.set_pace(pace);
                    return self.halted(reply);
                }
                Err(status) => Err(status),
            },
            Request::Fork(pace) => self.reported(|actor| actor.fork(pace)),
        };
        self.keep_now();
        drop(reply.send(answer));
    }

    /// Does what cannot fail, and reports.
    fn reported(&mut self, work: impl FnOnce(&mut Self)) -> Result<Report, Status> {
        work(self);
        Ok(self.report(0))
    }

    /// Takes a snapshot, keeps it, and reports its number.
    fn snapshot_now(&mut self) -> Result<Report, Status> {
        let number = self.take_snapshot()?;
        self.keep_snapshot(number);
        Ok(self.report(number))
    }

    /// Checks that the world may run at this pace, if others lag.
    fn check_load(&self, pace: Pace) -> Result<(), Status> {
        match pace {
            // A tick that waits for brains takes no longer than they do.
            Pace::Lockstep(_) | Pace::Stepped(_) => Ok(()),
            // One that runs already is a part of the load.
            Pace::Timed(_) | Pace::Free if self.activity() == Activity::Running => Ok(()),
            Pace::Timed(_) | Pace::Free => Ok(self.charges.limits().check_load()?),
        }
    }

    /// Checks that the world may get this pace.
    fn check_load_at(&self, pace: Pace) -> Result<(), Status> {
        match (pace, self.pacer.pace) {
            // The world stands, and is checked when it is started.
            _ if self.pacer.paused => Ok(()),
            (Pace::Timed(_), Pace::Timed(_)) => Ok(()),
            (Pace::Timed(_) | Pace::Free, _) => Ok(self.charges.limits().check_load()?),
            (Pace::Lockstep(_) | Pace::Stepped(_), _) => Ok(()),
        }
    }

    fn start(&mut self) {
        self.pacer.paused = false;
        self.sessions.excuse_vacant_slots();
    }

    fn pause(&mut self) {
        self.pacer.paused = true;
        self.pacer.clock = None;
        self.end_stepping();
    }

    fn delete(&mut self) {
        // The recording ends before the reply: a client that deletes a world and then ends the server finds the whole
        // file.
        self.end_recording();
        self.remove_state();
        self.over = Some(Status::aborted(format!("world `{}` was deleted", self.name)));
    }

    /// Detaches a robot's brain, for good or so that it begins from its start.
    fn detach_brain(&mut self, robot: &str, restart: bool) -> Result<(), Status> {
        let robots = &self.world.scenario().robots;
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

    /// The standing of the world, for a caller who knows it as it was at a version.
    pub(super) fn standing(&self, known: Option<&Version>) -> Standing {
        let recording = self.recording.status();
        let version = Version {
            changes: self.changes,
            beliefs: self.beliefs.published(),
            lost_steps: self.sessions.all_lost_steps(),
            recording: recording.map(|status| (status.bytes, status.ticks, !status.problem.is_empty())),
        };
        let report = (known != Some(&version)).then(|| self.report(0));
        Standing { version, running: self.pacer.running.elapsed(), report }
    }

    /// The world as it stands; with the number of the snapshot that was just taken, or 0.
    pub(super) fn report(&self, snapshot: u64) -> Report {
        let beside = v1::WorldStatus {
            world: self.name.to_string(),
            state: convert::activity(self.activity()).into(),
            running_wall_ns: convert::nanos(self.pacer.running.elapsed()),
            pacing: Some(convert::pace_status(&self.pacer.statistics)),
            replay: self.replaying.as_ref().map(Replaying::status),
            recording: self.recording.status(),
            ..Default::default()
        };
        Report {
            world: self.world.clone(),
            held: self.charges.copied(),
            pace: self.pacer.pace,
            beside,
            slots: self.sessions.reports(self.beliefs.said()),
            snapshot,
            era: self.sessions.era(),
        }
    }
}

/// The status that ends the stream of a brain that is to begin from its start. A client that does not know the trailer takes
/// it for a brain that was detached.
fn restarted() -> Status {
    let mut status = Status::aborted("the operator restarts this brain");
    status.metadata_mut().insert(REASON, MetadataValue::from_static(RESTART));
    status
}
