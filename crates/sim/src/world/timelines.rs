//! The timelines that a world keeps of its robots.

use super::World;
use crate::robot::Recorder;

impl World {
    /// Forgets the robots' timelines, and from now on keeps so many events of each robot's; 0 keeps none. Makes no
    /// difference to anything else.
    pub fn keep_timeline(&mut self, events: usize) {
        for robot in &mut self.state.robots {
            robot.recorder = Recorder::new(events, robot.lost());
        }
    }

    /// The number of events of each robot's timeline that a new world keeps.
    pub fn usual_timeline(&self) -> usize {
        TIMELINE_EVENTS / self.state.robots.len().clamp(16, 1024)
    }

    /// Keeps the last so many events of each robot's timeline, from now on. Makes no difference to anything else.
    pub fn resize_timeline(&mut self, events: usize) {
        self.state.robots.iter_mut().for_each(|robot| robot.recorder.timeline.set_room(events));
    }
}

/// Events that a world keeps of all its robots' timelines together, by default.
const TIMELINE_EVENTS: usize = 1 << 16;
