//! Theta\*: ways that turn by any angle, on a grid. Nash, Daniel, Koenig and Felner 2007; not in the notes.
//!
//! It is A\* with one thing more. A cell whose line of sight to the *predecessor* of the current cell is free is
//! reached from there in a straight line, so a way bends only at corners of walls. Such a way is nearly always
//! shorter than one in eight directions. It need not be the very shortest: only lines from one predecessor are
//! tried.

use super::best_first::Graph;
use super::grid::{Cell, Grid};
use super::heuristic::Heuristic;
use super::moves::Moves;
use super::plan::{Plan, PlanError};
use super::search::plan;
use super::sight::line_of_sight;

/// A short way that may turn by any angle; its cells are those where it does. Corners are not cut.
///
/// # Errors
/// If an end is outside of the grid or blocked, or no way leads from one to the other.
pub fn theta_star(grid: &Grid, start: Cell, target: Cell) -> Result<Plan, PlanError> {
    plan(grid, &AnyAngle { grid, target }, start, target)
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

    fn shortcut(&self, predecessor: usize, node: usize) -> Option<f64> {
        let (from, to) = (self.grid.cell(predecessor), self.grid.cell(node));
        line_of_sight(self.grid, from, to).then(|| Heuristic::Euclidean.estimate(from, to))
    }
}
