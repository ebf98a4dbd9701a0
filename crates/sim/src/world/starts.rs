//! The state of robots when the tick began, for observers within a tick.
//!
//! The first half of a tick runs each robot's cable up to its brain's step, which is later than the tick's start. A
//! reader between two ticks gets the start; a replay always stands within a tick.

use alloc::vec::Vec;

use super::World;
use crate::robot::Robot;
use crate::view::RobotView;

/// The robots at the start of a tick, if they are kept. A clone of a world keeps none.
#[derive(Debug, Default)]
pub(super) struct Starts {
    is_on: bool,
    robots: Vec<Robot>,
}

impl Starts {
    /// Takes the state of the robots at the beginning of a tick.
    #[inline]
    pub(super) fn take(&mut self, robots: &mut [Robot]) {
        self.robots.clear();
        if self.is_on {
            self.robots.extend(robots.iter_mut().map(Robot::as_seen));
        }
    }
}

impl World {
    /// Keeps the state of robots at the beginning of each tick, from the next one on, or no longer does. It costs a
    /// copy of each robot a tick, and makes no difference to anything else. A clone does not keep it.
    pub fn keep_starts(&mut self, is_on: bool) {
        if !is_on {
            self.spare.starts.robots.clear();
        }
        self.spare.starts.is_on = is_on;
    }

    /// The robot of this index at [`time`](Self::time): as it is between two ticks, and within a tick as it was at its start,
    /// if that was [kept](Self::keep_starts). Of its timeline there is then only the number of events.
    ///
    /// # Panics
    /// If there is none.
    pub fn robot_at_start(&self, i: usize) -> Option<RobotView<'_>> {
        if !self.is_begun() {
            return Some(self.robot(i));
        }
        let robot = self.spare.starts.robots.get(i)?;
        Some(RobotView::new(&self.scenario.robots[i], robot))
    }
}
