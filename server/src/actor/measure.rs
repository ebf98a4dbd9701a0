//! The measures of a world, for monitoring. The world waits for them, so they are numbers and no copy of its state.

use std::sync::Arc;

use super::WorldActor;
use crate::clock;
use crate::measures::{MAX_ROBOTS, Measures, RobotMeasures};

impl WorldActor {
    /// The numbers of the world as it stands, also while it is ahead of its brains.
    pub(super) fn measure(&self) -> Measures {
        let robots = self.world.robots().zip(self.sessions.measures(clock::now()));
        Measures {
            scenario: Arc::clone(self.world.scenario()),
            activity: self.activity(),
            tick: self.world.tick(),
            time: self.world.time(),
            running: self.pacer.running.elapsed(),
            pacing: self.pacer.statistics.clone(),
            observers: self.observers.count(),
            frames_missed: self.observers.missed_frames(),
            keeping: self.state.keeping(),
            robots: robots.take(MAX_ROBOTS).map(|(robot, slot)| RobotMeasures::of(&robot, &slot)).collect(),
        }
    }
}
