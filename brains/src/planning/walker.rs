//! The best-first search of Fig. 6.7, step by step as it is printed.
//!
//! It is no search in a list of open nodes but a walk: from the current node to the unvisited neighbour that seems
//! nearest to the target, and never back. So in front of an obstacle it makes long detours, and where all
//! neighbours have been visited it stands still, though the target could be reached: the notes say that it may get
//! stuck. What it finds is a path, as long as the walk was.

use baudbot_geometry::grid::Cell;

use super::grid::Grid;
use super::heuristic::Penalised;
use super::moves::Moves;
use super::plan::{Plan, PlanError, check_ends};

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
    let heuristic = heuristic.into();
    check_ends(grid, start, target)?;
    let (mut visited, mut seen) = (vec![false; grid.len()], vec![false; grid.len()]);
    seen[grid.number(start)] = true;
    let (mut cells, mut touched, mut length) = (vec![start], vec![start], 0.0);
    let mut current = start;
    while current != target {
        visited[grid.number(current)] = true;
        let mut best = None;
        for (next, step) in moves.neighbours(grid, current).filter(|(next, _)| !visited[grid.number(*next)]) {
            if !std::mem::replace(&mut seen[grid.number(next)], true) {
                touched.push(next);
            }
            let cost = heuristic.estimate(grid, next, target);
            if best.is_none_or(|(_, _, least)| cost < least) {
                best = Some((next, step, cost));
            }
        }
        let Some((next, step, _)) = best else {
            let moves = cells.len() - 1;
            return Err(PlanError::DeadEnd { cell: current, moves, walked: cells, touched });
        };
        length += step;
        cells.push(next);
        current = next;
    }
    Ok(Plan { length_m: length * grid.cell_m(), expanded: cells.clone(), cells, touched })
}
