//! Lookahead: a world in lockstep goes on while answers are under way that could not have reached their robots yet.
//!
//! # Need
//!
//! In lockstep each tick waits for the brains' answers, so that a run is as slow as its slowest brain and the network to
//! it. But an answer that is written now has to go down a cable, and a brain takes its time to think. Of most ticks it is
//! certain beforehand that no answer reaches its robot within them.
//!
//! # Assumptions
//!
//! [`World::finish_ahead`](baudbot_sim::World::finish_ahead) says why a tick may end without such an answer, and that
//! [`World::supply`](baudbot_sim::World::supply) hands it in later without a change of any bit. It needs to know when a
//! brain is done. Only a brain that has promised to think as long as the scenario states (`Hello.thinks_as_scenario`)
//! is therefore overtaken, and a Step that breaks the promise ends its stream ([`WorldActor::check_promise`]).
//!
//! # Mechanism
//!
//! - A brain that has not answered when its tick ends is *overtaken* (`sessions::debt`). It has at most one Turn to answer:
//!   its steps in the next tick are *deferred*, and delivered when it has answered.
//! - A world that is ahead of its brains must not be seen, as it lacks inputs. It does not go ahead while an observer or a
//!   recorder looks at each tick or its state is kept ([`WorldActor::is_unseen`]), and a message whose sender would see it ([`sees_world`]) is
//!   deferred until all brains have answered.
//! - If a brain does not answer, the watchdog's timeout ends the wait of those messages, too.

use std::time::Instant;

use baudbot_sim::{SimTime, Turn};
use tonic::Status;

use super::{Next, WorldActor};
use crate::clock;
use crate::endpoint::Write;
use crate::message::{Message, Request};
use crate::pace::Pace;
use crate::sessions::Overtaken;

impl WorldActor {
    /// Whether the world is unseen, so that it may go ahead of its brains.
    fn is_unseen(&self) -> bool {
        let looks_ahead = matches!(self.pacer.pace, Pace::Lockstep(lockstep) if lockstep.lookahead);
        let is_awaited = !self.deferred.is_empty() || !self.interventions.is_empty();
        let is_watched = self.on_tick.is_some()
            || !self.observers.is_empty()
            || !self.cables.is_empty()
            || self.recording.looks()
            // The Turns of one brain must not depend on another's answers that are still to come.
            || self.state.is_kept();
        looks_ahead && !is_watched && !is_awaited && !self.pacer.paused
    }

    /// Whether the tick can end without the answers that are missing.
    pub(super) fn can_finish_ahead(&self) -> bool {
        self.is_unseen() && self.sessions.can_be_overtaken(|turn| self.reaches_beyond_tick(turn))
    }

    /// Whether the next tick can begin without them.
    pub(super) fn can_begin_ahead(&self) -> bool {
        self.is_unseen() && self.sessions.overtaken().all(|turn| self.reaches_beyond_tick(turn))
    }

    /// Whether the answer to this Turn reaches its robot after the end of the tick.
    fn reaches_beyond_tick(&self, turn: &Turn) -> bool {
        self.world.reach(turn.robot, self.done_at(turn)).is_some_and(|reach| reach >= self.tick_end())
    }

    /// The instant at which a brain is done that has promised to think as long as the scenario states.
    fn done_at(&self, turn: &Turn) -> SimTime {
        turn.at + self.world.scenario().robots[turn.robot].thinking_ns
    }

    /// Ends the tick; the brains that have not answered are overtaken.
    pub(super) fn finish_ahead(&mut self, now: Instant) {
        let open: Vec<_> = self.sessions.overtake();
        let open: Vec<_> = open.iter().map(|turn| (turn.robot, self.done_at(turn))).collect();
        self.finish_with(now, &open);
    }

    /// The behaviour of a world that stands until brains have answered.
    pub(super) fn wait_for_answers(&self, now: Instant) -> Next {
        let Some(watchdog) = self.pacer.pace.watchdog() else { return Next::Wait(None) };
        let deadline = self.pacer.waiting_since + watchdog.timeout;
        if now >= deadline { Next::TimeOut } else { Next::Wait(Some(deadline)) }
    }

    /// Checks that a Step keeps the promise that its brain thinks as long as the scenario states. `asked` are the
    /// robots of its Turn.
    pub(super) fn check_promise(
        &self,
        session: u64,
        asked: &[usize],
        writes: &[Write],
    ) -> Result<(), Status> {
        for (i, write) in writes.iter().enumerate() {
            let problem = if write.thinking.ns.is_some() {
                Some(("thinking_ns", "declares a thinking time"))
            } else if write.thinking.operations.is_some() {
                Some(("operations", "declares a thinking time"))
            } else if self.sessions.robot(session, write.slot).is_none_or(|robot| !asked.contains(&robot)) {
                Some(("robot", "has a part for a robot that is not in its Turn"))
            } else {
                None
            };
            if let Some((field, problem)) = problem {
                return Err(broken(&format!("step.robots[{i}].{field}"), problem));
            }
        }
        if writes.len() < asked.len() {
            return Err(broken("step.robots", "leaves out a robot that is in its Turn"));
        }
        Ok(())
    }

    /// Hands in the answer of an overtaken brain, and gives it its Turn of the tick that has begun, if it has one.
    pub(super) fn catch_up(&mut self, session: u64, writes: Vec<Write>, overtaken: Overtaken) {
        for write in writes {
            let Some(robot) = self.sessions.robot(session, write.slot) else { continue };
            let Some(turn) = overtaken.steps.iter().find(|turn| turn.robot == robot) else { continue };
            let done = self.done_at(turn);
            let (ports, spec) = (&mut self.ports, &self.world.scenario().robots[robot]);
            let bytes = ports.senders[robot].send(spec, write.output).into_bytes(spec);
            // The writes were before the tick that may have begun, for the world.
            ports.senders_at_begin[robot].clone_from(&ports.senders[robot]);
            self.sessions.wait_until(robot, write.until);
            self.world.supply(robot, Some((done, &bytes)));
            self.record_late(robot, done, bytes);
        }
        self.settle(&overtaken.steps);
        self.deliver_deferred(session, overtaken.deferred);
    }

    /// Settles steps that will not be answered any more, or have been: a missing answer counts as an empty one.
    pub(super) fn settle(&mut self, steps: &[Turn]) {
        if steps.is_empty() {
            return;
        }
        for turn in steps {
            // The world goes on as if the brain had not been asked: it wrote nothing, and took its time for that.
            let done = self.done_at(turn);
            if self.world.supply(turn.robot, Some((done, &[]))) {
                self.record_late(turn.robot, done, Vec::new());
            }
        }
        let now = clock::now();
        self.pacer.note_wait(now);
        self.pacer.wait_from(now);
    }

    /// Gives a brain that is not overtaken any more its Turn of the tick that has begun, if it has one.
    pub(super) fn deliver_deferred(&mut self, session: u64, mut turns: Vec<Turn>) {
        turns.retain(|&turn| !self.lets_sleep(turn));
        if !turns.is_empty() {
            self.sessions.deliver_to(session, &self.world, &turns);
        }
    }

    /// Handles the deferred messages, as long as the world is not ahead of its brains.
    pub(super) fn handle_deferred(&mut self) {
        while !self.sessions.is_any_overtaken() {
            let Some(message) = self.deferred.pop_front() else { return };
            self.handle_now(message);
        }
    }

    /// Handles the deferred messages though the world is ahead of its brains, since a brain does not answer. What would
    /// change the world by hand, or write it down, waits on.
    pub(super) fn handle_deferred_at_last(&mut self) {
        let waits_on = |message: &Message| {
            use Request::{Intervene, Record, Save, StopRecording};
            matches!(message, Message::Request(Intervene(_) | Record(_) | Save { .. } | StopRecording(_), _))
        };
        let (waiting, others): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.deferred).into_iter().partition(waits_on);
        self.deferred.extend(waiting);
        for message in others {
            self.handle_now(message);
        }
    }
}

/// Whether the sender of this message sees how the world stands, or keeps it so.
pub(super) fn sees_world(message: &Message) -> bool {
    match message {
        Message::Request(request, _) => match request {
            Request::Report
            | Request::Start
            | Request::Pause
            | Request::Step { .. }
            | Request::SetPace(_)
            | Request::Snapshot
            | Request::Save { .. }
            | Request::Record(_)
            | Request::StopRecording(_)
            | Request::Intervene(_) => true,
            // A brain that hangs is detached at once; the report of how the world then stands waits.
            Request::DetachBrain { .. } => false,
            // The present state is of no interest any more.
            Request::Reset(_) | Request::Restore { .. } | Request::Delete => false,
            // A replay is never ahead.
            Request::Seek { .. } | Request::Fork(_) => false,
        },
        Message::Watch(_) | Message::WatchCable(_) | Message::Cover(_) | Message::Stand(..) => true,
        // Numbers only; monitoring that asks why a world stands must not wait for that.
        Message::Measure(_)
        | Message::Describe(_)
        // The order is recorded when it is given.
        | Message::Order(_)
        | Message::DescribeReplay(_)
        | Message::Attach(..)
        | Message::Step(_)
        | Message::Detach { .. }
        | Message::Stop => false,
    }
}

fn broken(field: &str, problem: &str) -> Status {
    Status::failed_precondition(format!(
        "{field}: {problem}, which the Hello has excluded (thinks_as_scenario)"
    ))
}
