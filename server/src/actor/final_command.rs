//! Final commands: robots that stand when their brain is gone.
//!
//! A robot keeps its last command, as a real one would, and a program that is gone gives no other. A brain that is a
//! person's hand on a page may go in the midst of driving, so it can ask the server, when it attaches, to write a last
//! command as the brain would have written it (`Hello.stop_when_gone`). The server is then the driver on the laptop that
//! outlives the program: the bytes are an input of the world like any other, are recorded, and go over the cable.

use std::time::{Duration, Instant};

use baudbot_sim::drive::Wheels;
use baudbot_sim::{SimTime, World};

use super::{Pending, WorldActor};
use crate::clock;
use crate::endpoint::{Output, Signals, Thinking};

/// The longest silence of a brain, by the wall clock and by the simulated one. People hardly see a shorter pause, and
/// a network seldom makes a longer one.
const SILENCE: Duration = Duration::from_secs(1);

/// The final command of a robot that has a brain.
#[derive(Clone)]
pub(super) struct FinalCommand {
    /// The instant at which its brain last sent a Step.
    heard: Instant,
    heard_at: SimTime,
    /// The command is written, and the brain has sent nothing since.
    written: bool,
}

impl FinalCommand {
    /// A `FinalCommand` of a brain that has just sent something.
    pub(super) fn of(world: &World) -> Self {
        Self { heard: clock::now(), heard_at: world.time(), written: false }
    }

    fn is_due(&mut self, now: Instant, time: SimTime) -> bool {
        // The world may have been taken back to before that.
        self.heard_at = self.heard_at.min(time);
        !self.written
            && now.saturating_duration_since(self.heard) >= SILENCE
            && Duration::from_nanos(time.since(self.heard_at)) >= SILENCE
    }
}

impl WorldActor {
    /// Notes that a brain has sent a Step.
    pub(super) fn note_step_of(&mut self, session: u64) {
        for &robot in self.sessions.robots(session) {
            if let Some(command) = &mut self.ports.final_commands[robot] {
                *command = FinalCommand::of(&self.world);
            }
        }
    }

    /// Writes the final commands of a brain that is gone.
    pub(super) fn stop_robots_of(&mut self, session: u64) {
        for robot in self.sessions.robots(session).to_vec() {
            if self.ports.final_commands[robot].take().is_some() {
                self.stop(robot);
            }
        }
    }

    /// In a tick in which brains are not waited for, writes the final commands of those that have been silent for too long.
    pub(super) fn stop_silent_robots(&mut self, now: Instant) {
        if self.pacer.pace.watchdog().is_some() {
            return;
        }
        let time = self.world.time();
        for robot in 0..self.ports.final_commands.len() {
            let Some(command) = &mut self.ports.final_commands[robot] else { continue };
            if command.is_due(now, time) {
                command.written = true;
                self.stop(robot);
            }
        }
    }

    fn stop(&mut self, robot: usize) {
        let wheels = Wheels { left: 0.0, right: 0.0 };
        let standstill = Output::Command(Signals { wheels, others: Vec::new() });
        let sent = self.ports.senders[robot].send(&self.world.scenario().robots[robot], Some(standstill));
        // Between two ticks its brain's last step is in one that is over.
        let at = self.written_at(robot, Thinking::default()).max(self.world.time());
        self.ports.inputs.push(Pending { robot, at, sent, tick: None });
    }
}
