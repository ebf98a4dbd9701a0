//! Irregular graphs, whose nodes need not be equidistant: the left panel of Fig. 6.5, Section 6.2.1.
//!
//! ```text
//! c(a, b) = √((x_a − x_b)² + (y_a − y_b)²)        the cost of an edge, Section 6.2.1
//! ```
//!
//! The searches are those of Figs. 6.7 and 6.9 and A\*, by the loops that cells have, too.
//!
//! Deviations: edges can be followed in both directions, which the notes leave open. [`Heuristic::Octile`] and
//! [`Heuristic::Manhattan`] estimate too much where edges have any direction, so that A\* may miss the shortest path with them.

use std::collections::BTreeSet;

use baudbot_geometry::Point;
use thiserror::Error;

use super::best_first::{self, Found, Graph};
use super::heuristic::{Heuristic, Penalised};
use super::plan::End;
use super::search::Order;
use super::walker::Walk;

/// Nodes in the plane, counted from 0, and edges between them. The cost of an edge is its length.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeGraph {
    nodes: Vec<Point>,
    edges: Vec<[usize; 2]>,
    /// Of each node, those to which edges lead, in the order of the edges, with their lengths in metres.
    neighbours: Vec<Vec<(usize, f64)>>,
}

/// A reason why there is no such graph.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NodeGraphError {
    /// None or too many nodes.
    #[error("a graph has 1 to {most} nodes, not {nodes}")]
    Size {
        /// The most that there may be.
        most: usize,
        /// The number of nodes.
        nodes: usize,
    },
    /// Nodes of free space that would be too many.
    #[error("a spacing of {spacing_m} m makes more than {most} nodes; choose a greater one")]
    Spacing {
        /// The spacing, in metres.
        spacing_m: f64,
        /// The most nodes that there may be.
        most: usize,
    },
    /// A node without a place.
    #[error("node {node} has a coordinate that is not finite")]
    Place {
        /// The node.
        node: usize,
    },
    /// An edge to a node that is not there.
    #[error("edge {edge} leads to node {node}; there are {nodes} nodes, counted from 0")]
    NoNode {
        /// The edge, from 0.
        edge: usize,
        /// The node that is missing.
        node: usize,
        /// The number of nodes.
        nodes: usize,
    },
    /// An edge that leads nowhere.
    #[error("edge {edge} leads from node {node} to itself")]
    Loop {
        /// The edge, from 0.
        edge: usize,
        /// Its node.
        node: usize,
    },
    /// An edge that stands twice.
    #[error("edge {edge} joins the same nodes as an edge before it")]
    Twice {
        /// The second of the edges, from 0.
        edge: usize,
    },
}

/// A path over nodes, and the nodes that the search examined.
#[derive(Clone, Debug, PartialEq)]
pub struct NodePlan {
    /// The nodes from the start to the target, both included.
    pub nodes: Vec<usize>,
    /// Length of the path, in metres.
    pub length_m: f64,
    /// The nodes whose neighbours were examined, in this order, and at last the target.
    pub expanded: Vec<usize>,
    /// The nodes that were ever given a cost, in this order.
    pub touched: Vec<usize>,
}

/// A reason why there is no path over nodes.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NodePlanError {
    /// An end that is no node.
    #[error("the {end} is node {node}; there are {nodes} nodes, counted from 0")]
    NoNode {
        /// The end that is at fault.
        end: End,
        /// The node that is missing.
        node: usize,
        /// The number of nodes.
        nodes: usize,
    },
    /// No edges lead from one end to the other.
    #[error("no path leads from node {start} to node {target}")]
    Unreachable {
        /// The node at which it should begin.
        start: usize,
        /// The node at which it should end.
        target: usize,
    },
    /// The walker of Fig. 6.7 has visited all neighbours. There may be a path. The plan is its walk until there.
    #[error("dead end at node {} after {} moves: all its neighbours were visited", walked.nodes.last().unwrap_or(&0), walked.nodes.len() - 1)]
    DeadEnd {
        /// The walk.
        walked: NodePlan,
    },
}

impl NodeGraph {
    /// More nodes than this are refused: the searches would take seconds.
    pub const MOST_NODES: usize = 1 << 20;

    /// A graph of nodes and edges, each edge as the numbers of its nodes.
    ///
    /// # Errors
    /// If there is no node or too many, a place is not finite, or an edge has not two nodes that are there, or stands twice.
    pub fn new(nodes: Vec<Point>, edges: Vec<[usize; 2]>) -> Result<Self, NodeGraphError> {
        if !(1..=Self::MOST_NODES).contains(&nodes.len()) {
            return Err(NodeGraphError::Size { most: Self::MOST_NODES, nodes: nodes.len() });
        }
        if let Some(node) = nodes.iter().position(|place| !(place.x.is_finite() && place.y.is_finite())) {
            return Err(NodeGraphError::Place { node });
        }
        let (mut neighbours, mut joined) = (vec![Vec::new(); nodes.len()], BTreeSet::new());
        for (edge, &[a, b]) in edges.iter().enumerate() {
            if let Some(&node) = [a, b].iter().find(|node| **node >= nodes.len()) {
                return Err(NodeGraphError::NoNode { edge, node, nodes: nodes.len() });
            }
            if a == b {
                return Err(NodeGraphError::Loop { edge, node: a });
            }
            if !joined.insert([a.min(b), a.max(b)]) {
                return Err(NodeGraphError::Twice { edge });
            }
            let length_m = Heuristic::Euclidean.between(nodes[a], nodes[b]);
            neighbours[a].push((b, length_m));
            neighbours[b].push((a, length_m));
        }
        Ok(Self { nodes, edges, neighbours })
    }

    /// The places of the nodes.
    pub fn nodes(&self) -> &[Point] {
        &self.nodes
    }

    /// The edges, as the numbers of their nodes.
    pub fn edges(&self) -> &[[usize; 2]] {
        &self.edges
    }

    /// The node that is nearest to a point; of two, the first.
    pub fn nearest(&self, point: Point) -> usize {
        let distance_m = |node: usize| Heuristic::Euclidean.between(self.nodes[node], point);
        let nearer = |best, node| if distance_m(node) < distance_m(best) { node } else { best };
        (0..self.nodes.len()).fold(0, nearer)
    }

    /// A shortest path, by Dijkstra's algorithm: Fig. 6.9.
    ///
    /// # Errors
    /// If an end is no node, or no path leads from one to the other.
    pub fn dijkstra(&self, start: usize, target: usize) -> Result<NodePlan, NodePlanError> {
        self.search(start, target, Order::Cost)
    }

    /// A shortest path, by A\*, if the heuristic never estimates too much.
    ///
    /// # Errors
    /// As [`Self::dijkstra`].
    pub fn a_star(
        &self,
        start: usize,
        target: usize,
        heuristic: Heuristic,
    ) -> Result<NodePlan, NodePlanError> {
        self.search(start, target, Order::Sum(heuristic.into()))
    }

    /// Some path, by best-first search with a list of open nodes.
    ///
    /// # Errors
    /// As [`Self::dijkstra`].
    pub fn greedy(
        &self,
        start: usize,
        target: usize,
        heuristic: Heuristic,
    ) -> Result<NodePlan, NodePlanError> {
        self.search(start, target, Order::Estimate(heuristic.into()))
    }

    /// A walk by Fig. 6.7. Of neighbours that seem equally near, the one of the first edge is taken.
    ///
    /// # Errors
    /// [`NodePlanError::DeadEnd`] if it gets stuck, or if an end is no node.
    pub fn walk(&self, start: usize, target: usize, heuristic: Heuristic) -> Result<NodePlan, NodePlanError> {
        self.check_ends(start, target)?;
        let view = NodeView { graph: self, target, order: Order::Estimate(heuristic.into()) };
        let Walk { path, touched, length, end } = Walk::new(&view, self.nodes.len(), start, target);
        let walked = NodePlan { length_m: length, expanded: path.clone(), nodes: path, touched };
        if end == target { Ok(walked) } else { Err(NodePlanError::DeadEnd { walked }) }
    }

    fn search(&self, start: usize, target: usize, order: Order) -> Result<NodePlan, NodePlanError> {
        self.check_ends(start, target)?;
        let view = NodeView { graph: self, target, order };
        let mut search = best_first::Search::default();
        search.begin(&view, self.nodes.len(), start, target);
        let found = search.finish(&view).ok_or(NodePlanError::Unreachable { start, target })?;
        let Found { path: nodes, cost: length_m } = found;
        Ok(NodePlan { nodes, length_m, expanded: search.expanded, touched: search.touched })
    }

    fn check_ends(&self, start: usize, target: usize) -> Result<(), NodePlanError> {
        let nodes = self.nodes.len();
        let missing =
            [(End::Start, start), (End::Target, target)].into_iter().find(|(_, node)| *node >= nodes);
        missing.map_or(Ok(()), |(end, node)| Err(NodePlanError::NoNode { end, node, nodes }))
    }
}

/// The graph as a search sees it.
struct NodeView<'a> {
    graph: &'a NodeGraph,
    target: usize,
    order: Order,
}

impl Graph for NodeView<'_> {
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f64)> {
        self.graph.neighbours[node].iter().copied()
    }

    fn estimate(&self, node: usize) -> f64 {
        match self.order {
            Order::Cost => 0.0,
            Order::Sum(Penalised { heuristic, .. }) | Order::Estimate(Penalised { heuristic, .. }) => {
                heuristic.between(self.graph.nodes[node], self.graph.nodes[self.target])
            }
        }
    }

    fn rank(&self, cost: f64, estimate: f64) -> f64 {
        self.order.rank(cost, estimate)
    }
}

impl Heuristic {
    /// The estimate between two points, in metres.
    fn between(self, from: Point, to: Point) -> f64 {
        self.over((from.x - to.x).abs(), (from.y - to.y).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planning::{Grid, Moves, Sketch, a_star, dijkstra, greedy, walk};

    /// Two ways from 0 to 4, past the corners of triangles of 3, 4 and 5: 8 m over 1, 2 and 3, and √18 m + 4 m over 5. Node 6 is a
    /// spur.
    fn ring() -> NodeGraph {
        let nodes = [(0.0, 0.0), (1.5, 2.0), (3.0, 4.0), (3.0, 2.0), (3.0, 1.0), (3.0, -3.0), (2.5, 0.5)];
        let nodes = nodes.map(|(x, y)| Point::new(x, y)).to_vec();
        NodeGraph::new(nodes, vec![[0, 1], [1, 2], [2, 3], [3, 4], [0, 5], [5, 4], [0, 6]]).unwrap()
    }

    /// An irregular graph of Section 6.2.1.
    #[test]
    fn lengths_are_those_of_triangles() {
        let graph = ring();
        let shortest = graph.dijkstra(0, 4).unwrap();
        assert_eq!((shortest.nodes.as_slice(), shortest.length_m), (&[0, 1, 2, 3, 4][..], 8.0));
        let around = graph.dijkstra(5, 0).unwrap();
        assert!((around.length_m - 18.0_f64.sqrt()).abs() < 1e-12, "{around:?}");
        assert_eq!(graph.a_star(0, 4, Heuristic::Euclidean).unwrap().nodes, shortest.nodes);
        assert_eq!(graph.nearest(Point::new(2.4, 0.4)), 6);
    }

    #[test]
    fn the_walker_ends_in_the_spur_that_seems_nearest() {
        let graph = ring();
        let Err(NodePlanError::DeadEnd { walked }) = graph.walk(0, 4, Heuristic::Euclidean) else {
            panic!("it should be stuck");
        };
        assert_eq!((walked.nodes.as_slice(), walked.touched.as_slice()), (&[0, 6][..], &[0, 1, 5, 6][..]));
        assert_eq!(graph.greedy(0, 4, Heuristic::Euclidean).unwrap().nodes.last(), Some(&4));
    }

    /// The nodes of a grid's cells, with the edges of its moves.
    fn lattice(grid: &Grid, moves: Moves) -> NodeGraph {
        let edges =
            |cell| moves.neighbours(grid, cell).map(|(next, step)| (grid.number(next), step)).collect();
        NodeGraph {
            nodes: grid.cells().map(|cell| grid.center(cell)).collect(),
            edges: Vec::new(),
            neighbours: grid.cells().map(edges).collect(),
        }
    }

    /// The middle and the right panel of Fig. 6.5 are equivalent, says its caption: a lattice of nodes and the grid of cells have the
    /// same paths, and their searches look at the same.
    #[test]
    fn a_lattice_of_nodes_is_equivalent_to_the_grid_of_cells() {
        for text in
            [include_str!("../../tests/data/grid-wall.txt"), include_str!("../../tests/data/grid-trap.txt")]
        {
            let Sketch { grid, start, target } = Grid::from_text(text).unwrap();
            let (start, target) = (start.unwrap(), target.unwrap());
            for moves in [Moves::Four, Moves::EightNoCut] {
                let graph = lattice(&grid, moves);
                let (from, to) = (grid.number(start), grid.number(target));
                let h = Heuristic::Euclidean;
                let pairs = [
                    (dijkstra(&grid, start, target, moves), graph.dijkstra(from, to)),
                    (a_star(&grid, start, target, moves, h), graph.a_star(from, to, h)),
                    (greedy(&grid, start, target, moves, h), graph.greedy(from, to, h)),
                    (walk(&grid, start, target, moves, h), graph.walk(from, to, h)),
                ];
                for (cells, nodes) in pairs {
                    let (cells, nodes) = (cells.unwrap(), nodes.unwrap());
                    let numbers =
                        |cells: &[_]| cells.iter().map(|&cell| grid.number(cell)).collect::<Vec<_>>();
                    assert_eq!(numbers(&cells.cells), nodes.nodes);
                    assert_eq!(numbers(&cells.expanded), nodes.expanded);
                    assert!((cells.length_m - nodes.length_m).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn what_is_no_graph_is_refused() {
        let place = |x| Point::new(x, 0.0);
        let text = |nodes: &[f64], edges| {
            NodeGraph::new(nodes.iter().map(|&x| place(x)).collect(), edges).unwrap_err().to_string()
        };
        assert_eq!(text(&[], vec![]), "a graph has 1 to 1048576 nodes, not 0");
        assert_eq!(text(&[0.0, f64::NAN], vec![]), "node 1 has a coordinate that is not finite");
        assert_eq!(
            text(&[0.0, 1.0], vec![[0, 1], [1, 2]]),
            "edge 1 leads to node 2; there are 2 nodes, counted from 0"
        );
        assert_eq!(text(&[0.0, 1.0], vec![[1, 1]]), "edge 0 leads from node 1 to itself");
        let twice = "edge 1 joins the same nodes as an edge before it";
        assert_eq!(text(&[0.0, 1.0], vec![[0, 1], [1, 0]]), twice);
        let graph = NodeGraph::new(vec![place(0.0), place(1.0)], vec![]).unwrap();
        let error = |start, target| graph.dijkstra(start, target).unwrap_err().to_string();
        assert_eq!(error(0, 1), "no path leads from node 0 to node 1");
        assert_eq!(error(0, 2), "the target is node 2; there are 2 nodes, counted from 0");
    }
}
