//! The best-first search of Fig. 6.7, step by step as it is printed.
//!
//! It is no search in a list of open nodes but a walk: from the current node to the unvisited neighbour that seems
//! nearest to the target, and never back. So in front of an obstacle it makes long detours, and where all
//! neighbours have been visited it stands still, though the target could be reached: the notes say that it may get
//! stuck. What it finds is a path, as long as the walk was.

use baudbot_geometry::grid::Cell;

use super::best_first::Graph;
use super::grid::Grid;
use super::heuristic::Penalised;
use super::moves::Moves;
use super::plan::{Plan, PlanError, check_ends};
use super::search::{Order, Search};

/// Walks by Fig. 6.7. Of neighbours that seem equally near, the first in the order of [`Moves::neighbours`] is taken.
///
/// # Errors
/// [`PlanError::DeadEnd`] if it gets stuck, or if an end is outside the grid or blocked.
pub fn walk(
    grid: &Grid,
    start: Cell,
    target: Cell,
    moves: Moves,
    heuristic: impl Into<Penalised>,
) -> Result<Plan, PlanError> {
    check_ends(grid, start, target)?;
    let graph = Search { grid, target, moves, order: Order::Estimate(heuristic.into()) };
    let walk = Walk::new(&graph, grid.len(), grid.number(start), grid.number(target));
    let cells = |nodes: Vec<usize>| nodes.into_iter().map(|node| grid.cell(node)).collect::<Vec<_>>();
    let (end, moves) = (grid.cell(walk.end), walk.path.len() - 1);
    let (cells, touched) = (cells(walk.path), cells(walk.touched));
    if end != target {
        return Err(PlanError::DeadEnd { cell: end, moves, walked: cells, touched });
    }
    Ok(Plan { length_m: walk.length * grid.cell_m(), expanded: cells.clone(), cells, touched })
}

/// A walk over any graph. It is stuck if its end is not the target.
pub(super) struct Walk {
    pub(super) path: Vec<usize>,
    pub(super) touched: Vec<usize>,
    pub(super) length: f64,
    pub(super) end: usize,
}

impl Walk {
    /// Walks over a graph with so many nodes. Of equally good neighbours the first is taken.
    pub(super) fn new(graph: &impl Graph, nodes: usize, start: usize, target: usize) -> Self {
        let (mut visited, mut seen) = (vec![false; nodes], vec![false; nodes]);
        seen[start] = true;
        let mut walk = Self { path: vec![start], touched: vec![start], length: 0.0, end: start };
        while walk.end != target {
            visited[walk.end] = true;
            let mut best = None;
            for (next, step) in graph.neighbours(walk.end).filter(|(next, _)| !visited[*next]) {
                if !std::mem::replace(&mut seen[next], true) {
                    walk.touched.push(next);
                }
                let cost = graph.estimate(next);
                if best.is_none_or(|(_, _, least)| cost < least) {
                    best = Some((next, step, cost));
                }
            }
            let Some((next, step, _)) = best else { break };
            walk.length += step;
            walk.path.push(next);
            walk.end = next;
        }
        walk
    }
}
