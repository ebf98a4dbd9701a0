//! The floor of an arena as cells, and what it refuses.

use alloc::vec::Vec;

use baudbot_geometry::grid::{Cell, Grid, MARGIN};
use baudbot_geometry::{Bounds, Index, Point, math};

use super::bits::Bits;
use super::fill;
use crate::arena::Arena;

/// The most cells that a floor may have.
pub(super) const MAX_CELLS: u64 = 4_000_000;

/// The cells of an arena's floor, and which of them are free. Made once, from the scenario; at least one is
/// free.
///
/// The cells are squares over the box around all shapes, counted from its lower left corner. A cell is
/// *free* if it can be reached from a robot's start: through cells whose centre is in no solid polygon and in
/// no pillar, with steps from centre to centre, right, left, up or down, that cross no wall. What is beyond
/// the border of the robots' room is not free, nor is a cell whose centre is on a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    grid: Grid,
    free: Bits,
}

/// A reason why an arena's floor cannot be divided.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FloorError {
    /// The floor has no bounds without shapes.
    #[error("coverage needs an arena with walls")]
    NoWalls,
    /// The side of a cell is invalid.
    #[error("must be between {MIN_CELL_M} and {MAX_CELL_M}, is {cell_m}")]
    CellSize {
        /// The side, in metres.
        cell_m: f64,
    },
    /// The floor would need too much memory.
    #[error("{cell_m} makes {cells} cells, the limit is {MAX_CELLS}; {fitting_m} would fit")]
    TooManyCells {
        /// The side of a cell, in metres.
        cell_m: f64,
        /// The number of cells that this makes.
        cells: u64,
        /// The least side with two digits, in metres, that would do.
        fitting_m: f64,
    },
    /// There are so many walls or pillars that the floor would take too long to divide.
    #[error(
        "{cell_m} makes walls and pillars pass {cells} cells, the limit is {MAX_WALL_CELLS}; \
         {fitting_m} would fit"
    )]
    TooMuchWall {
        /// The side of a cell, in metres.
        cell_m: f64,
        /// The number of cells that the walls pass one after the other, a pillar as two walls across it.
        cells: u64,
        /// The least side with two digits, in metres, that would do.
        fitting_m: f64,
    },
    /// The cells are too large for the room, or no robot is near the walls at all.
    #[error("{cell_m} makes no cell whose centre a robot can reach from its start; smaller cells might")]
    NothingFree {
        /// The side of a cell, in metres.
        cell_m: f64,
    },
}

impl Floor {
    /// The bytes that it has on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.free.heap_bytes()
    }

    /// Divides the floor of an arena into cells with a side of `cell_m` metres. `starts` are the places of
    /// the robots at the start; each one's room is counted.
    ///
    /// # Errors
    /// See [`FloorError`].
    pub fn new(arena: &Arena, cell_m: f64, starts: &[Point]) -> Result<Self, FloorError> {
        let bounds = arena.index().bounds().ok_or(FloorError::NoWalls)?;
        if !(MIN_CELL_M..=MAX_CELL_M).contains(&cell_m) {
            return Err(FloorError::CellSize { cell_m });
        }
        is_affordable(&bounds, arena.index(), cell_m)?;
        let grid = Grid::over(&bounds, cell_m);
        let free = fill::free(arena, &grid, starts);
        if free.count() == 0 {
            return Err(FloorError::NothingFree { cell_m });
        }
        Ok(Self { grid, free })
    }

    /// The lower left corner of the grid, in metres.
    #[must_use]
    pub fn corner(&self) -> Point {
        self.grid.origin
    }

    /// The side of a cell, in metres.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.grid.cell_m
    }

    /// The number of columns of the grid.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.grid.cells.columns as usize
    }

    /// The number of rows of the grid.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.grid.cells.rows as usize
    }

    /// The centre of a cell, in metres.
    #[must_use]
    pub fn center(&self, column: usize, row: usize) -> Point {
        self.grid.center(Cell { column: column as i32, row: row as i32 })
    }

    /// Whether the cell is free. There is none beyond the grid.
    #[must_use]
    pub fn is_free(&self, column: usize, row: usize) -> bool {
        self.number(column, row).is_some_and(|number| self.free.contains(number))
    }

    /// The number of free cells: at least one.
    #[must_use]
    pub fn free_cells(&self) -> usize {
        self.free.count()
    }

    /// The free cells as lengths of runs, row by row from the lower left: so many that are not free, so many that
    /// are, and so on. They add up to all cells of the grid.
    #[must_use]
    pub fn free_runs(&self) -> Vec<u32> {
        self.free.runs(self.grid.cells.count())
    }

    /// The number of a cell, if the grid has it.
    pub(super) fn number(&self, column: usize, row: usize) -> Option<usize> {
        let cell = Cell { column: column.try_into().ok()?, row: row.try_into().ok()? };
        self.grid.cells.number(cell)
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    pub(super) fn free(&self) -> &Bits {
        &self.free
    }
}

/// Whether there are neither too many cells nor too many along all walls.
fn is_affordable(bounds: &Bounds, shapes: &Index, cell_m: f64) -> Result<(), FloorError> {
    let cells = |cell_m: f64| {
        let (columns, rows) = Grid::size(bounds, cell_m, MARGIN);
        columns * rows
    };
    if cells(cell_m) > MAX_CELLS as f64 {
        let fitting_m = fitting(|cell_m| cells(cell_m) <= MAX_CELLS as f64);
        return Err(FloorError::TooManyCells { cell_m, cells: cells(cell_m) as u64, fitting_m });
    }
    let walls: f64 = shapes.segments().iter().map(|wall| (wall.end - wall.start).abs().sum()).sum();
    let pillars: f64 = shapes.circles().iter().map(|circle| 4.0 * circle.radius).sum();
    let passed = |cell_m: f64| math::ceil((walls + pillars) / cell_m);
    if passed(cell_m) > MAX_WALL_CELLS as f64 {
        let fitting_m = fitting(|cell_m| passed(cell_m) <= MAX_WALL_CELLS as f64);
        return Err(FloorError::TooMuchWall { cell_m, cells: passed(cell_m) as u64, fitting_m });
    }
    Ok(())
}

/// The least number with two digits that fits, if all that are larger than one that fits do.
fn fitting(fits: impl Fn(f64) -> bool) -> f64 {
    let mut sizes = (-7..=4).flat_map(|exponent| (10..100).map(move |digits| size(digits, exponent)));
    sizes.find(|&size| fits(size)).unwrap_or(MAX_CELL_M)
}

/// Made by one division or multiplication of whole numbers, so that it is printed with two digits only.
fn size(digits: u32, exponent: i32) -> f64 {
    let power = 10_u32.pow(exponent.unsigned_abs());
    if exponent < 0 { f64::from(digits) / f64::from(power) } else { f64::from(digits) * f64::from(power) }
}

/// Walls and pillars may pass so many cells: one or two seconds' work.
const MAX_WALL_CELLS: u64 = 20_000_000;

const MIN_CELL_M: f64 = 1e-6;
const MAX_CELL_M: f64 = 1e6;

#[cfg(test)]
mod tests {
    use alloc::format;

    use super::*;

    #[test]
    fn the_fitting_size_is_the_least_with_two_digits() {
        let cases = [(0.0, "0.000001"), (0.002, "0.002"), (0.00501, "0.0051"), (0.0991, "0.1"), (7.0, "7")];
        for (least, text) in cases.into_iter().chain([(123.4, "130"), (9.9e5, "990000"), (1e9, "1000000")]) {
            assert_eq!(format!("{}", fitting(|size| size >= least)), text);
        }
    }
}
