//! Going on while answers are under way that could not have reached their robots yet.
//!
//! [`World::finish_ahead`](baudbot_sim::World::finish_ahead) says why that changes nothing. Here it is seen to that
//! nobody looks at a world that is ahead of its brains: letters of those who want to are held until all brains have
//! answered, or until the watchdog finds that one does not. A brain whose robots go ahead of it has at most one Turn to
//! answer; its next one is held, too.

use std::time::Instant;

use baudbot_sim::{SimTime, Turn};
use tonic::Status;

use super::{Host, Next};
use crate::endpoint::Write;
use crate::letter::{Letter, Order};
use crate::pace::Pace;
use crate::recording::Recorder;

impl Host {
    /// Whether nobody would see it if the world went ahead of its brains.
    fn is_unseen(&self) -> bool {
        let looks_ahead = matches!(self.pace, Pace::Lockstep(lockstep) if lockstep.lookahead);
        let waits = !self.held.is_empty() || !self.interventions.is_empty();
        let recorded = self.recorder.as_ref().is_some_and(Recorder::looks);
        let seen = self.on_tick.is_some() || !self.observers.is_empty() || waits || recorded;
        looks_ahead && !seen && !self.paused
    }

    /// Whether the tick can end without the answers that are not there.
    pub(super) fn can_finish_ahead(&self) -> bool {
        self.is_unseen() && self.sessions.may_fall_behind(|turn| self.reaches_beyond_tick(turn))
    }

    /// Whether the next tick can begin without them.
    pub(super) fn can_begin_ahead(&self) -> bool {
        self.is_unseen() && self.sessions.behind().all(|turn| self.reaches_beyond_tick(turn))
    }

    fn reaches_beyond_tick(&self, turn: &Turn) -> bool {
        self.world.reach(turn.robot, self.done_at(turn)).is_some_and(|reach| reach >= self.tick_end())
    }

    /// When a brain is done that has promised to think as long as the scenario says.
    fn done_at(&self, turn: &Turn) -> SimTime {
        turn.at + self.world.scenario().robots()[turn.robot].thinking_ns
    }

    /// Ends the tick; the brains that have not answered fall behind.
    pub(super) fn finish_ahead(&mut self, now: Instant) {
        let open: Vec<_> = self.sessions.fall_behind();
        let open: Vec<_> = open.iter().map(|turn| (turn.robot, self.done_at(turn))).collect();
        self.finish_with(now, &open);
    }

    /// What a world that stands does until brains have answered.
    pub(super) fn wait_for_answers(&self, now: Instant) -> Next {
        let Some(watchdog) = self.pace.watchdog() else { return Next::Wait(None) };
        let deadline = self.waiting_since + watchdog.timeout;
        if now >= deadline { Next::Watchdog } else { Next::Wait(Some(deadline)) }
    }

    /// Whether a Step keeps the promise that its brain thinks as long as the scenario says. `asked` are its Turn's robots.
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

    /// A brain that the world went ahead of has answered.
    pub(super) fn catch_up(&mut self, session: u64, writes: Vec<Write>) {
        let behind = self.sessions.take_behind(session);
        for write in writes {
            let Some(robot) = self.sessions.robot(session, write.slot) else { continue };
            let Some(turn) = behind.iter().find(|turn| turn.robot == robot) else { continue };
            let done = self.done_at(turn);
            let bytes = self.senders[robot].encode(&self.world.scenario().robots()[robot], write.output);
            // For the world, this was written before the tick that may be begun.
            self.senders_at_begin[robot].clone_from(&self.senders[robot]);
            self.sessions.wait_until(robot, write.until);
            self.world.supply(robot, Some((done, &bytes)));
            self.record_late(robot, done, bytes);
        }
        self.settle(&behind);
        self.deliver_held(session);
    }

    /// A brain will not answer any more, or nobody waits for it: what it owes counts as answered with nothing.
    pub(super) fn give_up(&mut self, session: u64) {
        let behind = self.sessions.take_behind(session);
        self.settle(&behind);
    }

    fn settle(&mut self, behind: &[Turn]) {
        if behind.is_empty() {
            return;
        }
        for turn in behind {
            // As of a brain that is not asked: it wrote nothing, and took its time for that.
            let done = self.done_at(turn);
            if self.world.supply(turn.robot, Some((done, &[]))) {
                self.record_late(turn.robot, done, Vec::new());
            }
        }
        let now = Instant::now();
        self.pacing.waiting += now.saturating_duration_since(self.waiting_since);
        self.waiting_since = now;
    }

    /// Gives a brain that is not behind any more its Turn of the tick that is begun, if it has one.
    pub(super) fn deliver_held(&mut self, session: u64) {
        let mut turns = self.sessions.take_held(session);
        turns.retain(|&turn| !self.lets_sleep(turn));
        if !turns.is_empty() {
            self.sessions.deliver_to(session, &self.world, &turns);
        }
    }

    /// Opens the letters of those who want to see the world, if it is not ahead of its brains.
    pub(super) fn open_held(&mut self) {
        while !self.sessions.is_behind() {
            let Some(letter) = self.held.pop_front() else { return };
            self.open_now(letter);
        }
    }

    /// Opens them though it is, since a brain does not answer. What is to be changed by hand or written down waits on.
    pub(super) fn open_held_at_last(&mut self) {
        let changes = |letter: &Letter| {
            use Order::{Intervene, Record, Save, StopRecording};
            matches!(letter, Letter::Order(Intervene(_) | Record(_) | Save { .. } | StopRecording(_), _))
        };
        let (changes, others): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.held).into_iter().partition(changes);
        self.held.extend(changes);
        for letter in others {
            self.open_now(letter);
        }
    }
}

/// Whether who wrote this letter sees how the world stands, or keeps it so.
pub(super) fn looks(letter: &Letter) -> bool {
    match letter {
        Letter::Order(order, _) => match order {
            Order::Report
            | Order::Start
            | Order::Pause
            | Order::Step { .. }
            | Order::SetPace(_)
            | Order::Snapshot
            | Order::Save { .. }
            | Order::Record(_)
            | Order::StopRecording(_)
            | Order::Intervene(_) => true,
            // A brain that hangs is thrown off at once; how the world then stands is asked behind that.
            Order::DetachBrain { .. } => false,
            // Whatever the world was, it is not any more.
            Order::Reset | Order::Restore { .. } | Order::Delete => false,
            // A replay is never ahead.
            Order::Seek { .. } | Order::Fork(_) => false,
        },
        Letter::Watch { .. } | Letter::Cover(_) => true,
        // Numbers only, and who wants to know why a world stands must not wait for that.
        Letter::Measure(_)
        | Letter::Describe(_)
        | Letter::DescribeReplay(_)
        | Letter::Attach(..)
        | Letter::Step { .. }
        | Letter::Detach { .. }
        | Letter::End => false,
    }
}

fn broken(field: &str, problem: &str) -> Status {
    Status::failed_precondition(format!(
        "{field}: {problem}, which the Hello has promised not to happen (thinks_as_scenario)"
    ))
}
