//! Nodes and the paths between them: Wahde 2016, §6.1, Fig. 6.3.
//!
//! *Deviation.* The notes speak of paths from node to node as the robot has placed them, which is a tree. Ways that
//! the robot has driven directly are added here, and the path is the shortest.

use baudbot_geometry::Point;

use crate::mapping::{PlacedScan, View};

/// The state of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The robot was not there yet.
    Pending,
    /// The robot was there.
    Completed,
    /// The robot tried to get there and something was in the way.
    Unreachable,
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The node's place, in metres in the world.
    pub place: Point,
    /// The node's state.
    pub status: Status,
    /// The node was not placed by a scan: the robot has come there otherwise.
    is_passed: bool,
    /// The last scan from there.
    scan: Option<PlacedScan>,
    /// Nodes with a path to and from here.
    joined: Vec<usize>,
}

impl Node {
    /// Whether it was not placed: the robot has come there otherwise, however near to other nodes.
    #[cfg(test)]
    pub(super) const fn is_passed(&self) -> bool {
        self.is_passed
    }
}

/// Nodes, each known by the number of nodes before it, and ways between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    nodes: Vec<Node>,
    /// Ways that could not be gone, each from one node to another. The opposite direction may be open: Fig. 6.3.
    blocked: Vec<(usize, usize)>,
}

/// The shortest paths between one node, the root, and all others, in one direction.
pub(super) struct Paths {
    /// The length in metres to each node, and its neighbour on the way; infinite if there is no path.
    reached: Vec<(f64, usize)>,
}

impl Graph {
    /// All nodes.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The place of a node.
    pub(super) fn place(&self, node: usize) -> Point {
        self.nodes[node].place
    }

    /// The nodes of this status.
    pub(super) fn having(&self, status: Status) -> impl Iterator<Item = usize> {
        (0..self.nodes.len()).filter(move |&node| self.nodes[node].status == status)
    }

    pub(super) fn add(&mut self, place: Point, status: Status) -> usize {
        self.nodes.push(Node { place, status, is_passed: false, scan: None, joined: Vec::new() });
        self.nodes.len() - 1
    }

    /// Adds a place that the robot has come to though no node was placed there.
    pub(super) fn add_passed(&mut self, place: Point, status: Status) -> usize {
        let node = self.add(place, status);
        self.nodes[node].is_passed = true;
        node
    }

    /// Whether a node at this place is as far as it must be from all that are not unreachable.
    pub(super) fn has_room(&self, place: Point, separation_m: f64) -> bool {
        let near = |node: &Node| (node.place - place).norm() < separation_m;
        !self.nodes.iter().any(|node| node.status != Status::Unreachable && near(node))
    }

    /// A path between two nodes, open in both directions.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        for (from, to) in [(a, b), (b, a)] {
            if !self.nodes[from].joined.contains(&to) {
                self.nodes[from].joined.push(to);
            }
            self.blocked.retain(|path| *path != (from, to));
        }
    }

    /// Joins a node with all that its last scan shows a clear way to, within `sight_m`. A path that could not be gone stays
    /// what it is: what stopped the robot may be too low for the laser.
    pub(super) fn join_seen(&mut self, from: usize, sight_m: f64, half_width_m: f64) {
        let Some(scan) = &self.nodes[from].scan else { return };
        let is_seen = |to: &usize| {
            let Node { place, status, .. } = &self.nodes[*to];
            let is_open = *status != Status::Unreachable && !self.blocked.contains(&(from, *to));
            let is_near = (place - self.place(from)).norm() <= sight_m;
            *to != from && is_open && is_near && scan.view(*place, half_width_m) == View::Clear
        };
        let seen: Vec<_> = (0..self.nodes.len()).filter(is_seen).collect();
        seen.into_iter().for_each(|to| self.join(from, to));
    }

    /// The robot could not go this path.
    pub(super) fn block(&mut self, from: usize, to: usize) {
        self.blocked.push((from, to));
    }

    /// The robot is there and has seen this.
    pub(super) fn complete(&mut self, node: usize, scan: PlacedScan) {
        self.nodes[node].status = Status::Completed;
        self.nodes[node].scan = Some(scan);
    }

    /// The robot could not get there.
    pub(super) fn give_up(&mut self, node: usize) {
        self.nodes[node].status = Status::Unreachable;
    }

    /// The shortest paths from all nodes to this one.
    pub(super) fn paths_to(&self, root: usize) -> Paths {
        self.search(root, |near, far| (far, near))
    }

    /// The shortest paths from this node to all.
    pub(super) fn paths_from(&self, root: usize) -> Paths {
        self.search(root, |near, far| (near, far))
    }

    /// Dijkstra's algorithm, simply, as there are few nodes. `path` gives the direction of a way between two nodes, of
    /// which the first is nearer to the root.
    fn search(&self, root: usize, path: impl Fn(usize, usize) -> (usize, usize)) -> Paths {
        let mut reached = vec![(f64::INFINITY, root); self.nodes.len()];
        let mut open: Vec<usize> = (0..self.nodes.len()).collect();
        reached[root].0 = 0.0;
        let nearest = |open: &[usize], reached: &[(f64, usize)]| {
            (0..open.len()).min_by(|&a, &b| reached[open[a]].0.total_cmp(&reached[open[b]].0))
        };
        while let Some(place) = nearest(&open, &reached) {
            let near = open.swap_remove(place);
            if reached[near].0.is_infinite() {
                break;
            }
            let Node { place, joined, .. } = &self.nodes[near];
            for &far in joined.iter().filter(|far| !self.blocked.contains(&path(near, **far))) {
                let length = reached[near].0 + (self.place(far) - place).norm();
                if length < reached[far].0 {
                    reached[far] = (length, near);
                }
            }
        }
        Paths { reached }
    }
}

impl Paths {
    /// Length of the path between the root and a node, in metres; infinite if there is none.
    pub(super) fn length(&self, node: usize) -> f64 {
        self.reached[node].0
    }

    /// The neighbour of a node on the way; `None` if there is no path or it is the root.
    pub(super) fn next(&self, node: usize) -> Option<usize> {
        let (length, next) = self.reached[node];
        (length > 0.0 && length.is_finite()).then_some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Scan;

    /// 0 - 1 - 2 along x, and 3 above 2; 0 and 3 are also joined.
    fn graph() -> Graph {
        let mut graph = Graph::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0)] {
            graph.add(Point::new(x, y), Status::Pending);
        }
        for (a, b) in [(0, 1), (1, 2), (2, 3), (0, 3)] {
            graph.join(a, b);
        }
        graph
    }

    #[test]
    fn the_way_is_the_shortest() {
        let paths = graph().paths_to(3);
        assert!((paths.length(0) - 5_f64.sqrt()).abs() < 1e-12);
        assert_eq!((paths.next(0), paths.length(1), paths.next(1)), (Some(3), 2.0, Some(2)));
        assert_eq!((paths.length(3), paths.next(3)), (0.0, None));
    }

    /// The corner of Fig. 6.3.
    #[test]
    fn a_way_is_blocked_in_one_direction_only() {
        let mut graph = graph();
        graph.block(0, 3);
        assert_eq!((graph.paths_to(3).length(0), graph.paths_to(3).next(0)), (3.0, Some(1)));
        assert_eq!(graph.paths_from(0).length(3), 3.0);
        assert_eq!(graph.paths_to(0).next(3), Some(0), "back it is open");
        graph.block(0, 1);
        assert_eq!(graph.paths_to(3).next(0), None);
        graph.join(0, 3);
        assert_eq!(graph.paths_to(3).next(0), Some(3), "open again");
    }

    #[test]
    fn unreachable_nodes_need_no_room() {
        let mut graph = graph();
        assert!(!graph.has_room(Point::new(2.0, 1.5), 0.75));
        graph.give_up(3);
        assert!(graph.has_room(Point::new(2.0, 1.5), 0.75));
    }

    /// A scan of 60 degrees from the origin in this direction, with a ray each 2 degrees.
    fn scan(heading: f64, distance_m: impl Fn(usize) -> f64) -> PlacedScan {
        PlacedScan::new(
            baudbot_geometry::Pose::new(0.0, 0.0, heading),
            Scan {
                robot_from_laser: baudbot_geometry::Pose::new(0.0, 0.0, 0.0),
                opening_rad: 60_f64.to_radians(),
                range_m: 4.0,
                distances_m: (0..=30).map(distance_m).collect(),
            },
        )
    }

    #[test]
    fn what_is_seen_is_joined_but_not_what_stopped_somebody() {
        let mut graph = Graph::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (-1.0, 0.0), (3.5, 0.0), (1.5, -0.4)] {
            graph.add(Point::new(x, y), Status::Pending);
        }
        graph.complete(0, scan(0.0, |_| f64::INFINITY));
        graph.block(0, 2);
        graph.give_up(5);
        graph.join_seen(0, 3.0, 0.1);
        assert_eq!(graph.nodes()[0].joined, [1], "2 is blocked, 3 behind, 4 far, 5 unreachable");
        graph.complete(1, scan(0.0, |_| 0.5));
        graph.join_seen(1, 3.0, 0.1);
        assert_eq!(graph.nodes()[1].joined, [0], "something is in the way");
    }
}
