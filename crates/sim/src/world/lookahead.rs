//! Ahead of the brains: a tick can end although a brain has not answered, as long as no byte of its answer could have
//! reached its robot by then.
//!
//! Bytes that a brain writes at an instant are on the cable from then on, and the first arrives later. Until that
//! arrival the answer is known only to the laptop's end of the cable, and nothing reads it there; so it makes no
//! difference whether it is put there at once or [supplied](World::supply) afterwards. What does look there is listed
//! at `Line::reach`, and at those that call it: the driver's room, which is why nothing may be under way before, and
//! the next step of the same brain.

use alloc::vec::Vec;

use super::{Answer, Turn, World};
use crate::time::SimTime;

/// Steps that are not over though the world has gone on. They are no part of the state: once they are supplied, it is
/// what it would have been without.
#[derive(Clone, Debug, Default)]
pub(super) struct Ahead(Vec<Turn>);

impl Ahead {
    /// Whether this step is one of them.
    pub(super) fn holds(&self, turn: &Turn) -> bool {
        self.0.contains(turn)
    }
}

impl World {
    /// Whether a whole message has come for this robot's brain, on any of its ports, since its last step.
    pub fn has_message(&self, robot: usize) -> bool {
        self.state.robots.get(robot).is_some_and(|robot| robot.laptop.has_message)
    }

    /// Whether any byte has.
    pub fn has_bytes(&self, robot: usize) -> bool {
        let Some(robot) = self.state.robots.get(robot) else { return false };
        !robot.laptop.unread.is_empty() || robot.ports.iter().any(|port| !port.unread.is_empty())
    }

    /// The instant until which it makes no difference what this robot's brain writes at `done` or later; `None` if it
    /// always does. It stays true while nothing else is written to the robot.
    pub fn reach(&self, robot: usize, done: SimTime) -> Option<SimTime> {
        let state = self.state.robots.get(robot)?;
        // The bytes may change its cable at the end of the tick.
        if self.scenario.robots[robot].firmware.protocol.changes_baud() {
            return None;
        }
        // A chip sees a byte from its start bit on.
        if state.parts.chip.is_some() {
            return None;
        }
        // An unanswered step is counted behind the cycles before it, and those only once they are counted.
        if state.cycles.is_closing() {
            return None;
        }
        state.downlink.reach(&self.scenario.robots[robot].link, done)
    }

    /// As [`finish_answers`](Self::finish_answers), without the answers of the robots in `open`, each with when its
    /// brain is done. Each of them must be [supplied](Self::supply) before the world is taken beyond the robot's
    /// [`reach`](Self::reach), and before [`hash`](Self::hash) or an observer uses the world. Tick by tick the world is
    /// then as if `finish` had had the answer.
    pub fn finish_ahead(&mut self, answers: &[Answer<'_>], open: &[(usize, SimTime)]) {
        if !self.state.begun || self.state.ending.is_some() {
            return;
        }
        if open.is_empty() && self.ahead.0.is_empty() {
            return self.finish_answers(answers);
        }
        for turn in self.state.turns.clone() {
            // A brain answers one step after the other: the one before counts as answered with nothing.
            self.supply(turn.robot, None);
            if open.iter().any(|(robot, _)| *robot == turn.robot) {
                self.ahead.0.push(turn);
            }
        }
        self.finish_answers(answers);
        for &(robot, done) in open {
            if let Some(robot) = self.state.robots.get_mut(robot) {
                robot.laptop.busy_until = robot.laptop.busy_until.max(done);
            }
        }
    }

    /// The answer to a step that was left open: what the brain wrote, and when it was done; `None` if it left its robot
    /// out. Does nothing and is `false` if no step of this robot is open.
    pub fn supply(&mut self, robot: usize, written: Option<(SimTime, &[u8])>) -> bool {
        let Some(place) = self.ahead.0.iter().position(|turn| turn.robot == robot) else { return false };
        let turn = self.ahead.0.remove(place);
        let (spec, state) = (&self.scenario.robots[robot], &mut self.state.robots[robot]);
        if let Some((done, bytes)) = written {
            let done = done.max(turn.at);
            state.laptop.busy_until = done;
            state.write(spec, done, bytes);
        }
        state.step_over(spec, turn.at);
        true
    }
}
