//! The next node, and the way there.

use baudbot_geometry::{Pose, angle};

use super::{Leg, Nodes, State};
use crate::exploration::approach::{Approach, heading_to};
use crate::exploration::graph::{Paths, Status};

impl Nodes {
    /// The state that leads to the next node.
    pub(super) fn decide(&mut self, here: &Pose) -> State {
        loop {
            let Some(target) = self.choose(here) else { return self.lead(here) };
            let paths = self.graph.paths_to(target);
            if self.distance(here, self.active) > self.parameters.reach_m() {
                if let Some(state) = self.rejoin(here, target, &paths) {
                    return state;
                }
                self.graph.give_up(target);
                return self.lead(here);
            }
            if let Some(state) = self.leave(here, target, &paths) {
                return state;
            }
            if !self.looked_round.contains(&self.active) {
                return State::LookRound { heading_rad: here.heading, more: true };
            }
            self.graph.give_up(target);
        }
    }

    /// The target, as long as it is pending; then the nearest pending node by the length of the path, of those at
    /// the same distance the one that needs the least turn.
    fn choose(&mut self, here: &Pose) -> Option<usize> {
        let is_pending = |target: &usize| self.graph.nodes()[*target].status == Status::Pending;
        if let Some(target) = self.target.filter(is_pending) {
            return Some(target);
        }
        self.target = self.nearest(here);
        self.not_directly_from.clear();
        self.target
    }

    fn nearest(&self, here: &Pose) -> Option<usize> {
        let paths = self.graph.paths_from(self.active);
        let length = |node: &usize| {
            let way_m = paths.length(*node);
            let turn_rad = angle::difference(heading_to(here, self.graph.place(*node)), here.heading);
            way_m + TURN_COSTS_M * turn_rad.abs()
        };
        let pending = self.graph.having(Status::Pending).map(|node| (length(&node), node));
        pending.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, node)| node)
    }

    /// The state from the active node on; `None` if there is no path to the target.
    fn leave(&self, here: &Pose, target: usize, paths: &Paths) -> Option<State> {
        let next = paths.next(self.active);
        let is_near = self.distance(here, target) <= self.parameters.sight_m;
        if next != Some(target) && is_near && !self.not_directly_from.contains(&self.active) {
            return Some(State::Look { node: target });
        }
        let next = next?;
        let to = self.graph.place(next);
        let leg = Leg {
            approach: Approach::new(to),
            node: Some(next),
            from: Some(self.active),
            is_edge: true,
            is_seen: false,
        };
        Some(State::Go(leg))
    }

    /// The state from between two nodes on: to a node in sight from which there is a path to the target, or else back,
    /// since there may be more to be seen; `None` if it can do neither.
    fn rejoin(&self, here: &Pose, target: usize, paths: &Paths) -> Option<State> {
        let in_sight = |node: &usize| self.distance(here, *node) <= self.parameters.sight_m;
        let nodes = self.graph.having(Status::Completed).chain([target]);
        let nodes = nodes.filter(|node| *node == self.active || in_sight(node));
        let untried = nodes.filter(|node| !self.tried.contains(node));
        let paths = untried.map(|node| (self.distance(here, node) + paths.length(node), node));
        let best = paths.filter(|(length, _)| length.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((_, node)) if node != self.active => Some(State::Look { node }),
            _ if !self.tried.contains(&self.active) => Some(State::Go(self.back())),
            _ => None,
        }
    }

    /// The way that it came: nothing was in it.
    fn back(&self) -> Leg {
        let (to, node) = match self.trail.last() {
            Some(&place) => (place, None),
            None => (self.graph.place(self.active), Some(self.active)),
        };
        Leg { approach: Approach::new(to), node, from: None, is_edge: false, is_seen: false }
    }
}

/// The additional length of a path that is worth sparing a turn of 1 rad, in metres: so little that it decides only
/// between nodes at the same distance.
const TURN_COSTS_M: f64 = 0.05;
