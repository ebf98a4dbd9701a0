//! A world and what is done about it, one thing at a time: letters are opened, a tick begins, a tick ends.
//!
//! Who does that is [`Room`](crate::room::Room)'s to know. This file is the loop; what operators order is in [`orders`].

mod orders;
mod stopwatch;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use baudbot_sim::{Input, RobotView, SimTime, World};
use tokio::sync::{OwnedSemaphorePermit, oneshot};
use tonic::Status;

use crate::endpoint::{Sender, Thinking, Write};
use crate::letter::{Activity, Attach, Attached, Lease, Letter, Report};
use crate::observers::Observers;
use crate::pace::{Clock, Pace, Pacing, WatchdogPolicy};
use crate::sessions::{Answer, Sessions};
use stopwatch::Stopwatch;

/// Called at the start of every tick, when the sensors have been read, on the world's own thread.
pub type OnTick = Box<dyn FnMut(&World) + Send>;

/// A world and all that happens to it.
pub(crate) struct Host {
    name: Arc<str>,
    world: World,
    sessions: Sessions,
    observers: Observers,
    on_tick: Option<OnTick>,
    pace: Pace,
    pacing: Pacing,
    paused: bool,
    /// Ticks still to do in the stepped pace, and who waits for them.
    credits: u64,
    steppers: Vec<oneshot::Sender<Result<Report, Status>>>,
    /// Between `begin` and `finish`.
    begun: bool,
    /// Set while simulated time follows the wall clock.
    clock: Option<Clock>,
    /// Since when the world waits for brains, in lockstep.
    waiting_since: Instant,
    running: Stopwatch,
    inputs: Vec<Pending>,
    /// Given back at the end of the tick: they bound how much one stream can have in a tick.
    permits: Vec<OwnedSemaphorePermit>,
    /// Each robot's, where the server encodes for its brain. What they hold is on the wire, so they go back in
    /// time with the world.
    senders: Vec<Sender>,
    /// As they were when the tick began, which is where a snapshot goes back to.
    senders_at_begin: Vec<Sender>,
    snapshots: VecDeque<Snapshot>,
    last_snapshot: u64,
    deleted: bool,
    /// How long a tick takes, lately; `None` before the first.
    tick_takes: Option<Duration>,
    tick_took: Duration,
    /// When the world's thread wakes by itself.
    alarm: Option<Instant>,
}

/// What is to be done about a world after a visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Then {
    /// There is more to do, and the world's thread should do it.
    Thread,
    /// Nothing before a letter comes, or before this instant.
    Wait(Option<Instant>),
    /// It is over.
    Over,
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
    Watchdog,
    Wait(Option<Instant>),
}

impl Host {
    pub(crate) fn new(
        name: Arc<str>,
        world: World,
        pace: Pace,
        paused: bool,
        on_tick: Option<OnTick>,
    ) -> Self {
        let senders: Vec<_> = world.robots().map(|robot| sender(&robot)).collect();
        Self {
            name,
            sessions: Sessions::new(senders.len()),
            observers: Observers::default(),
            world,
            on_tick,
            pace,
            pacing: Pacing::default(),
            paused,
            credits: 0,
            steppers: Vec::new(),
            begun: false,
            clock: None,
            waiting_since: Instant::now(),
            running: Stopwatch::default(),
            inputs: Vec::new(),
            permits: Vec::new(),
            senders_at_begin: senders.clone(),
            senders,
            snapshots: VecDeque::new(),
            last_snapshot: 0,
            deleted: false,
            tick_takes: None,
            tick_took: Duration::ZERO,
            alarm: None,
        }
    }

    /// The world's thread does one thing.
    pub(crate) fn work(&mut self, letters: impl FnMut() -> Option<Letter>) -> Then {
        self.open_all(letters);
        if self.deleted {
            self.sessions.close_all(&Status::aborted(format!("world `{}` was deleted", self.name)));
            return Then::Over;
        }
        let now = Instant::now();
        self.running.set(self.activity() == Activity::Running, now);
        match self.next(now) {
            Next::Begin => self.begin(now),
            Next::Finish => self.finish(now),
            Next::Watchdog => self.bite(),
            Next::Wait(until) => {
                self.alarm = until;
                return Then::Wait(until);
            }
        }
        Then::Thread
    }

    /// Somebody with letters does what does not take long, so that the world's thread need not be woken.
    pub(crate) fn visit(&mut self, mut letters: impl FnMut() -> Option<Letter>) -> Then {
        let mut patience = MAX_TICKS_A_VISIT;
        loop {
            self.open_all(&mut letters);
            let now = Instant::now();
            if self.deleted {
                return Then::Thread;
            }
            self.running.set(self.activity() == Activity::Running, now);
            let next = self.next(now);
            match next {
                // The thread sleeps, and not too long.
                Next::Wait(None) => return Then::Wait(None),
                Next::Wait(Some(until)) if self.alarm.is_some_and(|alarm| alarm <= until) => {
                    return Then::Wait(Some(until));
                }
                Next::Begin if self.is_quick() && patience > 0 => {
                    patience -= 1;
                    self.begin(now);
                }
                Next::Finish if self.is_quick() => self.finish(now),
                Next::Begin | Next::Finish | Next::Watchdog | Next::Wait(Some(_)) => return Then::Thread,
            }
        }
    }

    /// Whether a tick takes less than to wake a thread for it. Who looks at the world may take any time.
    fn is_quick(&self) -> bool {
        let waits = self.pace.watchdog().is_some();
        waits && self.on_tick.is_none() && self.tick_takes.is_some_and(|takes| takes < QUICK)
    }

    /// Opens letters, but not so many that a flood of them would hold up the clock.
    fn open_all(&mut self, mut letters: impl FnMut() -> Option<Letter>) {
        for _ in 0..MAX_LETTERS_AT_ONCE {
            let Some(letter) = letters() else { break };
            self.open(letter);
        }
    }

    fn next(&self, now: Instant) -> Next {
        if !self.begun {
            let go = self.activity() == Activity::Running;
            return if go { Next::Begin } else { Next::Wait(None) };
        }
        if let Some(watchdog) = self.pace.watchdog() {
            if self.sessions.has_unanswered_empty_seat() {
                return Next::Wait(None);
            }
            let deadline = self.waiting_since + watchdog.timeout;
            return match self.sessions.owing().next() {
                None => Next::Finish,
                Some(_) if now >= deadline => Next::Watchdog,
                Some(_) => Next::Wait(Some(deadline)),
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
        if let (Pace::Timed { factor }, None) = (self.pace, &self.clock) {
            self.clock = Some(Clock::new(now, self.world.time(), factor));
        }
        let lockstep = self.pace.watchdog().is_some();
        let turns = self.world.begin().to_vec();
        self.show();
        self.sessions.deliver(&self.world, &turns, lockstep);
        self.senders_at_begin.clone_from(&self.senders);
        self.begun = true;
        self.waiting_since = Instant::now();
        self.tick_took = self.waiting_since - now;
    }

    /// The world at the start of a tick, for those who look.
    fn show(&mut self) {
        if let Some(on_tick) = &mut self.on_tick {
            on_tick(&self.world);
        }
        self.observers.show(&self.world);
    }

    fn finish(&mut self, now: Instant) {
        if let Some(clock) = &self.clock {
            let late = now.saturating_duration_since(clock.instant(self.tick_end()));
            let step = clock.instant(self.tick_end()) - clock.instant(self.world.time());
            self.pacing.note_lateness(late, step);
        } else if self.pace.watchdog().is_some() {
            self.pacing.waiting += now.saturating_duration_since(self.waiting_since);
        }
        for pending in &self.inputs {
            if let Some(tick) = pending.tick {
                self.world.answers(pending.robot, tick);
            }
        }
        let inputs: Vec<Input<'_>> =
            self.inputs.iter().map(|p| Input { robot: p.robot, at: p.at, bytes: &p.bytes }).collect();
        self.world.finish(&inputs);
        self.inputs.clear();
        self.permits.clear();
        self.begun = false;
        self.credits = self.credits.saturating_sub(1);
        if self.world.ending().is_some() {
            self.end();
        }
        if self.credits == 0 {
            self.answer_steppers();
        }
        self.note_duration(self.tick_took + now.elapsed());
    }

    /// A tick took so long, without the wait for brains.
    fn note_duration(&mut self, took: Duration) {
        self.tick_takes = Some(self.tick_takes.map_or(took, |takes| (takes * 7 + took) / 8));
    }

    /// The run is over: the sensors are read a last time, and everybody is told.
    fn end(&mut self) {
        self.credits = 0;
        self.clock = None;
        self.world.begin();
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
            tracing::warn!(world = %self.name, session = number, ?timeout, policy = ?watchdog.policy,
                "a brain has not answered in time");
            match watchdog.policy {
                WatchdogPolicy::Wait => {}
                WatchdogPolicy::GoOn => self.sessions.mark_late(number),
                WatchdogPolicy::Detach => {
                    let status = Status::deadline_exceeded(format!("no answer to a Turn within {timeout:?}"));
                    self.sessions.close(number, Some(watchdog.policy), status);
                }
            }
        }
    }

    fn open(&mut self, letter: Letter) {
        match letter {
            Letter::Order(order, reply) => self.obey(order, reply),
            Letter::Describe(reply) => drop(reply.send(Arc::clone(self.world.scenario()))),
            Letter::Watch { every_ticks, frames } => self.observers.add(every_ticks, frames, &self.world),
            Letter::Attach(request, reply) => self.attach(request, reply),
            Letter::Step { session, turn, writes, permit } => self.take_step(session, turn, writes, permit),
            Letter::End => self.deleted = true,
            Letter::Detach { session } => self.sessions.detach(session, self.policy()),
        }
    }

    fn attach(&mut self, request: Attach, reply: oneshot::Sender<Result<Attached, Status>>) {
        let scenario = Arc::clone(self.world.scenario());
        let world = request.world.clone();
        let (session, robots) = match self.sessions.attach(&self.name, &scenario, request) {
            Ok(attached) => attached,
            Err(status) => return drop(reply.send(Err(status))),
        };
        for &robot in &robots {
            self.senders[robot] = sender(&self.world.robot(robot));
        }
        let lockstep = self.pace.watchdog().is_some();
        let lease = Lease { world, session };
        // If nobody waits for the answer any more, the lease is dropped, and a letter says so.
        if reply.send(Ok(Attached { lease, scenario, robots, lockstep })).is_err() {
            return;
        }
        if self.world.ending().is_some() {
            self.sessions.tell_one_ended(session, self.world.tick());
        } else if lockstep && self.begun {
            self.sessions.deliver_unanswered(session, &self.world);
        }
    }

    fn policy(&self) -> Option<WatchdogPolicy> {
        self.pace.watchdog().map(|watchdog| watchdog.policy)
    }

    fn take_step(&mut self, session: u64, turn: u64, writes: Vec<Write>, permit: OwnedSemaphorePermit) {
        let answer = self.sessions.answered(session, turn);
        match (answer, self.pace.watchdog()) {
            (Answer::Void, _) => return,
            (Answer::Unasked, Some(_)) => {
                let text = format!(
                    "step.turn: Turn {turn} is not the one to answer; in lockstep each Turn takes exactly one Step"
                );
                self.sessions.close(session, self.policy(), Status::failed_precondition(text));
                return;
            }
            (Answer::Due, _) | (Answer::Unasked, None) => {}
        }
        let tick = self.sessions.tick_of(session, turn);
        for write in writes {
            let Some(robot) = self.sessions.robot(session, write.slot) else { continue };
            let at = self.written_at(robot, write.thinking);
            let spec = &self.world.scenario().robots()[robot];
            let bytes = self.senders[robot].encode(spec, write.output);
            self.inputs.push(Pending { robot, at, bytes, tick });
        }
        self.permits.push(permit);
    }

    /// When the bytes of a step are handed to the port: the instant of the brain's step plus its thinking
    /// time where the world waits, and not before they came where time follows the wall clock.
    fn written_at(&self, robot: usize, thinking: Thinking) -> SimTime {
        let turn = self.world.turns().iter().find(|turn| turn.robot == robot);
        let step = turn.map_or_else(|| self.world.time(), |turn| turn.at);
        match &self.clock {
            // A world that lags its clock takes what comes now as coming within this tick.
            Some(clock) => clock.time(Instant::now()).min(self.tick_end()).max(step),
            None => step + thinking.on(self.world.robot(robot).spec()),
        }
    }

    fn tick_end(&self) -> SimTime {
        self.world.time() + self.world.scenario().step_ns()
    }
}

/// A robot's port as a brain finds it: the actuators do what they do.
fn sender(robot: &RobotView<'_>) -> Sender {
    Sender::new(robot.actuators().iter().map(|actuator| actuator.signal))
}

const MAX_LETTERS_AT_ONCE: usize = 100;

/// Ticks that a visitor does before the world's thread takes over; other connections wait for a visitor.
const MAX_TICKS_A_VISIT: usize = 16;

/// A tick that takes less is done by visitors.
const QUICK: Duration = Duration::from_micros(200);
