//! Brains: they attach, answer and go.

use std::sync::Arc;

use baudbot_sim::{SimTime, Turn};
use tonic::Status;

use super::final_command::FinalCommand;
use super::ports::{ToDevice, sender};
use super::{Pending, Phase, WorldActor};
use crate::clock;
use crate::endpoint::{Mode, Thinking, Write};
use crate::message::{Attach, Attached, Lease, Reply, Step};
use crate::pace::{Pace, WatchdogPolicy};
use crate::sessions::{Answer, NewSession};

impl WorldActor {
    pub(super) fn attach(&mut self, request: Attach, reply: Reply<Attached>) {
        if let Err(status) = self.check_live("a brain") {
            return drop(reply.send(Err(status)));
        }
        if request.mode == Mode::SerialPort && !matches!(self.pacer.pace, Pace::Timed(_)) {
            let text = "hello.serial_port: the world does not follow the wall clock; serial ports need the pace real-time or scaled";
            return drop(reply.send(Err(Status::failed_precondition(text))));
        }
        let scenario = Arc::clone(self.world.scenario());
        let (world, brain, stops) = (request.world.clone(), request.brain.clone(), request.stop_when_gone);
        let (raw, by) = (request.mode.is_raw(), request.by.clone());
        let new = match self.sessions.attach(&self.name, &scenario, request) {
            Ok(new) => new,
            Err(status) => return drop(reply.send(Err(status))),
        };
        for &robot in &new.robots {
            self.ports.attach(robot, sender(&self.world.robot(robot), raw));
            self.ports.final_commands[robot] = stops.then(|| FinalCommand::of(&self.world));
        }
        self.record_attached(&new.robots, &brain, by.as_deref());
        self.log_attached(new.number, &new.robots);
        self.beliefs.hand_to(Some(new.number), &new.robots);
        let lockstep = self.pacer.pace.watchdog().is_some();
        // A client that no longer waits for the answer drops the lease, which sends a message that releases the robots.
        let lease =
            Lease { world, session: new.number, why: "nobody waited for the answer any more".to_owned() };
        let (robots, lost_steps) = (new.robots.clone(), Arc::clone(&new.lost_steps));
        let beliefs = self.beliefs.clone();
        let attached = Attached { lease, scenario, robots, lockstep, beliefs, lost_steps };
        if reply.send(Ok(attached)).is_ok() {
            self.greet(&new, lockstep);
        }
    }

    /// Sends a new brain what it has come too late for.
    fn greet(&mut self, new: &NewSession, lockstep: bool) {
        if self.world.ending().is_some() {
            self.sessions.tell_one_ended(new.number, &self.world);
        } else if lockstep && self.phase == Phase::Begun {
            self.sessions.deliver_left_open(new, &self.world);
        }
    }

    /// Ends a brain program's stream with this status.
    pub(super) fn close(&mut self, session: u64, status: Status) {
        let owed = self.sessions.take_overtaken(session);
        self.close_owing(session, status, &owed);
    }

    /// Ends the stream of a brain that owed these steps.
    fn close_owing(&mut self, session: u64, status: Status, owed: &[Turn]) {
        self.let_go(session, status.message(), owed);
        self.sessions.close(session, self.policy(), status);
    }

    /// A brain is going that owed these steps.
    pub(super) fn let_go(&mut self, session: u64, why: &str, owed: &[Turn]) {
        self.changes += 1;
        self.log_detached(session, why);
        self.record_detached(session, why);
        self.beliefs.hand_to(None, self.sessions.robots(session));
        self.settle(owed);
        self.stop_robots_of(session);
    }

    pub(super) fn policy(&self) -> Option<WatchdogPolicy> {
        self.pacer.pace.watchdog().map(|watchdog| watchdog.policy)
    }

    pub(super) fn take_step(&mut self, Step { session, turn, writes, permit }: Step) {
        drop(permit);
        self.note_step_of(session);
        match (self.sessions.answer(session, turn), self.pacer.pace.watchdog()) {
            (Answer::Void, _) => {}
            (Answer::Unasked, Some(_)) => {
                let text = format!(
                    "step.turn: Turn {turn} is not the one to answer; in lockstep each Turn takes exactly one Step"
                );
                self.close(session, Status::failed_precondition(text));
            }
            (Answer::Due(promised), Some(_)) => {
                match promised.map_or(Ok(()), |asked| self.check_promise(session, &asked, &writes)) {
                    Ok(()) => self.write_all(session, turn, writes),
                    Err(status) => self.close(session, status),
                }
            }
            (Answer::Overtaken(overtaken), _) => {
                let asked: Vec<_> = overtaken.steps.iter().map(|step| step.robot).collect();
                match self.check_promise(session, &asked, &writes) {
                    Ok(()) => self.catch_up(session, writes, overtaken),
                    Err(status) => self.close_owing(session, status, &overtaken.steps),
                }
            }
            (Answer::Due(_) | Answer::Unasked, None) => {
                if self.sessions.takes_step(session) {
                    self.write_all(session, turn, writes);
                }
            }
        }
    }

    /// Writes what a brain does to the ports of its robots, in the tick that has begun.
    fn write_all(&mut self, session: u64, turn: u64, writes: Vec<Write>) {
        let tick = self.sessions.tick_of(session, turn);
        for write in writes {
            let Some(robot) = self.sessions.robot(session, write.slot) else { continue };
            let at = self.written_at(robot, write.thinking);
            self.sessions.wait_until(robot, write.until);
            let spec = &self.world.scenario().robots[robot];
            // Boards without a bootloader are not reset by DTR.
            if write.opened && spec.processor.bootloader_ns > 0 && !self.ports.to_reset.contains(&robot) {
                self.ports.to_reset.push(robot);
            }
            let sent = self.ports.senders[robot].send(spec, write.output);
            self.ports.inputs.push(Pending { robot, at, sent, tick });
            let to_device = |(sensor, bytes)| ToDevice { robot, sensor, at, bytes };
            self.ports.to_devices.extend(write.ports.into_iter().map(to_device));
        }
    }

    /// The instant at which bytes are handed to a robot's port. Where the world waits for brains, that is the instant
    /// of the brain's step plus its thinking time. Where time follows the wall clock, it is when they came, but not
    /// before the step.
    pub(super) fn written_at(&self, robot: usize, thinking: Thinking) -> SimTime {
        // The turns are in the order of the robots.
        let turns = self.world.turns();
        let turn = turns.binary_search_by_key(&robot, |turn| turn.robot);
        let step = turn.map_or_else(|_| self.world.time(), |turn| turns[turn].at);
        match &self.pacer.clock {
            // A world that lags its clock takes what comes now as coming within this tick.
            Some(clock) => clock.time(clock::now()).min(self.tick_end()).max(step),
            None => step + thinking.on(self.world.robot(robot).spec()),
        }
    }
}
