//! The loop that all searches with an open list share: take the best node from the list, and examine its neighbours.
//!
//! Ranks are compared first, then estimates (of equally good nodes the one nearer to the target), then the order in
//! which nodes came into the list. So the same graph gives the same path on every machine.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::task::Poll;

/// A graph with a target. Nodes are numbers from 0 on.
pub(super) trait Graph {
    /// The neighbours of a node, with the costs of the edges to them.
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f64)>;

    /// An estimate of the cost from a node to the target.
    fn estimate(&self, node: usize) -> f64;

    /// The key of the list, by a node's cost from the start and its estimate. The least comes first.
    fn rank(&self, cost: f64, estimate: f64) -> f64 {
        cost + estimate
    }

    /// The cost of going straight to a node from the predecessor of its neighbour, if there is such a path where nothing is
    /// [in between](Self::sees); `None` if paths follow the edges.
    fn straight(&self, _predecessor: usize, _node: usize) -> Option<f64> {
        None
    }

    /// Whether nothing is between two nodes.
    fn sees(&self, _from: usize, _to: usize) -> bool {
        false
    }
}

/// The result of a search.
pub(super) struct Found {
    /// Nodes from the start to the target.
    pub(super) path: Vec<usize>,
    /// Cost of the path.
    pub(super) cost: f64,
}

/// A search that may be broken off after some nodes and taken up again. What it needs of memory it keeps for the next one.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    start: usize,
    target: usize,
    costs: Vec<f64>,
    predecessors: Vec<usize>,
    visited: Vec<bool>,
    /// Has a node twice if its cost became less; the second time it is visited already.
    open: BinaryHeap<Reverse<Entry>>,
    /// Nodes that were taken from the list, in order; a target that was found is the last.
    pub(super) expanded: Vec<usize>,
    /// Nodes that were put on the list, in order.
    pub(super) touched: Vec<usize>,
    entries: u64,
}

impl Search {
    /// Begins a search of a graph with so many nodes.
    pub(super) fn begin(&mut self, graph: &impl Graph, nodes: usize, start: usize, target: usize) {
        for node in self.touched.drain(..) {
            self.costs[node] = f64::INFINITY;
            self.visited[node] = false;
        }
        self.costs.resize(nodes, f64::INFINITY);
        self.predecessors.resize(nodes, 0);
        self.visited.resize(nodes, false);
        self.open.clear();
        self.expanded.clear();
        (self.start, self.target, self.entries) = (start, target, 0);
        self.reach(graph, start, start, 0.0);
    }

    /// Goes on by so many nodes at most as are `left`: pending if it is not at its end after them. At its end it has found
    /// a path, or knows that there is none.
    pub(super) fn advance(&mut self, graph: &impl Graph, left: &mut usize) -> Poll<Option<Found>> {
        while *left > 0 {
            *left -= 1;
            match self.next() {
                None => return Poll::Ready(None),
                Some(node) if node == self.target => return Poll::Ready(Some(self.found())),
                Some(node) => self.expand(graph, node),
            }
        }
        Poll::Pending
    }

    /// Goes on to its end: a path, or `None` if there is none.
    pub(super) fn finish(&mut self, graph: &impl Graph) -> Option<Found> {
        loop {
            if let Poll::Ready(found) = self.advance(graph, &mut { usize::MAX }) {
                return found;
            }
        }
    }

    /// Expands a node: visits its neighbours.
    fn expand(&mut self, graph: &impl Graph, node: usize) {
        let predecessor = self.predecessors[node];
        for (next, step) in graph.neighbours(node) {
            if self.visited[next] {
                continue;
            }
            let known = self.costs[next];
            let shorter = |straight: &f64| self.costs[predecessor] + straight < known;
            let (from, cost) = match graph.straight(predecessor, next) {
                // No path by this node can be shorter than one straight on from its predecessor.
                Some(straight) if !shorter(&straight) => continue,
                Some(straight) if graph.sees(predecessor, next) => {
                    (predecessor, self.costs[predecessor] + straight)
                }
                _ => (node, self.costs[node] + step),
            };
            if cost < known {
                self.reach(graph, from, next, cost);
            }
        }
    }

    /// Notes that a node can be reached at this cost, and puts it on the list.
    fn reach(&mut self, graph: &impl Graph, from: usize, node: usize, cost: f64) {
        if self.costs[node] == f64::INFINITY {
            self.touched.push(node);
        }
        self.costs[node] = cost;
        self.predecessors[node] = from;
        let estimate = graph.estimate(node);
        let rank = graph.rank(cost, estimate);
        self.open.push(Reverse(Entry { rank, estimate, order: self.entries, node }));
        self.entries += 1;
    }

    /// Visits the best node.
    fn next(&mut self) -> Option<usize> {
        loop {
            let Reverse(Entry { node, .. }) = self.open.pop()?;
            if !self.visited[node] {
                self.visited[node] = true;
                self.expanded.push(node);
                return Some(node);
            }
        }
    }

    fn found(&self) -> Found {
        let mut path = vec![self.target];
        let mut node = self.target;
        while node != self.start {
            node = self.predecessors[node];
            path.push(node);
        }
        path.reverse();
        Found { path, cost: self.costs[self.target] }
    }
}

/// A node on the list.
#[derive(Clone, Debug)]
struct Entry {
    rank: f64,
    estimate: f64,
    order: u64,
    node: usize,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_rank = self.rank.total_cmp(&other.rank);
        by_rank.then(self.estimate.total_cmp(&other.estimate)).then(self.order.cmp(&other.order))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}
