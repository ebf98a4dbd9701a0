//! What is in letters to a world: brains come, answer and go.

use std::sync::Arc;
use std::time::Instant;

use baudbot_sim::SimTime;
use tokio::sync::oneshot;
use tonic::Status;

use super::last_word::LastWord;
use super::{Host, Pending, ahead, sender};
use crate::endpoint::{Thinking, Write};
use crate::letter::{Attach, Attached, CoverageReport, Lease, Letter};
use crate::log::event;
use crate::observers::View;
use crate::pace::WatchdogPolicy;
use crate::sessions::Answer;

impl Host {
    pub(super) fn open(&mut self, letter: Letter) {
        if self.sessions.is_behind() && ahead::looks(&letter) {
            self.held.push_back(letter);
            return;
        }
        self.open_now(letter);
        self.open_held();
    }

    pub(super) fn open_now(&mut self, letter: Letter) {
        match letter {
            Letter::Order(order, reply) => self.obey(order, reply),
            Letter::Describe(reply) => drop(reply.send(Arc::clone(self.world.scenario()))),
            Letter::DescribeReplay(reply) => drop(reply.send(self.tape())),
            Letter::Measure(reply) => drop(reply.send(self.measure())),
            Letter::Cover(reply) => drop(reply.send(CoverageReport::of(&self.world))),
            Letter::Watch(watch) => {
                let view = View {
                    name: &self.name,
                    world: &self.world,
                    sessions: &self.sessions,
                    beliefs: &self.beliefs,
                };
                self.observers.add(watch, view);
            }
            Letter::Attach(request, reply) => self.attach(request, reply),
            Letter::Step { session, turn, writes, permit } => {
                drop(permit);
                self.take_step(session, turn, writes);
            }
            Letter::End => {
                event!(self, info, "world over, since its server stops");
                // The same may be there again, in a moment.
                self.over =
                    Some(Status::unavailable(format!("world `{}` is over, as its server stops", self.name)));
            }
            Letter::Detach { session, why } => {
                self.log_detached(session, &why);
                self.record_gone(session, &why);
                self.beliefs.hand_to(None, self.sessions.robots(session));
                self.give_up(session);
                self.stop_robots_of(session);
                self.sessions.detach(session, self.policy());
            }
        }
    }

    fn attach(&mut self, request: Attach, reply: oneshot::Sender<Result<Attached, Status>>) {
        if let Err(status) = self.check_live("a brain") {
            return drop(reply.send(Err(status)));
        }
        let scenario = Arc::clone(self.world.scenario());
        let (world, brain, stops) = (request.world.clone(), request.brain.clone(), request.stop_when_gone);
        let (session, robots) = match self.sessions.attach(&self.name, &scenario, request) {
            Ok(attached) => attached,
            Err(status) => return drop(reply.send(Err(status))),
        };
        let lost_steps = self.sessions.count_of_lost_steps(session);
        for &robot in &robots {
            self.senders[robot] = sender(&self.world.robot(robot));
            self.last_words[robot] = stops.then(|| LastWord::of(&self.world));
        }
        self.record_come(&robots, &brain);
        self.log_attached(session, &robots);
        let lockstep = self.pace.watchdog().is_some();
        let lease = Lease { world, session, why: "nobody waited for the answer any more".to_owned() };
        // If nobody waits for the answer any more, the lease is dropped, and a letter says so.
        self.beliefs.hand_to(Some(session), &robots);
        let beliefs = self.beliefs.clone();
        if reply.send(Ok(Attached { lease, scenario, robots, lockstep, beliefs, lost_steps })).is_err() {
            return;
        }
        if self.world.ending().is_some() {
            self.sessions.tell_one_ended(session, self.world.tick());
        } else if lockstep && self.begun {
            self.sessions.deliver_unanswered(session, &self.world);
        }
    }

    pub(super) fn policy(&self) -> Option<WatchdogPolicy> {
        self.pace.watchdog().map(|watchdog| watchdog.policy)
    }

    fn take_step(&mut self, session: u64, turn: u64, writes: Vec<Write>) {
        self.note_word_of(session);
        let promised = self.sessions.promised(session);
        let answer = self.sessions.answered(session, turn);
        match (answer, self.pace.watchdog()) {
            (Answer::Void, _) => return,
            (Answer::Unasked, Some(_)) => {
                let text = format!(
                    "step.turn: Turn {turn} is not the one to answer; in lockstep each Turn takes exactly one Step"
                );
                return self.close(session, Status::failed_precondition(text));
            }
            (Answer::Due, Some(_)) => {
                if let Some(Err(status)) = promised.map(|asked| self.check_promise(session, &asked, &writes))
                {
                    return self.close(session, status);
                }
                if self.sessions.is_one_behind(session) {
                    return self.catch_up(session, writes);
                }
            }
            (Answer::Due | Answer::Unasked, None) => {
                if !self.sessions.takes_step(session) {
                    return;
                }
            }
        }
        let tick = self.sessions.tick_of(session, turn);
        for write in writes {
            let Some(robot) = self.sessions.robot(session, write.slot) else { continue };
            let at = self.written_at(robot, write.thinking);
            self.sessions.wait_until(robot, write.until);
            let spec = &self.world.scenario().robots()[robot];
            let bytes = self.senders[robot].encode(spec, write.output);
            self.inputs.push(Pending { robot, at, bytes, tick });
        }
    }

    /// When the bytes of a step are handed to the port: the instant of the brain's step plus its thinking
    /// time where the world waits, and not before they came where time follows the wall clock.
    pub(super) fn written_at(&self, robot: usize, thinking: Thinking) -> SimTime {
        let turn = self.world.turns().iter().find(|turn| turn.robot == robot);
        let step = turn.map_or_else(|| self.world.time(), |turn| turn.at);
        match &self.clock {
            // A world that lags its clock takes what comes now as coming within this tick.
            Some(clock) => clock.time(Instant::now()).min(self.tick_end()).max(step),
            None => step + thinking.on(self.world.robot(robot).spec()),
        }
    }
}
