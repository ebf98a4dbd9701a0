//! Theta\*: ways that turn by any angle, on a grid. Nash, Daniel, Koenig and Felner 2007; not in the notes.
//!
//! It is A\* with one thing more. A cell whose line of sight to the *predecessor* of the current cell is free is
//! reached from there in a straight line, so a path bends only at corners of walls. Such a path is nearly always
//! shorter than one in eight directions. It need not be the very shortest: only lines from one predecessor are
//! tried.

use std::task::Poll;

use baudbot_geometry::grid::Cell;

use super::best_first::{Graph, Search};
use super::grid::Grid;
use super::heuristic::Heuristic;
use super::moves::Moves;
use super::plan::{Plan, PlanError, check_ends};
use super::search::plan;
use super::sight::line_of_sight;

/// A short way that may turn by any angle; its cells are those where it does. Corners are not cut.
///
/// # Errors
/// If an end is outside the grid or blocked, or no path leads from one to the other.
pub fn theta_star(grid: &Grid, start: Cell, target: Cell) -> Result<Plan, PlanError> {
    plan(grid, &AnyAngle { grid, target }, start, target)
}

/// [`theta_star`] a few cells at a time, for brains that have little time in each step.
#[derive(Clone, Debug, Default)]
pub struct ThetaStar {
    /// The cells between which a path is being looked for.
    ends: Option<(Cell, Cell)>,
    search: Search,
}

impl ThetaStar {
    /// Looks for the path between two cells, and goes on with that if it is called again with the same ones and the same
    /// grid. It looks at the neighbours of no more cells than are `left`, and takes from that number those that it looked
    /// at. When it is ready it has the cells in which the path turns, with both ends.
    ///
    /// # Errors
    /// As [`theta_star`].
    pub fn seek(
        &mut self,
        grid: &Grid,
        [start, target]: [Cell; 2],
        left: &mut usize,
    ) -> Poll<Result<Vec<Cell>, PlanError>> {
        let graph = AnyAngle { grid, target };
        if self.ends != Some((start, target)) {
            check_ends(grid, start, target)?;
            self.search.begin(&graph, grid.len(), grid.number(start), grid.number(target));
            self.ends = Some((start, target));
        }
        self.search.advance(&graph, left).map(|found| {
            self.ends = None;
            let found = found.ok_or(PlanError::Unreachable { start, target })?;
            Ok(found.path.into_iter().map(|node| grid.cell(node)).collect())
        })
    }
}

struct AnyAngle<'a> {
    grid: &'a Grid,
    target: Cell,
}

impl Graph for AnyAngle<'_> {
    fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, f64)> {
        let neighbours = Moves::EightNoCut.neighbours(self.grid, self.grid.cell(node));
        neighbours.map(|(cell, step)| (self.grid.number(cell), step))
    }

    fn estimate(&self, node: usize) -> f64 {
        Heuristic::Euclidean.estimate(self.grid.cell(node), self.target)
    }

    fn straight(&self, predecessor: usize, node: usize) -> Option<f64> {
        Some(Heuristic::Euclidean.estimate(self.grid.cell(predecessor), self.grid.cell(node)))
    }

    fn sees(&self, from: usize, to: usize) -> bool {
        line_of_sight(self.grid, self.grid.cell(from), self.grid.cell(to))
    }
}
