//! The actor of a world: it alone touches the world, and does one thing at a time. It handles messages, begins a tick,
//! finishes a tick, or waits.
//!
//! The [`Mailbox`](crate::mailbox::Mailbox) decides on which thread that happens. This file is the loop:
//! [`WorldActor::next`] decides what is to be done, and the other methods do it.

mod attachments;
mod direct;
mod final_command;
mod halting;
mod interventions;
mod log;
mod lookahead;
mod measure;
mod messages;
mod new_world;
mod pacer;
mod ports;
mod progress;
mod recording;
mod replay;
mod requests;
mod runner;
mod snapshots;
mod state;
mod stepping;
mod stopwatch;
#[cfg(test)]
mod tests;
mod timeline;
mod watchdog;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::time::Instant;

use baudbot_sim::{Answer, SimTime, Turn, World};
use tonic::Status;

use crate::beliefs::Beliefs;
use crate::cables::Cables;
use crate::clock;
use crate::endpoint::Sent;
use crate::limits::Charges;
use crate::log::event;
use crate::message::Message;
use crate::observers::Observers;
use crate::report::Activity;
use crate::sessions::Sessions;
pub use direct::DirectWorld;
use halting::Halts;
use interventions::Interventions;
pub(crate) use new_world::{NewWorld, start};
pub use new_world::{OnBelief, OnTick};
use pacer::Pacer;
use ports::{Pending, Ports, ToDevice};
pub use progress::Progress;
use progress::Telling;
use recording::Recording;
use replay::Replaying;
use runner::Schedule;
use snapshots::Snapshots;
use state::State;
use stepping::Stepper;

/// A world and all that happens to it.
pub(crate) struct WorldActor {
    name: Arc<str>,
    world: World,
    phase: Phase,
    sessions: Sessions,
    observers: Observers,
    cables: Cables,
    beliefs: Beliefs,
    ports: Ports,
    pacer: Pacer,
    stepper: Stepper,
    interventions: Interventions,
    snapshots: Snapshots,
    recording: Recording,
    state: State,
    /// Snapshots that have outlived a server, until they are known to be kept.
    resumed_snapshots: Vec<(u64, Vec<u8>)>,
    /// `None` in a live world.
    replaying: Option<Replaying>,
    on_tick: Option<OnTick>,
    /// The function for beliefs, and the number of the last belief that it was given.
    on_belief: Option<(OnBelief, u64)>,
    progress: Option<Telling>,
    /// The callers that have made the world stand, and get an answer when it does.
    halts: Halts,
    /// Messages that would see the world, which is ahead of its brains; oldest first.
    deferred: VecDeque<Message>,
    schedule: Schedule,
    /// The status with which streams end, once the world is to be over.
    over: Option<Status>,
    /// The charges on the server's memory.
    charges: Charges,
    /// The counter of ticks, and of messages that change the status for operators.
    changes: u64,
}

/// The phase of a live world between the two halves of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// The world is between two ticks.
    Between,
    /// Within a tick: it has begun and brains may answer.
    Begun,
    /// The world is between two ticks; the run is over, which is reported when all brains have answered.
    Ending,
}

/// The next act of the world.
enum Next {
    Begin,
    Finish,
    /// Finish without the answers that are owed; at the latest at this instant there is something else to do.
    FinishAhead(Instant),
    End,
    /// The watchdog acts on brains that do not answer.
    TimeOut,
    /// A tick of a replay, or a part of the way to one.
    Replay,
    /// The world waits for a message, or for this instant.
    Wait(Option<Instant>),
}

/// The view of an actor for observers: a macro, so that its other fields can be borrowed meanwhile.
macro_rules! view {
    ($actor:expr) => {
        crate::observers::View {
            name: &$actor.name,
            world: &$actor.world,
            sessions: &$actor.sessions,
            beliefs: &$actor.beliefs,
        }
    };
}
use view;

impl WorldActor {
    fn new(
        name: Arc<str>,
        NewWorld { world, replay, pace, paused, on_tick, on_belief, progress, processor, state, .. }: NewWorld,
        charges: Charges,
        neighbours: Arc<AtomicU32>,
    ) -> Self {
        let robots = world.robots().len();
        let mut actor = Self {
            name,
            phase: Phase::Between,
            sessions: Sessions::new(&world.scenario().robots),
            observers: Observers::default(),
            cables: Cables::default(),
            beliefs: Beliefs::new(robots),
            ports: Ports::new(&world),
            pacer: Pacer::new(pace, paused),
            stepper: Stepper::default(),
            interventions: Interventions::default(),
            snapshots: Snapshots::default(),
            recording: Recording::new(robots),
            state: State::new(state, Arc::clone(world.origin())),
            resumed_snapshots: Vec::new(),
            replaying: replay.map(Replaying::new),
            on_tick,
            on_belief: on_belief.map(|on_belief| (on_belief, 0)),
            progress: progress.map(Telling::new),
            halts: Halts::default(),
            deferred: VecDeque::new(),
            schedule: Schedule::new(neighbours),
            over: None,
            charges,
            changes: 0,
            world,
        };
        actor.sessions.time_by(processor);
        actor.fit_timeline();
        actor
    }

    /// The next act, by the present state.
    ///
    /// The world is always in one of three phases, and in each there is one question. *Between* two ticks: may the next
    /// one begin? Not while the world is paused, waits for a brain that is not there, or has run as far ahead of its
    /// brains as lookahead allows. *Within* a tick: may it end? That is what paces differ in. Lockstep waits until no
    /// answer is owed; real time waits for an instant of the wall clock; free waits for nothing. *Ending*: has every
    /// brain answered that the world went ahead of? Only then is the end certain and may be reported, since a missing
    /// answer may still be in the recording.
    ///
    /// This reads the state and changes nothing, so that a caller can ask what there is to do and leave it to the
    /// pool (`runner`). Where an instant is given it is when the answer to the question changes without a message.
    fn next(&self, now: Instant) -> Next {
        if let Some(replaying) = &self.replaying {
            return self.next_of_replay(replaying, now);
        }
        match self.phase {
            Phase::Between => self.next_between_ticks(now),
            Phase::Begun => self.next_within_tick(now),
            Phase::Ending if self.sessions.is_any_overtaken() => self.wait_for_answers(now),
            Phase::Ending => Next::End,
        }
    }

    fn next_between_ticks(&self, now: Instant) -> Next {
        let is_running = self.activity() == Activity::Running;
        if self.sessions.is_any_overtaken() && !(is_running && self.can_begin_ahead()) {
            return self.wait_for_answers(now);
        }
        if is_running { Next::Begin } else { Next::Wait(None) }
    }

    fn next_within_tick(&self, now: Instant) -> Next {
        if self.pacer.pace.watchdog().is_none() {
            return match &self.pacer.clock {
                Some(clock) => {
                    let due = clock.instant(self.tick_end());
                    if now >= due { Next::Finish } else { Next::Wait(Some(due)) }
                }
                None => Next::Finish,
            };
        }
        if self.sessions.is_any_left_open() {
            return Next::Wait(None);
        }
        if self.sessions.owing().next().is_none() {
            return Next::Finish;
        }
        let next = self.wait_for_answers(now);
        if let Next::Wait(Some(until)) = next
            && self.can_finish_ahead()
        {
            return Next::FinishAhead(until);
        }
        next
    }

    fn activity(&self) -> Activity {
        if let Some(replaying) = &self.replaying {
            return self.activity_of_replay(replaying);
        }
        if self.world.ending().is_some() {
            Activity::Ended
        } else if self.pacer.paused || self.is_out_of_credit() {
            Activity::Paused
        } else if self.pacer.pace.watchdog().is_some() && self.is_held_up() {
            Activity::WaitingForBrains
        } else {
            Activity::Running
        }
    }

    /// Whether a robot without a brain holds a world in lockstep up.
    fn is_held_up(&self) -> bool {
        match self.phase {
            Phase::Begun => self.sessions.is_any_left_open(),
            Phase::Between | Phase::Ending => self.sessions.is_any_awaited(),
        }
    }

    fn begin(&mut self, now: Instant) {
        self.changes += 1;
        self.follow_clock(now);
        self.set_ports();
        let lockstep = self.pacer.pace.lockstep();
        self.show_start();
        let mut turns = self.world.begin().to_vec();
        self.record_tick();
        self.keep();
        self.show();
        if lockstep.is_some_and(|lockstep| lockstep.lookahead) {
            turns.retain(|&turn| !self.lets_sleep(turn));
        }
        self.sessions.deliver(&self.world, &turns, self.terms(now));
        self.ports.note_begin();
        self.phase = Phase::Begun;
        self.stop_silent_robots(now);
        let begun = clock::now();
        if !self.sessions.is_any_overtaken() {
            self.pacer.wait_from(begun);
        }
        self.schedule.note_begin(begun - now);
    }

    /// Whether a brain need not be asked, because it waits for a message and none has come. Its step then counts as one in
    /// which it wrote nothing.
    fn lets_sleep(&mut self, turn: Turn) -> bool {
        let sleeps = self.sessions.sleeps(turn, &self.world);
        if sleeps {
            let thinking_ns = self.world.scenario().robots[turn.robot].thinking_ns;
            let at = turn.at + thinking_ns;
            let sent = Sent::Bytes(Vec::new());
            self.ports.inputs.push(Pending { robot: turn.robot, at, sent, tick: None });
        }
        sleeps
    }

    /// Shows a tick that has begun to `on_tick`, and reports how far the world is.
    fn show(&mut self) {
        if let Some((on_belief, seen)) = &mut self.on_belief {
            for (robot, belief) in self.beliefs.since(seen) {
                on_belief(&self.world, robot, &belief);
            }
        }
        if let Some(on_tick) = &mut self.on_tick {
            on_tick(&self.world);
        }
        if let Some(progress) = &self.progress {
            progress.tell(&self.world);
        }
        self.observers.keep_pins(None, &mut self.world);
        self.cables.listen(&mut self.world);
    }

    /// The world is at another time: what observers and watchers of cables have seen is no past of it.
    fn forget_seen(&mut self) {
        self.observers.reset(&mut self.world);
        self.cables.reset(&mut self.world);
    }

    /// Ends the tick, without the answers of some robots, each with when its brain is done.
    fn finish_with(&mut self, now: Instant, open: &[(usize, SimTime)]) {
        self.changes += 1;
        self.note_end_of_tick(now);
        for pending in &self.ports.inputs {
            if let Some(tick) = pending.tick {
                self.world.answers(pending.robot, tick);
            }
        }
        let answer = |p| {
            let Pending { robot, at, sent, .. }: &Pending = p;
            Answer { robot: *robot, at: *at, written: sent.written() }
        };
        let answers: Vec<_> = self.ports.inputs.iter().map(answer).collect();
        for ToDevice { robot, sensor, at, bytes } in &self.ports.to_devices {
            self.world.write_port(*robot, *sensor, *at, bytes);
        }
        let began = (self.world.tick(), self.world.time());
        self.world.finish_ahead(&answers, open);
        self.record_inputs(began, open);
        if !self.cables.is_empty() {
            self.keep();
            self.cables.listen(&mut self.world);
        }
        self.ports.inputs.clear();
        self.ports.to_devices.clear();
        self.sessions.reset_quotas();
        self.spend_credit();
        self.charges.follow(&self.world);
        let is_ending = self.world.ending().is_some();
        self.phase = if is_ending { Phase::Ending } else { Phase::Between };
        if is_ending && !self.sessions.is_any_overtaken() {
            self.end();
        }
        self.intervene();
        if self.stepper.credits == 0 {
            self.answer_stepper();
        }
        self.answer_halts();
        self.schedule.note_finish(clock::since(now));
    }

    /// Ends the run: the sensors are read a last time, and all brains and observers get the end.
    fn end(&mut self) {
        self.changes += 1;
        self.phase = Phase::Between;
        self.stepper.credits = 0;
        self.pacer.clock = None;
        let why = self.world.ending().map(ToString::to_string).unwrap_or_default();
        event!(self, info, why, "run ended");
        self.show_start();
        self.world.begin();
        self.record_tick();
        self.keep_now();
        self.show();
        self.sessions.tell_ended(&self.world);
        self.answer_halts();
    }

    fn tick_end(&self) -> SimTime {
        self.world.time() + self.world.scenario().step_ns
    }
}
