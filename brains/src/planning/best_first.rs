//! The loop that all searches with an open list share: take the best node from the list, look at its neighbours.
//!
//! Ranks are compared first, then estimates (of equally good nodes the one nearer to the target), then the order in
//! which nodes came into the list. So the same graph gives the same way on every machine.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A graph with a target. Nodes are numbers from 0 on.
pub(super) trait Graph {
    /// The neighbours of a node, with the costs of the edges to them.
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f64)>;

    /// An estimate of the cost from a node to the target.
    fn estimate(&self, node: usize) -> f64;

    /// What the list is ordered by, of a node's cost from the start and its estimate. The least comes first.
    fn rank(&self, cost: f64, estimate: f64) -> f64 {
        cost + estimate
    }

    /// The cost of going straight to a node from the predecessor of its neighbour, if that is possible.
    fn shortcut(&self, _predecessor: usize, _node: usize) -> Option<f64> {
        None
    }
}

/// What a search has found.
pub(super) struct Found {
    /// Nodes from the start to the target.
    pub(super) path: Vec<usize>,
    /// Cost of the path.
    pub(super) cost: f64,
    /// Nodes that were taken from the list, in order; the target is the last.
    pub(super) expanded: Vec<usize>,
    /// Nodes that were put on the list, in order.
    pub(super) touched: Vec<usize>,
}

/// Searches a graph of so many nodes; `None` if no path leads to the target.
pub(super) fn best_first(graph: &impl Graph, nodes: usize, start: usize, target: usize) -> Option<Found> {
    let mut search = Search::new(nodes);
    search.reach(graph, start, start, 0.0);
    while let Some(node) = search.next() {
        if node == target {
            return Some(search.found(start, target));
        }
        let predecessor = search.predecessors[node];
        for (next, step) in graph.neighbours(node) {
            if search.visited[next] {
                continue;
            }
            let (from, step) = match graph.shortcut(predecessor, next) {
                Some(straight) => (predecessor, straight),
                None => (node, step),
            };
            let cost = search.costs[from] + step;
            if cost < search.costs[next] {
                search.reach(graph, from, next, cost);
            }
        }
    }
    None
}

struct Search {
    costs: Vec<f64>,
    predecessors: Vec<usize>,
    visited: Vec<bool>,
    /// Has a node twice if its cost became less; the second time it is visited already.
    open: BinaryHeap<Reverse<Entry>>,
    expanded: Vec<usize>,
    touched: Vec<usize>,
    entries: u64,
}

impl Search {
    fn new(nodes: usize) -> Self {
        Self {
            costs: vec![f64::INFINITY; nodes],
            predecessors: vec![0; nodes],
            visited: vec![false; nodes],
            open: BinaryHeap::new(),
            expanded: Vec::new(),
            touched: Vec::new(),
            entries: 0,
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

    fn found(self, start: usize, target: usize) -> Found {
        let mut path = vec![target];
        let mut node = target;
        while node != start {
            node = self.predecessors[node];
            path.push(node);
        }
        path.reverse();
        Found { path, cost: self.costs[target], expanded: self.expanded, touched: self.touched }
    }
}

/// A node on the list.
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
