//! What monitoring is told. It is quick, since the world waits for it, and copies no state.

use std::sync::Arc;
use std::time::Instant;

use super::Host;
use crate::metrics::{MAX_ROBOTS, Measures, RobotMeasures};

impl Host {
    /// The world's numbers as they are, also while it is ahead of its brains.
    pub(super) fn measure(&self) -> Measures {
        let robots = self.world.robots().zip(self.sessions.measures(Instant::now()));
        Measures {
            scenario: Arc::clone(self.world.scenario()),
            activity: self.activity(),
            tick: self.world.tick(),
            time: self.world.time(),
            running: self.running.elapsed(),
            pacing: self.pacing.clone(),
            observers: self.observers.count(),
            frames_missed: self.observers.missed_frames(),
            robots: robots.take(MAX_ROBOTS).map(|(robot, seat)| RobotMeasures::of(&robot, seat)).collect(),
        }
    }
}
