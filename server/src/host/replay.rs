//! A world that does again what was recorded: its brains are the recording, and time goes both ways.

use std::time::{Duration, Instant};

use baudbot_recording::{RecordingError, Replay};
use tokio::sync::oneshot;
use tonic::Status;

use super::{Host, Next};
use crate::letter::{Activity, Order, ReplayReport, Report};
use crate::observers::View;
use crate::pace::Pace;
use crate::recording::SharedTape;

/// A replay that is under way. Its world always stands within a tick, its sensors read.
pub(super) struct Replaying {
    replay: Replay,
    seek: Option<Seek>,
    /// Why it cannot go on.
    problem: Option<String>,
}

/// A tick is looked for.
struct Seek {
    tick: u64,
    /// The world has jumped on its way there.
    jumped: bool,
    reply: oneshot::Sender<Result<Report, Status>>,
}

impl Replaying {
    pub(super) fn new(replay: Replay) -> Self {
        Self { replay, seek: None, problem: None }
    }

    pub(super) fn report(&self) -> ReplayReport {
        let tape = self.replay.tape();
        let differs = self.replay.difference().map(ToString::to_string);
        ReplayReport {
            first_tick: tape.first_tick(),
            last_tick: tape.last_tick(),
            differs: self.problem.clone().or(differs),
        }
    }
}

impl Host {
    /// What is being replayed, if anything is.
    pub(super) fn tape(&self) -> Option<SharedTape> {
        self.replaying.as_ref().map(|replaying| SharedTape::clone(replaying.replay.tape()))
    }

    /// Whether what is asked can be asked of a world of this kind.
    pub(super) fn check_order(&self, order: &Order) -> Result<(), Status> {
        match order {
            Order::Reset => self.check_live("a reset"),
            Order::Snapshot | Order::Restore { .. } => self.check_live("a snapshot"),
            Order::Intervene(_) => self.check_live("a change by hand"),
            Order::DetachBrain { .. } => self.check_live("a brain"),
            Order::Record(_) | Order::StopRecording(_) => self.check_live("a recording"),
            Order::Seek { .. } | Order::Fork(_) if self.replaying.is_none() => {
                let text = format!("world: `{}` is live, it replays nothing", self.name);
                Err(Status::failed_precondition(text))
            }
            _ => Ok(()),
        }
    }

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
        let stands = matches!(self.pace, Pace::Stepped(_)) && self.credits == 0;
        if self.world.ending().is_some() && replaying.seek.is_none() {
            Activity::Ended
        } else if self.paused || stands || self.is_replay_over(replaying) {
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
        match &self.clock {
            Some(clock) => {
                let due = clock.instant(self.tick_end());
                if now >= due { Next::Replay } else { Next::Wait(Some(due)) }
            }
            None => Next::Replay,
        }
    }

    /// Does a tick, or goes on looking for one.
    pub(super) fn replay(&mut self, now: Instant) {
        let Some(mut replaying) = self.replaying.take() else { return };
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
                self.observers.begin_anew(&self.world);
            }
            let view = View {
                name: &self.name,
                world: &self.world,
                sessions: &self.sessions,
                beliefs: &self.beliefs,
            };
            self.observers.show_now(view);
            drop(seek.reply.send(Ok(self.report(0))));
        }
        if is_over || self.credits == 0 {
            self.credits = 0;
            self.answer_stepper();
        }
    }

    fn replay_tick(&mut self, replay: &mut Replay, now: Instant) -> Result<(), RecordingError> {
        match (self.pace, &self.clock) {
            (Pace::Timed(_), None) => {
                self.follow_clock(now);
                return Ok(());
            }
            (_, Some(clock)) => {
                let late = now.saturating_duration_since(clock.instant(self.tick_end()));
                let step = clock.instant(self.tick_end()) - clock.instant(self.world.time());
                self.pacing.note_lateness(late, step);
            }
            (_, None) => {}
        }
        let tick = self.world.tick();
        let goes_on = replay.step(&mut self.world)?;
        if goes_on && self.world.tick() != tick + 1 {
            // Something is missing in the recording. Nobody waits for as long as that took.
            self.clock = None;
            self.observers.begin_anew(&self.world);
        }
        self.spend_credit();
        self.show();
        self.follow_clock(now);
        Ok(())
    }

    /// Some way towards a tick; there may be letters meanwhile.
    fn approach(&mut self, replay: &mut Replay, tick: u64, now: Instant) -> Result<(), RecordingError> {
        while self.world.tick() < tick && now.elapsed() < AT_ONCE && replay.step(&mut self.world)? {}
        Ok(())
    }

    pub(super) fn seek(&mut self, tick: u64, reply: oneshot::Sender<Result<Report, Status>>) {
        let report = self.report(0);
        let Some(replaying) = &mut self.replaying else { return };
        let former = replaying.seek.take();
        let had_jumped = former.as_ref().is_some_and(|former| former.jumped);
        if let Some(former) = former {
            // Somebody has thought of another tick.
            drop(former.reply.send(Ok(report)));
        }
        self.clock = None;
        let tape = replaying.replay.tape();
        let tick = tape.nearest(tick);
        match replaying.replay.approach(&mut self.world, tick) {
            Ok(jumped) => {
                replaying.seek = Some(Seek { tick, jumped: jumped || had_jumped, reply });
            }
            Err(error) => drop(reply.send(Err(Status::data_loss(format!("the recording {error}"))))),
        }
    }

    /// From here on the world is live. It stands within its tick, which its brains get as soon as they are there.
    pub(super) fn fork(&mut self, pace: Pace) {
        let seek = self.replaying.take().and_then(|replaying| replaying.seek);
        if let Some(Seek { reply, .. }) = seek {
            self.observers.begin_anew(&self.world);
            drop(reply.send(Ok(self.report(0))));
        }
        self.paused = true;
        self.clock = None;
        self.begun = false;
        self.pace = pace;
        self.credits = 0;
        self.senders = super::senders(&self.world);
        self.answer_stepper();
        self.waiting_since = Instant::now();
    }
}

/// So long nobody's letters are opened while a tick is looked for.
const AT_ONCE: Duration = Duration::from_millis(20);
