//! The plane in square cells, each free or blocked: the right panel of Fig. 6.5.

use baudbot_geometry::grid::{self, Cell, Rectangle};
use baudbot_geometry::{Bounds, Point, Vector};
use thiserror::Error;

/// Square cells, `columns` to the right and `rows` upwards, each of which is free or blocked.
///
/// Cells are numbered row by row. A grid has one cell or more and no more than [`Grid::MOST_CELLS`].
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    grid: grid::Grid,
    blocked: Vec<bool>,
}

/// A reason why there is no such grid.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// None or too many cells.
    #[error("a grid has 1 to {} cells, not {columns} columns by {rows} rows", Grid::MOST_CELLS)]
    Size {
        /// The requested number of columns.
        columns: usize,
        /// The requested number of rows.
        rows: usize,
    },
    /// A parameter outside its range.
    #[error("{name} must be {range}, not {found}")]
    Number {
        /// The name of the number.
        name: &'static str,
        /// The permitted values.
        range: &'static str,
        /// The number given.
        found: f64,
    },
    /// A map without a wall has no extent.
    #[error("the map has no walls; give it one, or the grid its bounds")]
    NoWalls,
    /// A character of a sketch.
    #[error("line {line}, column {column}: `{found}` is not a cell; write `.`, `#`, `S` or `T`")]
    Character {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The character.
        found: char,
    },
    /// A sketch with a ragged edge.
    #[error("line {line} has {found} cells, the first line {expected}")]
    Ragged {
        /// The line, from 1.
        line: usize,
        /// Cells of this line.
        found: usize,
        /// Cells of the first line.
        expected: usize,
    },
    /// A sketch with a start or a target too many, or without one that was asked for.
    #[error("there must be one `{mark}`; there are {found}")]
    Marks {
        /// `S` or `T`.
        mark: char,
        /// The number of such letters.
        found: usize,
    },
}

impl Grid {
    /// More cells than this are refused: the searches would take seconds, and gigabytes.
    pub const MOST_CELLS: usize = 1 << 24;

    /// A grid of free cells with sides of `cell_m` metres. `origin` is its corner with the least coordinates.
    ///
    /// # Errors
    /// If it has no cell or too many, or a number that is not finite, or no size.
    pub fn new(columns: usize, rows: usize, cell_m: f64, origin: Point) -> Result<Self, GridError> {
        let cells = columns.checked_mul(rows).filter(|cells| (1..=Self::MOST_CELLS).contains(cells));
        let cells = cells.ok_or(GridError::Size { columns, rows })?;
        check("cell_m", "positive", cell_m, cell_m > 0.0)?;
        check("origin's x", "finite", origin.x, true)?;
        check("origin's y", "finite", origin.y, true)?;
        let extent = Rectangle { first: Cell::default(), columns: columns as i32, rows: rows as i32 };
        Ok(Self { grid: grid::Grid { origin, cell_m, cells: extent }, blocked: vec![false; cells] })
    }

    /// The least grid of free cells that covers these bounds, from their least corner on.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn covering(bounds: &Bounds, cell_m: f64) -> Result<Self, GridError> {
        check("cell_m", "positive", cell_m, cell_m > 0.0)?;
        let (columns, rows) = grid::Grid::size(bounds, cell_m, ROUNDING);
        Self::new(columns as usize, rows as usize, cell_m, bounds.min)
    }

    /// The number of cells in a row.
    pub fn columns(&self) -> usize {
        self.grid.cells.columns as usize
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.grid.cells.rows as usize
    }

    /// Length of a cell's side, in metres.
    pub fn cell_m(&self) -> f64 {
        self.grid.cell_m
    }

    /// The corner with the least coordinates.
    pub fn origin(&self) -> Point {
        self.grid.origin
    }

    /// The cells that it has.
    pub fn extent(&self) -> Rectangle {
        self.grid.cells
    }

    /// All cells, row by row.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        self.grid.cells.cells()
    }

    /// Whether the cell belongs to the grid.
    pub fn contains(&self, cell: Cell) -> bool {
        self.grid.cells.contains(cell)
    }

    /// Whether the cell belongs to the grid and nothing blocks it.
    pub fn is_free(&self, cell: Cell) -> bool {
        self.grid.cells.number(cell).is_some_and(|number| !self.blocked[number])
    }

    /// Whether each cell is blocked, row by row.
    pub(crate) fn blocked(&self) -> &[bool] {
        &self.blocked
    }

    /// Blocks a cell. One outside of the grid is blocked anyway.
    pub fn block(&mut self, cell: Cell) {
        if let Some(number) = self.grid.cells.number(cell) {
            self.blocked[number] = true;
        }
    }

    /// The middle of a cell: half a side from its corner. [`grid::Grid::center`] rounds once less, but plans must stay
    /// the same to the last bit.
    pub fn center(&self, cell: Cell) -> Point {
        self.corner(cell) + Vector::new(0.5, 0.5) * self.grid.cell_m
    }

    /// The corner of a cell with the least coordinates.
    pub fn corner(&self, cell: Cell) -> Point {
        self.grid.corner(cell)
    }

    /// The cell in which a point lies; `None` outside of the grid. A point between two cells lies in the one with
    /// greater coordinates.
    pub fn cell_at(&self, point: Point) -> Option<Cell> {
        let place = self.grid.grid_from_world(point);
        // NaN would be in cell 0.
        let is_somewhere = !place.x.is_nan() && !place.y.is_nan();
        Some(Cell::at(place)).filter(|&cell| is_somewhere && self.contains(cell))
    }

    /// The number of cells.
    pub(crate) fn len(&self) -> usize {
        self.blocked.len()
    }

    /// The number of a cell in order.
    pub(crate) fn number(&self, cell: Cell) -> usize {
        self.grid.cells.number(cell).expect("a cell of this grid")
    }

    /// The cell of this number.
    pub(super) fn cell(&self, number: usize) -> Cell {
        self.grid.cells.cell(number)
    }
}

/// A number must be finite, and `good`.
pub(super) fn check(
    name: &'static str,
    range: &'static str,
    found: f64,
    good: bool,
) -> Result<(), GridError> {
    if good && found.is_finite() { Ok(()) } else { Err(GridError::Number { name, range, found }) }
}

/// Part of a cell by which a size may exceed a whole number of cells and still count as that.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_lies_in_the_cell_whose_middle_is_near() {
        let grid = Grid::new(4, 3, 0.5, Point::new(-1.0, 2.0)).unwrap();
        for cell in grid.cells() {
            assert_eq!(grid.cell_at(grid.center(cell)), Some(cell));
            assert_eq!(grid.cell(grid.number(cell)), cell);
        }
        assert_eq!(grid.cell_at(Point::new(-1.0, 2.0)), Some(Cell { column: 0, row: 0 }));
        for (x, y) in [(-1.01, 2.1), (1.0, 2.1), (0.0, 3.5), (f64::NAN, 2.1), (f64::INFINITY, 2.1)] {
            assert_eq!(grid.cell_at(Point::new(x, y)), None, "{x}, {y}");
        }
    }

    #[test]
    fn what_is_no_grid_is_refused_by_name() {
        let text = |columns, rows, cell_m: f64| {
            Grid::new(columns, rows, cell_m, Point::origin()).unwrap_err().to_string()
        };
        assert_eq!(text(0, 3, 0.1), "a grid has 1 to 16777216 cells, not 0 columns by 3 rows");
        assert_eq!(text(usize::MAX, 3, 0.1).split(", ").next(), Some("a grid has 1 to 16777216 cells"));
        assert_eq!(text(3, 3, 0.0), "cell_m must be positive, not 0");
        assert_eq!(text(3, 3, f64::NAN), "cell_m must be positive, not NaN");
        let huge = Bounds { min: Point::origin(), max: Point::new(1e300, 1.0) };
        assert!(matches!(Grid::covering(&huge, 0.1), Err(GridError::Size { .. })));
    }

    #[test]
    fn a_grid_covers_its_bounds_without_a_column_too_many() {
        let bounds = Bounds { min: Point::new(0.0, 0.0), max: Point::new(0.3, 0.35) };
        let grid = Grid::covering(&bounds, 0.1).unwrap();
        assert_eq!((grid.columns(), grid.rows()), (3, 4));
    }
}
