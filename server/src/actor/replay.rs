//! Replays: worlds that run again as they were recorded. Their brains are the recording, and time goes both ways.

use std::sync::Arc;
use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_recording::{RecordedRun, RecordingError, Replay};
use tonic::Status;

use super::ports::senders;
use super::{Next, Phase, WorldActor, view};
use crate::clock;
use crate::message::{Reply, Request};
use crate::pace::Pace;
use crate::report::{Activity, Report};

/// The time for which no messages are handled while a tick is sought.
const AT_ONCE: Duration = Duration::from_millis(20);

/// A replay. Its world always stands within a tick: the sensors have been read.
pub(super) struct Replaying {
    replay: Replay,
    seek: Option<Seek>,
    /// The reason why it cannot go on.
    problem: Option<String>,
}

/// A tick that is being sought, which may take longer than messages should wait.
struct Seek {
    tick: u64,
    /// The world has jumped on its way there.
    jumped: bool,
    reply: Reply<Report>,
}

impl Replaying {
    pub(super) fn new(replay: Replay) -> Self {
        Self { replay, seek: None, problem: None }
    }

    pub(super) fn status(&self) -> v1::ReplayStatus {
        let recorded = self.replay.recorded();
        let differs = self.replay.difference().map(ToString::to_string);
        v1::ReplayStatus {
            first_tick: recorded.first_tick(),
            last_tick: recorded.last_tick(),
            differs: self.problem.clone().or(differs).unwrap_or_default(),
        }
    }
}

impl WorldActor {
    /// The recording that is being replayed, if any is.
    pub(super) fn recorded(&self) -> Option<Arc<RecordedRun>> {
        self.replaying.as_ref().map(|replaying| Arc::clone(replaying.replay.recorded()))
    }

    /// Checks that what is requested can be requested of a live world, or of a replay.
    pub(super) fn check_request(&self, request: &Request) -> Result<(), Status> {
        match request {
            Request::Reset(_) => self.check_live("a reset"),
            Request::Snapshot | Request::Restore { .. } => self.check_live("a snapshot"),
            Request::Intervene(_) => self.check_live("a manual change"),
            Request::DetachBrain { .. } => self.check_live("a brain"),
            Request::Record(_) | Request::StopRecording(_) => self.check_live("a recording"),
            Request::Seek { .. } | Request::Fork(_) if self.replaying.is_none() => {
                let text = format!("world: `{}` is live, not a replay", self.name);
                Err(Status::failed_precondition(text))
            }
            Request::Seek { .. }
            | Request::Fork(_)
            | Request::Report
            | Request::Start
            | Request::Pause
            | Request::Step { .. }
            | Request::SetPace(_)
            | Request::Save { .. }
            | Request::Delete => Ok(()),
        }
    }

    /// Checks that the world is live, and can have such a thing therefore.
    pub(super) fn check_live(&self, what: &str) -> Result<(), Status> {
        if self.replaying.is_none() {
            return Ok(());
        }
        let text =
            format!("world: `{}` replays a recording, and can have {what} only after ForkReplay", self.name);
        Err(Status::failed_precondition(text))
    }

    pub(super) fn is_at_replays_end(&self) -> bool {
        self.replaying.as_ref().is_some_and(|replaying| self.is_replay_over(replaying))
    }

    fn is_replay_over(&self, replaying: &Replaying) -> bool {
        replaying.replay.is_over(&self.world) || replaying.problem.is_some()
    }

    pub(super) fn activity_of_replay(&self, replaying: &Replaying) -> Activity {
        if self.world.ending().is_some() && replaying.seek.is_none() {
            Activity::Ended
        } else if self.pacer.paused || self.is_out_of_credit() || self.is_replay_over(replaying) {
            Activity::Paused
        } else {
            Activity::Running
        }
    }

    pub(super) fn next_of_replay(&self, replaying: &Replaying, now: Instant) -> Next {
        if replaying.seek.is_some() {
            return Next::Replay;
        }
        if self.activity_of_replay(replaying) != Activity::Running {
            return Next::Wait(None);
        }
        match &self.pacer.clock {
            Some(clock) => {
                let due = clock.instant(self.tick_end());
                if now >= due { Next::Replay } else { Next::Wait(Some(due)) }
            }
            None => Next::Replay,
        }
    }

    /// Does a tick, or goes on towards the one that is sought.
    pub(super) fn replay(&mut self, now: Instant) {
        let Some(mut replaying) = self.replaying.take() else { return };
        self.changes += 1;
        replaying.replay.watch(self.observers.pinned());
        let result = match &replaying.seek {
            Some(seek) => self.approach(&mut replaying.replay, seek.tick, now),
            None => self.replay_tick(&mut replaying.replay, now),
        };
        if let Err(error) = result {
            replaying.problem = Some(format!("tick {}: the recording {error}", self.world.tick()));
        }
        let is_over = self.is_replay_over(&replaying);
        let found = replaying.seek.take_if(|seek| self.world.tick() >= seek.tick || is_over);
        self.replaying = Some(replaying);
        if let Some(seek) = found {
            if seek.jumped {
                self.forget_seen();
            }
            self.observers.show_now(view!(self));
            self.cables.listen(&mut self.world);
            drop(seek.reply.send(Ok(self.report(0))));
        }
        if is_over || self.stepper.credits == 0 {
            self.end_stepping();
        }
    }

    fn replay_tick(&mut self, replay: &mut Replay, now: Instant) -> Result<(), RecordingError> {
        if matches!(self.pacer.pace, Pace::Timed(_)) && self.pacer.clock.is_none() {
            self.follow_clock(now);
            return Ok(());
        }
        self.note_lateness(now);
        let tick = self.world.tick();
        let goes_on = replay.step(&mut self.world)?;
        if goes_on && self.world.tick() != tick + 1 {
            // The recording has a gap. The clock does not wait for as long as that took.
            self.pacer.clock = None;
            self.forget_seen();
        }
        self.spend_credit();
        self.show_start();
        self.show();
        self.follow_clock(now);
        Ok(())
    }

    /// Goes some way towards a tick, and returns so that messages can be handled.
    fn approach(&mut self, replay: &mut Replay, tick: u64, now: Instant) -> Result<(), RecordingError> {
        while self.world.tick() < tick && clock::since(now) < AT_ONCE && replay.step(&mut self.world)? {
            self.observers.note(&self.world);
        }
        Ok(())
    }

    /// Begins to seek a tick, and replies when the world is there.
    pub(super) fn seek(&mut self, tick: u64, reply: Reply<Report>) {
        let report = self.report(0);
        let Some(replaying) = &mut self.replaying else { return };
        let former = replaying.seek.take();
        let had_jumped = former.as_ref().is_some_and(|former| former.jumped);
        if let Some(former) = former {
            // A client may ask for another tick before the world is at the first.
            drop(former.reply.send(Ok(report)));
        }
        self.pacer.clock = None;
        replaying.replay.watch(self.observers.pinned());
        let recorded = replaying.replay.recorded();
        let tick = recorded.nearest(tick);
        match replaying.replay.approach(&mut self.world, tick) {
            Ok(jumped) => {
                replaying.seek = Some(Seek { tick, jumped: jumped || had_jumped, reply });
            }
            Err(error) => drop(reply.send(Err(Status::data_loss(format!("the recording {error}"))))),
        }
    }

    /// Makes a live world of the replay. It stands within its tick, which its brains get as soon as they attach.
    pub(super) fn fork(&mut self, pace: Pace) {
        let seek = self.replaying.take().and_then(|replaying| replaying.seek);
        if let Some(Seek { reply, .. }) = seek {
            self.forget_seen();
            drop(reply.send(Ok(self.report(0))));
        }
        self.world.keep_starts(false);
        self.pacer.paused = true;
        self.pacer.clock = None;
        self.phase = Phase::Between;
        self.pacer.pace = pace;
        self.ports.senders = senders(&self.world);
        self.end_stepping();
        self.fit_timeline();
        self.pacer.wait_from(clock::now());
        self.begin_to_keep();
    }
}
