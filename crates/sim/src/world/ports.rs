//! Programs that talk to sensors on their own cables, and observers of any cable.

use super::{Intervention, World};
use crate::time::SimTime;

impl World {
    /// A program hands bytes to the port of a sensor's own, between [`begin`](Self::begin) and
    /// [`finish`](Self::finish), which puts them on the cable in the order of their instants, and those of one instant
    /// in the order of the calls. An instant before that of the brain's step in this tick, or before the tick if the
    /// brain does not step, is taken as that. A device that sends by itself receives them and does nothing.
    ///
    /// `sensor` is its place in the robot's [specification](crate::model::RobotSpec). What has no room in the laptop's buffer is
    /// refused and counted.
    ///
    /// Answers whether there is such a port, the tick is begun, and the run has not ended.
    pub fn write_port(&mut self, robot: usize, sensor: usize, at: SimTime, bytes: &[u8]) -> bool {
        if !self.is_begun() || self.ending().is_some() {
            return false;
        }
        let Self { scenario, state, .. } = self;
        let Some((spec, robot)) = scenario.robots.get(robot).zip(state.robots.get_mut(robot)) else {
            return false;
        };
        robot.write_port(spec, sensor, at, bytes)
    }

    /// The bit rate that the cable of a sensor's own has now: a device that [answers](crate::sensor::dialogue) may change it.
    /// `None` if there is no such cable, or it has none.
    pub fn port_baud(&self, robot: usize, sensor: usize) -> Option<u32> {
        let (spec, state) = self.scenario.robots.get(robot).zip(self.state.robots.get(robot))?;
        let k = spec.sensors.ports().iter().position(|&i| i == sensor)?;
        let port = spec.sensors.get(sensor)?.port.as_ref()?;
        state.dialogue(k).map_or_else(|| port.link.baud(), |dialogue| dialogue.baud(port, self.time()))
    }

    /// Keeps the last so many bytes that come over each of a robot's cables, each way, from now on; 0 keeps none. What
    /// was kept is forgotten. Makes no difference to anything else.
    pub fn keep_tape(&mut self, robot: usize, bytes: usize) {
        if let Some(robot) = self.state.robots.get_mut(robot) {
            robot.keep_tape(bytes);
        }
    }

    /// Whether the bytes on a robot's cables are [kept](Self::keep_tape).
    pub fn keeps_tape(&self, robot: usize) -> bool {
        self.state.robots.get(robot).is_some_and(|robot| robot.uplink.is_taped())
    }

    /// Keeps the edges on the pins of a robot's chip, with the world's instants, from now on, or no longer does: see
    /// [`Board::keep_edges`](crate::chip::Board::keep_edges). It can be read [there](crate::RobotView::board). A robot
    /// without a program of the user's own has no such chip. Makes no difference to anything else.
    pub fn keep_edges(&mut self, robot: usize, keep: bool) {
        if let Some(robot) = self.state.robots.get_mut(robot) {
            robot.keep_edges(keep);
        }
    }

    /// Counts the rounds of the main loop of the program on a robot's chip, from now on, or no longer does: see
    /// [`Board::keep_rounds`](crate::chip::Board::keep_rounds). Makes no difference to anything else.
    pub fn keep_rounds(&mut self, robot: usize, keep: bool) {
        if let Some(robot) = self.state.robots.get_mut(robot) {
            robot.keep_rounds(keep);
        }
    }

    /// Cables have the baud rates that robots were asked for in the tick that is over. A rate that the cable cannot have
    /// changes nothing, nor does one on a cable that has none, or after more changes than a run can have.
    pub(super) fn change_bauds(&mut self) {
        if !self.may_change_baud {
            return;
        }
        for own in 0..self.state().robots.len() {
            let Some(baud) = self.state_mut().robots[own].take_baud() else { continue };
            let robot = self.scenario().robots[own].name.clone();
            if matches!(self.set_baud(&robot, baud), Ok(true)) {
                self.altered.note(self.time(), &Intervention::SetBaud { robot, baud });
            }
        }
    }
}
