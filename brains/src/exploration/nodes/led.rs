//! A robot that goes by its map where no node is pending.

use baudbot_geometry::{Point, Pose};

use super::{Nodes, State};
use crate::exploration::graph::Status;
use crate::exploration::{Command, Explorer, Input};

impl Nodes {
    /// Goes on by the map.
    pub(super) fn lead(&mut self, here: &Pose) -> State {
        self.pass(here);
        self.map.interrupt();
        State::Led { ended: self.map.ended(), leg: None }
    }

    /// Follows the path of the map until a plan of the map has ended; then places nodes there.
    pub(super) fn follow(&mut self, input: &Input<'_>, ended: usize, leg: Option<Point>) -> Option<Command> {
        let here = &input.world_from_robot;
        let command = self.map.step(input);
        if matches!(command, Command::Done(_) | Command::Failed(_)) {
            self.state = State::Ended(command);
            return Some(command);
        }
        let has_looked = self.map.ended() > ended;
        if has_looked || (leg.is_some() && self.map.leg() != leg) {
            self.pass(here);
        }
        self.state = if has_looked { State::Place } else { State::Led { ended, leg: self.map.leg() } };
        (!has_looked).then_some(command)
    }

    /// The robot is here, on a straight path from the active node: at a node that is here, or a new one.
    fn pass(&mut self, here: &Pose) {
        let is_here = |node: &usize| self.distance(here, *node) <= self.parameters.reach_m();
        let known = self.graph.having(Status::Completed).find(is_here);
        let node = known.unwrap_or_else(|| self.graph.add_passed(here.position, Status::Completed));
        if node != self.active {
            self.graph.join(self.active, node);
        }
        self.active = node;
        self.tried.clear();
        self.trail.clear();
    }
}
