//! Dijkstra's algorithm, A\* and greedy best-first search: one loop, three orders of the open list.
//!
//! | search | takes first the node with the least | finds |
//! |---|---|---|
//! | [`dijkstra`], Fig. 6.9 | way from the start | a shortest path |
//! | [`a_star`] | way from the start + estimate of the path left | a shortest path, if no estimate is too large |
//! | [`greedy`] | estimate of the path left | some way |
//!
//! Deviations: the notes' best-first search of Fig. 6.7 has no open list and gets stuck; here it is
//! [`walk`](super::walk). Fig. 6.9 stops once the target has been reached, by which we mean once it is the current
//! node: a shorter way to it can be found until then.

use baudbot_geometry::grid::Cell;

use super::best_first::{self, Found, Graph};
use super::grid::Grid;
use super::heuristic::{Heuristic, Penalised};
use super::moves::Moves;
use super::plan::{Plan, PlanError, check_ends};

/// A shortest path, by Dijkstra's algorithm: Fig. 6.9.
///
/// # Errors
/// If an end is outside the grid or blocked, or no path leads from one to the other.
pub fn dijkstra(grid: &Grid, start: Cell, target: Cell, moves: Moves) -> Result<Plan, PlanError> {
    search(&Search { grid, target, moves, order: Order::Cost }, start)
}

/// A shortest path, by A\*: Dijkstra's algorithm drawn towards the target. The path is a shortest one if the
/// heuristic never estimates too much for the moves.
///
/// # Errors
/// As [`dijkstra`].
pub fn a_star(
    grid: &Grid,
    start: Cell,
    target: Cell,
    moves: Moves,
    heuristic: impl Into<Penalised>,
) -> Result<Plan, PlanError> {
    search(&Search { grid, target, moves, order: Order::Sum(heuristic.into()) }, start)
}

/// Some way, by greedy best-first search: always on from the cell that seems nearest to the target, of all that
/// were touched. It looks at few cells, and finds a path if there is one.
///
/// # Errors
/// As [`dijkstra`].
pub fn greedy(
    grid: &Grid,
    start: Cell,
    target: Cell,
    moves: Moves,
    heuristic: impl Into<Penalised>,
) -> Result<Plan, PlanError> {
    search(&Search { grid, target, moves, order: Order::Estimate(heuristic.into()) }, start)
}

/// The cheapest way by A\*, where a step costs its length times the mean of what its two cells cost, and what it costs, in
/// cells. `costs` has a number for each cell, 1 or more. Corners are not cut.
///
/// # Errors
/// As [`dijkstra`].
pub(crate) fn cheapest(
    grid: &Grid,
    costs: &[f64],
    start: Cell,
    target: Cell,
) -> Result<(Vec<Cell>, f64), PlanError> {
    let plan = plan(grid, &Weighted { grid, costs, target }, start, target)?;
    Ok((plan.cells, plan.length_m / grid.cell_m()))
}

struct Weighted<'a> {
    grid: &'a Grid,
    costs: &'a [f64],
    target: Cell,
}

impl Graph for Weighted<'_> {
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f64)> {
        let neighbours = Moves::EightNoCut.neighbours(self.grid, self.grid.cell(node));
        neighbours.map(move |(cell, step)| {
            let next = self.grid.number(cell);
            (next, 0.5 * step * (self.costs[node] + self.costs[next]))
        })
    }

    fn estimate(&self, node: usize) -> f64 {
        Heuristic::Octile.estimate(self.grid.cell(node), self.target)
    }
}

/// The graph of a grid's cells, as a search sees it.
pub(super) struct Search<'a> {
    pub(super) grid: &'a Grid,
    pub(super) target: Cell,
    pub(super) moves: Moves,
    pub(super) order: Order,
}

/// The order of the open list, with the heuristic that it needs.
#[derive(Clone, Copy)]
pub(super) enum Order {
    /// Dijkstra's algorithm.
    Cost,
    /// A\*.
    Sum(Penalised),
    /// Best-first search.
    Estimate(Penalised),
}

impl Order {
    /// The key of the list.
    pub(super) fn rank(self, cost: f64, estimate: f64) -> f64 {
        match self {
            Self::Cost => cost,
            Self::Sum(_) => cost + estimate,
            Self::Estimate(_) => estimate,
        }
    }
}

impl Graph for Search<'_> {
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f64)> {
        let neighbours = self.moves.neighbours(self.grid, self.grid.cell(node));
        neighbours.map(|(cell, step)| (self.grid.number(cell), step))
    }

    fn estimate(&self, node: usize) -> f64 {
        match self.order {
            Order::Cost => 0.0,
            Order::Sum(heuristic) | Order::Estimate(heuristic) => {
                heuristic.estimate(self.grid, self.grid.cell(node), self.target)
            }
        }
    }

    fn rank(&self, cost: f64, estimate: f64) -> f64 {
        self.order.rank(cost, estimate)
    }
}

fn search(search: &Search<'_>, start: Cell) -> Result<Plan, PlanError> {
    plan(search.grid, search, start, search.target)
}

/// Searches a graph whose nodes are the cells of a grid.
pub(super) fn plan(grid: &Grid, graph: &impl Graph, start: Cell, target: Cell) -> Result<Plan, PlanError> {
    check_ends(grid, start, target)?;
    let mut search = best_first::Search::default();
    search.begin(graph, grid.len(), grid.number(start), grid.number(target));
    let Found { path, cost } = search.finish(graph).ok_or(PlanError::Unreachable { start, target })?;
    let cells = |nodes: Vec<usize>| nodes.into_iter().map(|node| grid.cell(node)).collect();
    Ok(Plan {
        cells: cells(path),
        length_m: cost * grid.cell_m(),
        expanded: cells(search.expanded),
        touched: cells(search.touched),
    })
}
