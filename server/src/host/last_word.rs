//! Robots that stand when their brain is gone: a last command, written as the brain would have written it.
//!
//! A robot keeps its last command, as a real one would, and a program that is gone gives no other. A brain that is a
//! person's hand on a page goes in the midst of driving, so it leaves a last word with the server when it comes
//! (`Hello.stop_when_gone`). The server is the driver on the laptop then that outlives the program: the bytes are an input
//! of the world like any other, are recorded, and go over the cable.

use std::time::{Duration, Instant};

use baudbot_sim::drive::Wheels;
use baudbot_sim::{SimTime, World};

use super::{Host, Pending};
use crate::endpoint::{Output, Signals, Thinking};

/// So long by the wall clock and by the simulated one a brain may say nothing. People hardly see less, and a network
/// seldom takes more.
const SILENCE: Duration = Duration::from_secs(1);

/// The last word of a robot's brain.
#[derive(Clone)]
pub(super) struct LastWord {
    /// When its brain last sent a Step.
    heard: Instant,
    heard_at: SimTime,
    /// It is said, and the brain has sent nothing since.
    said: bool,
}

impl LastWord {
    /// Of a brain that is here now.
    pub(super) fn of(world: &World) -> Self {
        Self { heard: Instant::now(), heard_at: world.time(), said: false }
    }

    fn is_due(&mut self, now: Instant, time: SimTime) -> bool {
        // The world may have been taken back to before that.
        self.heard_at = self.heard_at.min(time);
        !self.said
            && now.saturating_duration_since(self.heard) >= SILENCE
            && Duration::from_nanos(time.since(self.heard_at)) >= SILENCE
    }
}

impl Host {
    /// A brain has sent a Step.
    pub(super) fn note_word_of(&mut self, session: u64) {
        for &robot in self.sessions.robots(session) {
            if let Some(word) = &mut self.last_words[robot] {
                *word = LastWord::of(&self.world);
            }
        }
    }

    /// A brain is gone: its last word is said.
    pub(super) fn stop_robots_of(&mut self, session: u64) {
        for robot in self.sessions.robots(session).to_vec() {
            if self.last_words[robot].take().is_some() {
                self.stop(robot);
            }
        }
    }

    /// A tick has begun in which brains are not waited for: of those that say nothing the last word is said.
    pub(super) fn stop_silent(&mut self, now: Instant) {
        if self.pace.watchdog().is_some() {
            return;
        }
        let time = self.world.time();
        for robot in 0..self.last_words.len() {
            let Some(word) = &mut self.last_words[robot] else { continue };
            if word.is_due(now, time) {
                word.said = true;
                self.stop(robot);
            }
        }
    }

    fn stop(&mut self, robot: usize) {
        let wheels = Wheels { left: 0.0, right: 0.0 };
        let standstill = Output::Command(Signals { wheels, others: Vec::new() });
        let bytes = self.senders[robot].encode(&self.world.scenario().robots()[robot], Some(standstill));
        // Between two ticks its brain's last step is in one that is over.
        let at = self.written_at(robot, Thinking::default()).max(self.world.time());
        self.inputs.push(Pending { robot, at, bytes, tick: None });
    }
}
