//! A world and what is done about it, one thing at a time: letters are opened, a tick begins, a tick ends.
//!
//! Who does that is [`Room`](crate::room::Room)'s to know. This file is the loop; what operators order is in [`orders`].

mod ahead;
mod last_word;
mod letters;
mod log;
mod measures;
mod orders;
mod record;
mod replay;
mod rounds;
mod stopwatch;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::time::{Duration, Instant};

use baudbot_sim::{Input, Intervention, RobotView, SimTime, Turn, World};
use tokio::sync::oneshot;
use tonic::Status;

use crate::beliefs::Beliefs;
use crate::endpoint::Sender;
use crate::letter::{Activity, Letter, Report};
use crate::log::event;
use crate::observers::{Observers, View};
use crate::pace::{Clock, Pace, Pacing, Timed, WatchdogPolicy};
use crate::recording::Recorder;
use crate::registry::NewWorld;
use crate::seldom::Seldom;
use crate::sessions::Sessions;
use last_word::LastWord;
use replay::Replaying;
pub(crate) use rounds::Then;
use stopwatch::Stopwatch;

/// Called at the start of every tick, when the sensors have been read, on the world's own thread.
pub type OnTick = Box<dyn FnMut(&World) + Send>;

/// A world and all that happens to it.
pub(crate) struct Host {
    name: Arc<str>,
    world: World,
    sessions: Sessions,
    observers: Observers,
    beliefs: Beliefs,
    /// Changes by hand that wait for the end of the tick, each with who waits for it.
    interventions: Vec<(Intervention, oneshot::Sender<Result<Report, Status>>)>,
    on_tick: Option<OnTick>,
    pace: Pace,
    pacing: Pacing,
    paused: bool,
    /// Ticks still to do in the stepped pace, and who waits for them.
    credits: u64,
    stepper: Option<oneshot::Sender<Result<Report, Status>>>,
    /// Between `begin` and `finish`.
    begun: bool,
    /// Set while simulated time follows the wall clock.
    clock: Option<Clock>,
    lagging: Seldom,
    /// Since when the world waits for brains, in lockstep.
    waiting_since: Instant,
    running: Stopwatch,
    inputs: Vec<Pending>,
    /// Each robot's, where the server encodes for its brain. What they hold is on the wire, so they go back in
    /// time with the world.
    senders: Vec<Sender>,
    /// As they were when the tick began, which is where a snapshot goes back to.
    senders_at_begin: Vec<Sender>,
    /// Of each robot, what is written when its brain is gone, if its brain wants that.
    last_words: Vec<Option<LastWord>>,
    snapshots: VecDeque<Snapshot>,
    last_snapshot: u64,
    /// What its brains are told at its end, once that has come.
    over: Option<Status>,
    /// How long a tick takes, lately; `None` before the first.
    tick_takes: Option<Duration>,
    tick_took: Duration,
    /// Worlds on this server.
    neighbours: Arc<AtomicU32>,
    /// When the world's thread wakes by itself.
    alarm: Option<Instant>,
    /// Letters of those who want to see the world, which is ahead of its brains.
    held: VecDeque<Letter>,
    /// The run is over, and nobody has been told, as brains have yet to answer.
    ending: bool,
    recorder: Option<Recorder>,
    /// A letter that a visitor left to the world's own thread, since what it asks for takes long.
    heavy: Option<Letter>,
    /// Of each robot, the tick in which its brain last was left behind.
    behind_since: Vec<u64>,
    /// Of a world that does a recording again.
    replaying: Option<Replaying>,
}

/// A state that is kept.
struct Snapshot {
    number: u64,
    world: World,
    senders: Vec<Sender>,
}

/// What a brain wrote in this tick.
struct Pending {
    robot: usize,
    at: SimTime,
    bytes: Vec<u8>,
    /// The tick whose Turn it answers, if that is known.
    tick: Option<u64>,
}

/// What the world does next.
enum Next {
    Begin,
    Finish,
    /// Finish without the answers that are owed; at the latest at this instant there is something else to do.
    FinishAhead(Instant),
    End,
    Watchdog,
    /// A tick of a replay, or a bit of the way to one.
    Replay,
    Wait(Option<Instant>),
}

impl Host {
    pub(crate) fn new(
        name: Arc<str>,
        NewWorld { world, replay, pace, paused, on_tick, .. }: NewWorld,
        neighbours: Arc<AtomicU32>,
    ) -> Self {
        let senders = senders(&world);
        Self {
            recorder: None,
            heavy: None,
            behind_since: vec![0; senders.len()],
            last_words: vec![None; senders.len()],
            replaying: replay.map(Replaying::new),
            sessions: Sessions::new(senders.len()),
            observers: Observers::default(),
            name,
            beliefs: Beliefs::new(senders.len()),
            interventions: Vec::new(),
            world,
            on_tick,
            pace,
            pacing: Pacing::default(),
            paused,
            credits: 0,
            stepper: None,
            begun: false,
            clock: None,
            lagging: Seldom::default(),
            waiting_since: Instant::now(),
            running: Stopwatch::default(),
            inputs: Vec::new(),
            senders_at_begin: senders.clone(),
            senders,
            snapshots: VecDeque::new(),
            last_snapshot: 0,
            over: None,
            tick_takes: None,
            tick_took: Duration::ZERO,
            neighbours,
            alarm: None,
            held: VecDeque::new(),
            ending: false,
        }
    }

    fn next(&self, now: Instant) -> Next {
        if let Some(replaying) = &self.replaying {
            return self.next_of_replay(replaying, now);
        }
        if self.ending {
            return if self.sessions.is_behind() { self.wait_for_answers(now) } else { Next::End };
        }
        if !self.begun {
            let go = self.activity() == Activity::Running;
            if self.sessions.is_behind() && !(go && self.can_begin_ahead()) {
                return self.wait_for_answers(now);
            }
            return if go { Next::Begin } else { Next::Wait(None) };
        }
        if self.pace.watchdog().is_some() {
            if self.sessions.has_unanswered_empty_seat() {
                return Next::Wait(None);
            }
            if self.sessions.owing().next().is_none() {
                return Next::Finish;
            }
            return match self.wait_for_answers(now) {
                Next::Wait(Some(until)) if self.can_finish_ahead() => Next::FinishAhead(until),
                next => next,
            };
        }
        match &self.clock {
            Some(clock) => {
                let due = clock.instant(self.tick_end());
                if now >= due { Next::Finish } else { Next::Wait(Some(due)) }
            }
            None => Next::Finish,
        }
    }

    fn activity(&self) -> Activity {
        if let Some(replaying) = &self.replaying {
            return self.activity_of_replay(replaying);
        }
        let lockstep = self.pace.watchdog().is_some();
        if self.world.ending().is_some() {
            Activity::Ended
        } else if self.paused || (matches!(self.pace, Pace::Stepped(_)) && self.credits == 0) {
            Activity::Paused
        } else if lockstep && self.is_held_up() {
            Activity::WaitingForBrains
        } else {
            Activity::Running
        }
    }

    /// In lockstep, a robot without a brain holds the world up.
    fn is_held_up(&self) -> bool {
        let sessions = &self.sessions;
        if self.begun { sessions.has_unanswered_empty_seat() } else { sessions.has_awaited_empty_seat() }
    }

    fn begin(&mut self, now: Instant) {
        self.follow_clock(now);
        let lockstep = self.pace.lockstep();
        let mut turns = self.world.begin().to_vec();
        self.record_begun();
        self.show();
        if lockstep.is_some_and(|lockstep| lockstep.lookahead) {
            turns.retain(|&turn| !self.lets_sleep(turn));
        }
        self.sessions.deliver(&self.world, &turns, lockstep.map(|_| now));
        self.senders_at_begin.clone_from(&self.senders);
        self.begun = true;
        self.stop_silent(now);
        let begun = Instant::now();
        if !self.sessions.is_behind() {
            self.waiting_since = begun;
        }
        self.tick_took = begun - now;
    }

    /// A tick is to begin: where time follows the wall clock, what the world lags beyond what it may is let go.
    fn follow_clock(&mut self, now: Instant) {
        let Pace::Timed(Timed { factor, max_lag }) = self.pace else { return };
        let clock = self.clock.get_or_insert_with(|| Clock::new(now, self.world.time(), factor));
        let Some(beyond) = clock.let_go(now, self.world.time(), max_lag) else { return };
        self.pacing.let_go += beyond;
        self.pacing.times_let_go += 1;
        if let Some(times) = self.lagging.note(now) {
            let (let_go_s, sum_s) = (beyond.as_secs_f64(), self.pacing.let_go.as_secs_f64());
            event!(self, warn, times, let_go_s, sum_s, "the world lags, and lets time go");
        }
    }

    /// A brain that waits for what has not come is not asked. Its step counts as one in which it wrote nothing.
    fn lets_sleep(&mut self, turn: Turn) -> bool {
        let sleeps = self.sessions.sleeps(turn, &self.world);
        if sleeps {
            let thinking_ns = self.world.scenario().robots()[turn.robot].thinking_ns;
            let at = turn.at + thinking_ns;
            self.inputs.push(Pending { robot: turn.robot, at, bytes: Vec::new(), tick: None });
        }
        sleeps
    }

    /// The world at the start of a tick, for those who look.
    fn show(&mut self) {
        if let Some(on_tick) = &mut self.on_tick {
            on_tick(&self.world);
        }
        let view =
            View { name: &self.name, world: &self.world, sessions: &self.sessions, beliefs: &self.beliefs };
        self.observers.show(view);
    }

    /// Ends the tick, without the answers of some robots, each with when its brain is done.
    fn finish_with(&mut self, now: Instant, open: &[(usize, SimTime)]) {
        if let Some(clock) = &self.clock {
            let late = now.saturating_duration_since(clock.instant(self.tick_end()));
            let step = clock.instant(self.tick_end()) - clock.instant(self.world.time());
            self.pacing.note_lateness(late, step);
        } else if self.pace.watchdog().is_some() && !self.sessions.is_behind() {
            self.pacing.waiting += now.saturating_duration_since(self.waiting_since);
        }
        for pending in &self.inputs {
            if let Some(tick) = pending.tick {
                self.world.answers(pending.robot, tick);
            }
        }
        let inputs: Vec<Input<'_>> =
            self.inputs.iter().map(|p| Input { robot: p.robot, at: p.at, bytes: &p.bytes }).collect();
        let began = (self.world.tick(), self.world.time());
        self.world.finish_ahead(&inputs, open);
        self.record_inputs(began, open);
        self.inputs.clear();
        self.sessions.forget_steps();
        self.begun = false;
        self.spend_credit();
        self.ending = self.world.ending().is_some();
        if self.ending && !self.sessions.is_behind() {
            self.end();
        }
        self.intervene();
        if self.credits == 0 {
            self.answer_stepper();
        }
        self.note_duration(self.tick_took + now.elapsed());
    }

    /// A tick took so long, without the wait for brains.
    fn note_duration(&mut self, took: Duration) {
        self.tick_takes = Some(self.tick_takes.map_or(took, |takes| (takes * 7 + took) / 8));
    }

    /// The run is over: the sensors are read a last time, and everybody is told.
    fn end(&mut self) {
        self.ending = false;
        self.credits = 0;
        self.clock = None;
        let why = self.world.ending().map(ToString::to_string).unwrap_or_default();
        event!(self, info, why, "run ended");
        self.world.begin();
        self.record_begun();
        self.show();
        self.sessions.tell_ended(self.world.tick());
    }

    /// The watchdog acts on every brain that has not answered.
    fn bite(&mut self) {
        let Some(watchdog) = self.pace.watchdog() else { return };
        let timeout = watchdog.timeout;
        self.pacing.waiting += self.waiting_since.elapsed();
        self.waiting_since = Instant::now();
        for number in self.sessions.owing().collect::<Vec<_>>() {
            self.pacing.watchdog_timeouts += 1;
            event!(self, warn, session = number, brain = self.sessions.name(number),
                timeout_s = timeout.as_secs_f64(), policy = ?watchdog.policy, "brain has not answered in time");
            match watchdog.policy {
                WatchdogPolicy::Wait => {}
                WatchdogPolicy::GoOn => {
                    self.sessions.mark_late(number);
                    self.give_up(number);
                    self.deliver_held(number);
                }
                WatchdogPolicy::Detach => {
                    let status = Status::deadline_exceeded(format!("no answer to a Turn within {timeout:?}"));
                    self.close(number, status);
                }
            }
        }
        self.open_held_at_last();
    }

    /// Ends a brain program's stream.
    fn close(&mut self, session: u64, status: Status) {
        self.log_detached(session, status.message());
        self.record_gone(session, status.message());
        self.beliefs.hand_to(None, self.sessions.robots(session));
        self.give_up(session);
        self.stop_robots_of(session);
        self.sessions.close(session, self.policy(), status);
    }

    /// The world is over. Brains that it has not told learn it: a panic has ended it.
    pub(crate) fn abandon(&mut self) {
        let text = format!("world `{}` has ended by a panic; the server's log says more", self.name);
        self.sessions.close_all(&Status::internal(text));
    }

    fn tick_end(&self) -> SimTime {
        self.world.time() + self.world.scenario().step_ns()
    }
}

/// All robots' ports.
fn senders(world: &World) -> Vec<Sender> {
    world.robots().map(|robot| sender(&robot)).collect()
}

/// A robot's port as a brain finds it: the actuators do what they do.
fn sender(robot: &RobotView<'_>) -> Sender {
    Sender::new(robot.actuators().iter().map(|actuator| actuator.signal))
}
