//! Nodes and the ways between them: Wahde 2016, §6.1.
//!
//! *Deviation.* The notes speak of paths from node to node as the robot has placed them, which is a tree. Ways that
//! the robot has driven directly are added here, and the path is the shortest.

use baudbot_geometry::{Direction, Point, math};

use super::placement::{Aside, Placement};
use crate::mapping::{PlacedScan, View};

/// What has become of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Nobody was there yet.
    Pending,
    /// The robot was there.
    Completed,
    /// The robot tried to get there and something was in the way.
    Unreachable,
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Where it is, in metres in the world.
    pub place: Point,
    /// What has become of it.
    pub status: Status,
    /// The way to it was not seen whole.
    is_guess: bool,
    /// What was seen from it: once it is completed, the scans by which nodes were placed around it.
    scans: Vec<PlacedScan>,
    /// Nodes from which the robot has tried in vain to get there.
    tried_from: Vec<usize>,
    /// Nodes with a way to and from here.
    joined: Vec<usize>,
}

/// Nodes, each known by the number of nodes before it, and ways between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Graph {
    nodes: Vec<Node>,
    /// Ways that could not be gone, each from one node to another. The opposite direction may be open: Fig. 6.3.
    blocked: Vec<(usize, usize)>,
}

/// The shortest ways between one node, the root, and all others, in one direction.
pub(super) struct Ways {
    /// For each node the length in metres, and its neighbour on the way; infinite if there is no way.
    reached: Vec<(f64, usize)>,
}

impl Graph {
    /// All nodes.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Where a node is.
    pub(super) fn place(&self, node: usize) -> Point {
        self.nodes[node].place
    }

    /// The nodes of this status.
    pub(super) fn having(&self, status: Status) -> impl Iterator<Item = usize> {
        (0..self.nodes.len()).filter(move |&node| self.nodes[node].status == status)
    }

    pub(super) fn add(&mut self, place: Point, status: Status) -> usize {
        self.nodes.push(Node {
            place,
            status,
            is_guess: false,
            scans: Vec::new(),
            tried_from: Vec::new(),
            joined: Vec::new(),
        });
        self.nodes.len() - 1
    }

    /// Whether a node at this place is as far as it must be from all that are not unreachable.
    pub(super) fn has_room(&self, place: Point, separation_m: f64) -> bool {
        let near = |node: &Node| (node.place - place).norm() < separation_m;
        !self.nodes.iter().any(|node| node.status != Status::Unreachable && near(node))
    }

    /// A way between two nodes, open in both directions.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        for (from, to) in [(a, b), (b, a)] {
            if !self.nodes[from].joined.contains(&to) {
                self.nodes[from].joined.push(to);
            }
            self.blocked.retain(|way| *way != (from, to));
        }
    }

    /// Joins a node with all that its last scan shows a clear way to, within `sight_m`. A way that could not be gone stays
    /// what it is: what stopped the robot may be too low for the laser.
    pub(super) fn join_seen(&mut self, from: usize, sight_m: f64, half_width_m: f64) {
        let Some(scan) = self.nodes[from].scans.last() else { return };
        let is_seen = |to: &usize| {
            let Node { place, status, .. } = &self.nodes[*to];
            let is_open = *status != Status::Unreachable && !self.blocked.contains(&(from, *to));
            let is_near = (place - self.place(from)).norm() <= sight_m;
            *to != from && is_open && is_near && scan.view(*place, half_width_m) == View::Clear
        };
        let seen: Vec<_> = (0..self.nodes.len()).filter(is_seen).collect();
        seen.into_iter().for_each(|to| self.join(from, to));
    }

    /// The robot could not go this way.
    pub(super) fn block(&mut self, from: usize, to: usize) {
        self.blocked.push((from, to));
    }

    /// The robot is there and has seen this.
    pub(super) fn complete(&mut self, node: usize, scan: PlacedScan) {
        let Node { status, scans, .. } = &mut self.nodes[node];
        *status = Status::Completed;
        if scans.last() != Some(&scan) {
            scans.push(scan);
        }
    }

    /// The robot could not get there from this node.
    pub(super) fn give_up(&mut self, node: usize, from: usize) {
        self.nodes[node].status = Status::Unreachable;
        self.nodes[node].tried_from.push(from);
    }

    /// The shortest ways from all nodes to this one.
    pub(super) fn ways_to(&self, root: usize) -> Ways {
        self.search(root, |near, far| (far, near))
    }

    /// The shortest ways from this node to all.
    pub(super) fn ways_from(&self, root: usize) -> Ways {
        self.search(root, |near, far| (near, far))
    }

    /// Dijkstra's algorithm, simply, as there are few nodes. `way` says in which direction a way is gone between two
    /// nodes, of which the first is nearer to the root.
    fn search(&self, root: usize, way: impl Fn(usize, usize) -> (usize, usize)) -> Ways {
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
            for &far in joined.iter().filter(|far| !self.blocked.contains(&way(near, **far))) {
                let length = reached[near].0 + (self.place(far) - place).norm();
                if length < reached[far].0 {
                    reached[far] = (length, near);
                }
            }
        }
        Ways { reached }
    }

    /// Gives an unreachable node another chance: the one that is nearest, by the length of the path, from another side.
    /// There must be nothing but unreachable nodes within `separation_m` of it, and a completed node within `sight_m`
    /// from which nobody has tried, and from which there was nothing in the way. Says which node it is.
    pub(super) fn retry(&mut self, from: usize, retry: &Retry) -> Option<usize> {
        let mut best: Option<(f64, usize, usize)> = None;
        let ways = self.ways_from(from);
        for node in self.having(Status::Unreachable) {
            let Node { place, tried_from, .. } = &self.nodes[node];
            if tried_from.len() >= retry.attempts || !self.has_room(*place, retry.separation_m) {
                continue;
            }
            for side in self.having(Status::Completed).filter(|side| !tried_from.contains(side)) {
                let length = (self.place(side) - place).norm();
                let cost = length + ways.length(side);
                let is_better = cost.is_finite() && best.is_none_or(|(least, ..)| cost < least);
                if is_better && length <= retry.sight_m && self.saw(side, *place, retry.half_width_m) {
                    best = Some((cost, node, side));
                }
            }
        }
        let (_, node, side) = best?;
        self.nodes[node].status = Status::Pending;
        self.join(side, node);
        Some(node)
    }

    /// Places nodes where scans from completed nodes showed a clear way and there is none far and wide. Says whether it did.
    pub(super) fn look_again(&mut self, again: &Again) -> bool {
        let count = self.nodes.len();
        for from in self.having(Status::Completed).collect::<Vec<_>>() {
            for scan in 0..self.nodes[from].scans.len() {
                for place in again.places(&self.nodes[from].scans[scan]) {
                    let is_clear =
                        || self.nodes[from].scans[scan].view(place, again.half_width_m) == View::Clear;
                    if self.is_lonely(place, from, again) && is_clear() {
                        let node = self.add(place, Status::Pending);
                        self.join(from, node);
                    }
                }
            }
        }
        self.nodes.len() > count
    }

    /// Places nodes beside the ends of scans, if their last rays lead to what no other scan has seen. Says whether it did.
    pub(super) fn look_aside(&mut self, placement: &Placement, half_width_m: f64) -> bool {
        let count = self.nodes.len();
        for from in self.having(Status::Completed).collect::<Vec<_>>() {
            let scans = self.nodes[from].scans.iter().enumerate();
            let asides = scans
                .flat_map(|(i, scan)| placement.places_aside(scan).into_iter().map(move |aside| (i, aside)));
            for (scan, Aside { place, beyond }) in asides.collect::<Vec<_>>() {
                let was_tried = self.nodes.iter().any(|node| (node.place - place).norm() < half_width_m);
                let has_room = self.has_room(place, placement.separation_m);
                if has_room && !was_tried && !self.is_seen(beyond, (from, scan)) {
                    let node = self.add(place, Status::Pending);
                    self.nodes[node].is_guess = true;
                    self.join(from, node);
                }
            }
        }
        self.nodes.len() > count
    }

    /// Whether another scan than this one of this node has seen the place.
    fn is_seen(&self, place: Point, but: (usize, usize)) -> bool {
        let nodes = self.nodes.iter().enumerate();
        let mut scans =
            nodes.flat_map(|(i, node)| node.scans.iter().enumerate().map(move |(j, scan)| ((i, j), scan)));
        scans.any(|(which, scan)| which != but && scan.sees(place))
    }

    /// Whether the way to a node has to be looked at before it is gone.
    pub(super) fn is_guess(&self, node: usize) -> bool {
        self.nodes[node].is_guess && self.nodes[node].status == Status::Pending
    }

    /// Whether a place is far from all nodes but the one that it was seen from, and not one that was tried.
    fn is_lonely(&self, place: Point, from: usize, again: &Again) -> bool {
        let mut others = self.nodes.iter().enumerate().filter(|(node, _)| *node != from);
        others.all(|(_, node)| {
            let least_m = match node.status {
                Status::Unreachable => again.half_width_m,
                Status::Pending | Status::Completed => LONELY * again.distance_m,
            };
            (node.place - place).norm() >= least_m
        })
    }

    /// Whether a scan from this node showed a clear way to the place.
    fn saw(&self, node: usize, place: Point, half_width_m: f64) -> bool {
        self.nodes[node].scans.iter().any(|scan| scan.view(place, half_width_m) == View::Clear)
    }
}

/// When an unreachable node may be tried again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Retry {
    /// So often it is tried at most.
    pub(super) attempts: usize,
    pub(super) separation_m: f64,
    pub(super) sight_m: f64,
    pub(super) half_width_m: f64,
}

/// Where nodes are placed when nothing else is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Again {
    /// So far from a completed node, D, in metres.
    pub(super) distance_m: f64,
    pub(super) half_width_m: f64,
}

impl Again {
    /// Places at the distance from where this scan was taken, half a robot apart, that it could show.
    fn places(&self, scan: &PlacedScan) -> Vec<Point> {
        let step_rad = self.half_width_m / self.distance_m;
        let most = math::floor(0.5 * scan.scan.opening_rad / step_rad) as i32;
        let here = scan.world_from_robot;
        let place = |i: i32| {
            let direction = Direction::from_angle(here.heading + f64::from(i) * step_rad);
            here.position + direction.vector() * self.distance_m
        };
        (-most..=most).map(place).collect()
    }
}

/// Nodes of a second look are at least so many D from others: where there are some near, the laser has seen what there is.
const LONELY: f64 = 2.0;

impl Ways {
    /// Length of the way between the root and a node, in metres; infinite if there is none.
    pub(super) fn length(&self, node: usize) -> f64 {
        self.reached[node].0
    }

    /// The neighbour of a node on the way; `None` if there is no way or it is the root.
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
        let ways = graph().ways_to(3);
        assert!((ways.length(0) - 5_f64.sqrt()).abs() < 1e-12);
        assert_eq!((ways.next(0), ways.length(1), ways.next(1)), (Some(3), 2.0, Some(2)));
        assert_eq!((ways.length(3), ways.next(3)), (0.0, None));
    }

    #[test]
    fn a_way_is_blocked_in_one_direction_only() {
        let mut graph = graph();
        graph.block(0, 3);
        assert_eq!((graph.ways_to(3).length(0), graph.ways_to(3).next(0)), (3.0, Some(1)));
        assert_eq!(graph.ways_from(0).length(3), 3.0);
        assert_eq!(graph.ways_to(0).next(3), Some(0), "back it is open");
        graph.block(0, 1);
        assert_eq!(graph.ways_to(3).next(0), None);
        graph.join(0, 3);
        assert_eq!(graph.ways_to(3).next(0), Some(3), "open again");
    }

    #[test]
    fn unreachable_nodes_need_no_room() {
        let mut graph = graph();
        assert!(!graph.has_room(Point::new(2.0, 1.5), 0.75));
        graph.give_up(3, 2);
        assert!(graph.has_room(Point::new(2.0, 1.5), 0.75));
    }

    /// A scan of 60 degrees from the origin in this direction, with a ray each 2 degrees.
    fn scan(heading: f64, distance_m: impl Fn(usize) -> f64) -> PlacedScan {
        PlacedScan {
            world_from_robot: baudbot_geometry::Pose::new(0.0, 0.0, heading),
            scan: Scan {
                robot_from_laser: baudbot_geometry::Pose::new(0.0, 0.0, 0.0),
                opening_rad: 60_f64.to_radians(),
                range_m: 4.0,
                distances_m: (0..=30).map(distance_m).collect(),
            },
        }
    }

    #[test]
    fn a_way_that_the_scan_ended_in_is_looked_at_unless_another_has() {
        let placement = Placement { distance_m: 1.0, margin_m: 0.6, width_rad: 0.8, separation_m: 0.75 };
        // A gap of 20 degrees at the left end, of whose outermost rays nothing is known.
        let gap = || {
            scan(0.0, |ray| match ray {
                ..20 => 1.2,
                20..30 => 3.0,
                _ => f64::NAN,
            })
        };
        let mut graph = Graph::default();
        let here = graph.add(Point::new(0.0, 0.0), Status::Pending);
        graph.complete(here, scan(0.0, |_| 1.2));
        assert!(!graph.look_aside(&placement, 0.25), "a wall all along");
        let mut turned = graph.clone();
        graph.complete(here, gap());
        assert!(graph.look_aside(&placement, 0.25));
        let angle = 10_f64.to_radians() + 0.4;
        assert!((graph.place(1) - Point::new(angle.cos(), angle.sin())).norm() < 1e-12);
        assert!(graph.is_guess(1) && graph.nodes()[here].joined == [1]);
        assert!(!graph.look_aside(&placement, 0.25), "it is there");
        graph.give_up(1, here);
        assert!(!graph.look_aside(&placement, 0.25) && !graph.is_guess(1), "and was tried");
        turned.complete(here, gap());
        turned.complete(here, scan(0.6, |_| 3.0));
        assert!(!turned.look_aside(&placement, 0.25), "it has looked there, too");
        let mut graph = Graph::default();
        graph.add(Point::new(0.0, 0.0), Status::Pending);
        graph.complete(here, scan(0.0, |ray| if ray <= 10 { 3.0 } else { 1.2 }));
        assert!(graph.look_aside(&placement, 0.25));
        let angle = -angle;
        assert!((graph.place(1) - Point::new(angle.cos(), angle.sin())).norm() < 1e-12, "at the right end");
        let mut graph = Graph::default();
        for place in [Point::new(0.0, 0.0), Point::new(-3.0, 0.0)] {
            graph.add(place, Status::Pending);
        }
        graph.complete(here, gap());
        graph.complete(1, scan(30_f64.to_radians(), |_| 4.0));
        assert!(!graph.look_aside(&placement, 0.25), "the other has seen what is there");
    }

    #[test]
    fn what_is_seen_is_joined_but_not_what_stopped_somebody() {
        let mut graph = Graph::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (-1.0, 0.0), (3.5, 0.0), (1.5, -0.4)] {
            graph.add(Point::new(x, y), Status::Pending);
        }
        graph.complete(0, scan(0.0, |_| f64::INFINITY));
        graph.block(0, 2);
        graph.give_up(5, 1);
        graph.join_seen(0, 3.0, 0.1);
        assert_eq!(graph.nodes()[0].joined, [1], "2 is blocked, 3 behind, 4 far, 5 unreachable");
        graph.complete(1, scan(0.0, |_| 0.5));
        graph.join_seen(1, 3.0, 0.1);
        assert_eq!(graph.nodes()[1].joined, [0], "something is in the way");
    }

    #[test]
    fn a_node_is_tried_again_only_from_another_side_that_saw_it() {
        let mut graph = graph();
        let retry = Retry { attempts: 2, separation_m: 0.5, sight_m: 3.0, half_width_m: 0.1 };
        let scan = |x: f64, heading: f64| PlacedScan {
            world_from_robot: baudbot_geometry::Pose::new(x, 0.0, heading),
            scan: Scan {
                robot_from_laser: baudbot_geometry::Pose::new(0.0, 0.0, 0.0),
                opening_rad: 1.0,
                range_m: 4.0,
                distances_m: vec![f64::INFINITY; 3],
            },
        };
        graph.complete(2, scan(2.0, 1.57));
        graph.complete(1, scan(1.0, -1.57));
        graph.give_up(3, 2);
        assert_eq!(graph.retry(2, &retry), None, "2 was tried from, 1 looked away");
        graph.complete(0, scan(0.0, 0.4));
        assert_eq!(graph.retry(2, &retry), Some(3));
        assert_eq!(graph.nodes()[3].status, Status::Pending);
        graph.give_up(3, 0);
        graph.complete(1, scan(1.0, 0.8));
        assert_eq!(graph.retry(2, &retry), None, "two attempts were made");
    }
}
