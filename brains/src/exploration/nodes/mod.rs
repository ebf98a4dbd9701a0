//! Exploration by nodes: Wahde 2016, §6.1, after Wahde and Sandberg, AMiRE 2009.
//!
//! The robot places pending nodes around itself, goes to the one that is nearest by the length of the path, and
//! places nodes again. What it reaches is completed, and what proximity keeps it from is unreachable. By the notes it is done
//! when no node is pending. Since nodes that are not unreachable are at least d apart, that is at some time the case in
//! any arena with walls.
//!
//! Between nodes it goes along the paths on which they were placed, but directly to a target within L if a scan shows
//! that nothing is in the way.
//!
//! *Deviations.*
//!
//! - At the start the robot places nodes, makes half a turn, and places nodes again. Otherwise one that looks at a wall
//!   at the start is done at once.
//! - The notes set the active node to one that was found unreachable. Here it stays the node from which the robot came,
//!   since that is where the paths are.
//! - The notes do not say how they avoid the deadlock of Fig. 6.3. Here a robot that is stopped between two nodes takes
//!   the path to be blocked in this direction only. It goes straight to that completed node in sight from which the
//!   path to the target is the shortest, or back.
//! - `γ_min` is as wide as the robot needs to pass at the distance D; the notes give no number. An interval that is wide enough
//!   in a room is not in a narrow corridor: there, and beside a table or a door's post, no node is placed though the robot fits.
//!   Nor does an unreachable node get another chance. So the robot keeps a map, too. When no node is pending, it goes by that to where
//!   it can see something [dark](super::frontiers), and places nodes there. It is done when there is no such place. Where it
//!   turned on the way, and where it looked, are completed nodes, however near to others.
//! - A robot between two nodes that can go to none from which there is a path to its target goes back to where it came from.
//!   There it looks all round, places nodes, and joins the node with all to which a path is clear. Where the pose is not
//!   true, places of nodes are wrong by as much as the map has moved since, and ways of the past are no longer open.
//! - A node is placed wherever another behaviour has driven the robot in between, however near to others, and the
//!   robot looks all round. If it sees none of the old ones the path is taken to be straight, until that proves wrong.

use std::f64::consts::PI;

use baudbot_geometry::{Point, Pose, angle};

use super::approach::{Approach, heading_to, turn};
use super::frontiers::{self, Frontiers};
use super::graph::{Graph, Status};
use super::{Command, Explorer, Failure, Goal, Input};
use crate::mapping::{Occupancy, PlacedScan, View};

mod led;
mod parameters;
mod route;

pub use parameters::Parameters;

/// A robot that explores by nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    parameters: Parameters,
    graph: Graph,
    map: Frontiers,
    /// The place of the node that the robot reached last.
    active: usize,
    target: Option<usize>,
    /// The nodes from which the direct way to the target was not passable.
    not_directly_from: Vec<usize>,
    /// The nodes that it could not reach since it was at the active node.
    tried: Vec<usize>,
    /// Nodes from which it has looked all round.
    looked_round: Vec<usize>,
    /// The places at which it has turned aside since then, between nodes.
    trail: Vec<Point>,
    /// There is a new scan.
    has_news: bool,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Start,
    /// The robot is at the active node, to place others around it and to see which can be gone to, once it faces this
    /// path; and then the same of what is behind it, if there is `more`.
    LookRound {
        heading_rad: f64,
        more: bool,
    },
    /// The robot is at the active node, which is new, to place others around it.
    Place,
    /// The robot is at a node or on the way, and the next command is to be chosen.
    Decide,
    /// Checks whether the direct way to a node is clear.
    Look {
        node: usize,
    },
    /// Follows the map, of which so many plans had ended before, to the end of a straight path.
    Led {
        ended: usize,
        leg: Option<Point>,
    },
    /// The robot is somewhere, after something else has driven it.
    Resume,
    Go(Leg),
    Ended(Command),
}

/// A straight path.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    approach: Approach,
    /// The node that is there; `None` if it is a place where the robot turned aside.
    node: Option<usize>,
    /// The node where it began; `None` if it began elsewhere.
    from: Option<usize>,
    /// Along a path of the graph.
    is_edge: bool,
    /// The map was asked whether it is clear.
    is_seen: bool,
}

impl Explorer for Nodes {
    fn step(&mut self, input: &Input<'_>) -> Command {
        if self.graph.nodes().len() > MOST_NODES {
            self.state = State::Ended(Command::Failed(Failure::TooLarge));
        }
        self.has_news = self.map.remember(input);
        loop {
            // Each turn of the loop reaches, blocks or gives up a node, so there are not many.
            if let Some(command) = self.advance(input) {
                return command;
            }
        }
    }

    fn interrupt(&mut self) {
        self.tried.clear();
        self.trail.clear();
        self.not_directly_from.clear();
        let is_over =
            matches!(self.state, State::Ended(command) if command != Command::Failed(Failure::Stuck));
        if !is_over {
            self.state = State::Resume;
        }
    }

    fn goal(&self, here: &Pose) -> Option<Goal> {
        if let State::Led { .. } = self.state {
            return self.map.goal(here);
        }
        let target = self.target.filter(|_| !matches!(self.state, State::Ended(_)))?;
        let paths = self.graph.paths_to(target);
        let left_m = match self.state {
            State::Go(Leg { approach, node, .. }) => {
                (approach.to - here.position).norm() + paths.length(node.unwrap_or(self.active))
            }
            State::Start
            | State::LookRound { .. }
            | State::Place
            | State::Decide
            | State::Look { .. }
            | State::Led { .. }
            | State::Resume
            | State::Ended(_) => self.distance(here, self.active) + paths.length(self.active),
        };
        Some(Goal { place: self.graph.place(target), left_m })
    }

    fn abandon(&mut self) {
        if let State::Led { .. } = self.state {
            self.map.abandon();
        } else if let Some(target) = self.target.take() {
            self.graph.give_up(target);
            self.state = State::Decide;
        }
    }

    fn finish(&mut self, here: &Pose) {
        self.map.interrupt();
        self.map.finish(here);
        self.state = State::Led { ended: self.map.ended(), leg: None };
    }

    fn grid(&self) -> &Occupancy {
        self.map.grid()
    }
}

impl Nodes {
    /// A robot at its start.
    #[must_use]
    pub fn new(parameters: Parameters) -> Self {
        Self {
            parameters,
            graph: Graph::default(),
            map: Frontiers::new(parameters.map),
            active: 0,
            target: None,
            not_directly_from: Vec::new(),
            tried: Vec::new(),
            looked_round: Vec::new(),
            trail: Vec::new(),
            has_news: false,
            state: State::Start,
        }
    }

    /// The nodes so far.
    #[must_use]
    pub fn graph(&self) -> &Graph {
        &self.graph
    }

    /// The node to which the robot is on its way, if there is one.
    #[must_use]
    pub fn target(&self) -> Option<usize> {
        self.target
    }

    /// The next command in this state; `None` if it has become another.
    fn advance(&mut self, input: &Input<'_>) -> Option<Command> {
        let here = &input.world_from_robot;
        match self.state {
            State::Start => self.state = State::LookRound { heading_rad: here.heading, more: true },
            State::LookRound { heading_rad, more } => return self.look_round(input, heading_rad, more),
            State::Place => {
                if let Some(wait) = self.place(input, here.heading) {
                    return Some(wait);
                }
                self.state = State::Decide;
            }
            State::Decide => self.state = self.decide(here),
            State::Look { node } => return self.look(input, node),
            State::Led { ended, leg } => return self.follow(input, ended, leg),
            State::Resume => self.state = self.resume(here),
            State::Go(leg) => return self.go(input, leg),
            State::Ended(command) => return Some(command),
        }
        None
    }

    /// Goes on from here: from a node, or from a new one, from which it looks all round. The robot has come there from where it
    /// was, so there is a path, if not a straight one.
    fn resume(&mut self, here: &Pose) -> State {
        if self.graph.nodes().is_empty() {
            return State::Start;
        }
        let is_here = |node: &usize| self.distance(here, *node) <= self.parameters.reach_m();
        let known = self.graph.having(Status::Completed).chain([self.active]);
        let nearest =
            known.filter(is_here).min_by(|a, b| self.distance(here, *a).total_cmp(&self.distance(here, *b)));
        if let Some(node) = nearest {
            self.active = node;
        } else {
            let new = self.graph.add_passed(here.position, Status::Pending);
            let from = std::mem::replace(&mut self.active, new);
            self.graph.join(from, self.active);
            self.target = None;
        }
        let is_known = self.graph.nodes()[self.active].status == Status::Completed;
        let is_interrupted = self.graph.nodes().len() == 1 && !self.looked_round.contains(&self.active);
        if is_known && !is_interrupted {
            return State::Decide;
        }
        State::LookRound { heading_rad: here.heading, more: true }
    }

    /// Places nodes around the active one by a scan in this direction; what to do until there is one.
    fn place(&mut self, input: &Input<'_>, heading_rad: f64) -> Option<Command> {
        let here = &input.world_from_robot;
        if let Some(turn) = turn(here, heading_rad) {
            return Some(turn);
        }
        let Some(scan) = input.scan.filter(|scan| self.is_from(scan, here)) else {
            return Some(Command::Wait);
        };
        if self.graph.nodes().is_empty() {
            self.active = self.graph.add(here.position, Status::Completed);
        }
        self.graph.complete(self.active, scan.clone());
        let placement = &self.parameters.placement;
        for place in placement.places(scan) {
            if self.graph.has_room(place, placement.separation_m) {
                let node = self.graph.add(place, Status::Pending);
                self.graph.join(self.active, node);
            }
        }
        None
    }

    /// The same as [`place`](Self::place), and joins the active node with those to which a path is seen to be clear.
    fn look_round(&mut self, input: &Input<'_>, heading_rad: f64, more: bool) -> Option<Command> {
        if let Some(turn) = self.place(input, heading_rad) {
            return Some(turn);
        }
        let Parameters { sight_m, .. } = self.parameters;
        self.graph.join_seen(self.active, sight_m, self.parameters.half_width_m());
        if more {
            self.state = State::LookRound { heading_rad: angle::wrap(heading_rad + PI), more: false };
        } else {
            self.looked_round.push(self.active);
            self.state = State::Decide;
        }
        None
    }

    /// Faces a node, and goes there if the scan shows a free way.
    fn look(&mut self, input: &Input<'_>, node: usize) -> Option<Command> {
        let here = &input.world_from_robot;
        if let Some(turn) = turn(here, heading_to(here, self.graph.place(node))) {
            return Some(turn);
        }
        let Some(scan) = input.scan.filter(|scan| self.is_from(scan, here)) else {
            return Some(Command::Wait);
        };
        if scan.view(self.graph.place(node), self.parameters.half_width_m()) != View::Clear {
            self.fail(node, false);
            return None;
        }
        let at_node = self.distance(here, self.active) <= self.parameters.reach_m();
        if !at_node {
            self.trail.push(here.position);
        }
        let (to, from) = (self.graph.place(node), at_node.then_some(self.active));
        self.state = State::Go(Leg {
            approach: Approach::new(to),
            node: Some(node),
            from,
            is_edge: false,
            is_seen: false,
        });
        None
    }

    fn go(&mut self, input: &Input<'_>, mut leg: Leg) -> Option<Command> {
        let here = &input.world_from_robot;
        let Some(command) = leg.approach.step(here, self.parameters.reach_m()) else {
            self.arrive(&leg);
            return None;
        };
        if input.near && matches!(command, Command::Drive { .. }) {
            self.fail(leg.node.unwrap_or(self.active), leg.is_edge);
            return None;
        }
        // A node is somewhere in a passage, and the robot somewhere at a node: it may come askew to a door.
        let is_new = !std::mem::replace(&mut leg.is_seen, true);
        if (is_new || self.has_news) && !self.map.is_straight(here.position, leg.approach.to) {
            self.fail(leg.node.unwrap_or(self.active), leg.is_edge);
            return None;
        }
        self.state = State::Go(leg);
        Some(command)
    }

    fn arrive(&mut self, leg: &Leg) {
        self.state = State::Decide;
        let Some(node) = leg.node else {
            self.trail.pop();
            return;
        };
        if let Some(from) = leg.from {
            self.graph.join(from, node);
        }
        self.active = node;
        self.tried.clear();
        self.trail.clear();
        if self.graph.nodes()[node].status == Status::Pending {
            self.state = State::Place;
        }
    }

    /// Something is in the way to a node.
    fn fail(&mut self, node: usize, is_edge: bool) {
        self.state = State::Decide;
        self.tried.push(node);
        self.not_directly_from.push(self.active);
        if is_edge {
            self.graph.block(self.active, node);
            if self.target == Some(node) {
                self.graph.give_up(node);
            }
        }
    }

    /// Whether a scan was taken where the robot is.
    fn is_from(&self, scan: &PlacedScan, here: &Pose) -> bool {
        scan.is_from(here, frontiers::HERE * self.parameters.map.radius_m)
    }

    fn distance(&self, here: &Pose, node: usize) -> f64 {
        (self.graph.place(node) - here.position).norm()
    }
}

/// More nodes than that are not an arena with walls.
const MOST_NODES: usize = 1000;

#[cfg(test)]
mod tests;
