//! The results of a search: a path, or the reason that there is none.

use std::fmt;

use baudbot_geometry::Point;
use baudbot_geometry::grid::Cell;
use thiserror::Error;

use super::grid::Grid;

/// A path through a grid, and the cells that the search examined.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The path from the start to the target, both included: all cells one after the other, but of
    /// [`theta_star`](super::theta_star) only those where it turns.
    pub cells: Vec<Cell>,
    /// Length of the path from cell centre to cell centre, in metres.
    pub length_m: f64,
    /// The cells whose neighbours were examined, in this order, and at last the target.
    pub expanded: Vec<Cell>,
    /// The cells that were ever given a cost, in this order: light green in Figs. 6.8 and 6.10.
    pub touched: Vec<Cell>,
}

impl Plan {
    /// The centres of the cells of the path.
    pub fn points(&self, grid: &Grid) -> Vec<Point> {
        self.cells.iter().map(|&cell| grid.center(cell)).collect()
    }
}

/// A reason why there is no plan.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlanError {
    /// An end that is not in the grid.
    #[error("the {end} ({}, {}) is outside the grid of {columns} columns by {rows} rows", cell.column, cell.row)]
    Outside {
        /// The end that is at fault.
        end: End,
        /// The cell that it should have.
        cell: Cell,
        /// Columns of the grid.
        columns: usize,
        /// Rows of the grid.
        rows: usize,
    },
    /// An end, as a point, that is not in the grid.
    #[error("the {end} ({} m, {} m) is outside the map", point.x, point.y)]
    OffMap {
        /// The end that is at fault.
        end: End,
        /// The point that it should have.
        point: Point,
    },
    /// An end in a wall, or too near to one.
    #[error("the {end} is in the blocked cell ({}, {})", cell.column, cell.row)]
    Blocked {
        /// The end that is at fault.
        end: End,
        /// The blocked cell.
        cell: Cell,
    },
    /// Walls part the ends.
    #[error("no path leads from cell ({}, {}) to cell ({}, {})", start.column, start.row, target.column, target.row)]
    Unreachable {
        /// The cell at which it should begin.
        start: Cell,
        /// The cell at which it should end.
        target: Cell,
    },
    /// The walker of Fig. 6.7 has visited all neighbours. There may be a path.
    #[error("dead end in cell ({}, {}) after {moves} moves: all its neighbours were visited", cell.column, cell.row)]
    DeadEnd {
        /// The cell that it has reached.
        cell: Cell,
        /// The number of moves.
        moves: usize,
        /// The way until there, the start included.
        walked: Vec<Cell>,
        /// The cells that were examined, in this order: its path and the free neighbours of that.
        touched: Vec<Cell>,
    },
}

/// An end of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The beginning.
    Start,
    /// The destination.
    Target,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::Target => "target",
        })
    }
}

/// Both ends must be free cells.
pub(super) fn check_ends(grid: &Grid, start: Cell, target: Cell) -> Result<(), PlanError> {
    for (end, cell) in [(End::Start, start), (End::Target, target)] {
        if !grid.contains(cell) {
            return Err(PlanError::Outside { end, cell, columns: grid.columns(), rows: grid.rows() });
        }
        if !grid.is_free(cell) {
            return Err(PlanError::Blocked { end, cell });
        }
    }
    Ok(())
}
