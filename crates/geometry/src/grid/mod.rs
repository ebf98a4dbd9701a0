//! Square cells of the plane.
//!
//! A [`Grid`] divides the plane into cells and has a [`Rectangle`] of them; both number cells row by row. Beyond that:
//!
//! | | cells |
//! |---|---|
//! | [`line()`], [`Rectangle::visit_line`], [`Grid::visit_line`] | that a straight line runs through, in order |
//! | [`line_of_sight`] | whether all that a straight line touches are free, in whole numbers |
//! | [`Grid::in_disc`], [`Grid::in_swept`], [`Grid::along`] | whose centres are in a shape, or that a segment touches |
//! | [`cover`] | as few rectangles |
//!
//! The [index](crate::index) of shapes divides the plane by itself: its cells have a margin around the shapes, so that
//! no rounding loses a hit, its frame is in metres, which spares a ray two divisions, and a ray's end is not known
//! before it is walked.

mod area;
mod cover;
mod line;
mod sight;

pub use area::MARGIN;
pub use cover::{Growth, cover};
pub use line::line;
pub use sight::line_of_sight;

use crate::bounds::Bounds;
use crate::math;
use crate::pose::{Point, Vector};

/// A square of the plane by its place in a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// The place of the cell along x.
    pub column: i32,
    /// The place of the cell along y.
    pub row: i32,
}

impl Cell {
    /// The cell around a point that is given in units of a cell's side.
    #[must_use]
    pub fn at(point: Point) -> Self {
        Self { column: floor(point.x), row: floor(point.y) }
    }

    /// The cell so many columns and rows away.
    #[must_use]
    pub fn offset(self, columns: i32, rows: i32) -> Self {
        Self { column: self.column.saturating_add(columns), row: self.row.saturating_add(rows) }
    }

    /// The square of the distance between two cells' centres, in cells.
    #[must_use]
    pub fn distance_squared(self, other: Self) -> i64 {
        let (x, y) = (self.column.abs_diff(other.column), self.row.abs_diff(other.row));
        i64::from(x) * i64::from(x) + i64::from(y) * i64::from(y)
    }

    /// The four cells that share a side with it: right, above, left, below.
    pub fn sides(self) -> impl Iterator<Item = Self> {
        [(1, 0), (0, 1), (-1, 0), (0, -1)].into_iter().map(move |(columns, rows)| self.offset(columns, rows))
    }
}

/// A rectangle of cells, numbered row by row from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rectangle {
    /// The cell with the least column and row.
    pub first: Cell,
    /// The number of columns, 0 or more.
    pub columns: i32,
    /// The number of rows, 0 or more.
    pub rows: i32,
}

impl Rectangle {
    /// The rectangle between two cells, both included.
    #[must_use]
    pub fn between(first: Cell, last: Cell) -> Self {
        Self { first, columns: last.column - first.column + 1, rows: last.row - first.row + 1 }
    }

    /// The cell with the greatest column and row, unless there is no cell.
    #[must_use]
    pub fn last(&self) -> Cell {
        self.first.offset(self.columns - 1, self.rows - 1)
    }

    /// The number of cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Whether it has this cell.
    #[must_use]
    pub fn contains(&self, cell: Cell) -> bool {
        self.number(cell).is_some()
    }

    /// The number of a cell; `None` if it is not one of these.
    #[must_use]
    #[inline]
    pub fn number(&self, cell: Cell) -> Option<usize> {
        let column = i64::from(cell.column) - i64::from(self.first.column);
        let row = i64::from(cell.row) - i64::from(self.first.row);
        let is_in =
            (0..i64::from(self.columns)).contains(&column) && (0..i64::from(self.rows)).contains(&row);
        is_in.then(|| row as usize * self.columns as usize + column as usize)
    }

    /// The cell of this number.
    ///
    /// # Panics
    /// If there is no cell at all.
    #[must_use]
    pub fn cell(&self, number: usize) -> Cell {
        let columns = self.columns as usize;
        self.first.offset((number % columns) as i32, (number / columns) as i32)
    }

    /// All cells in the order of their numbers.
    pub fn cells(self) -> impl Iterator<Item = Cell> {
        let Self { first, columns, rows } = self;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| first.offset(column, row)))
    }
}

/// The place of a grid's cells, and the range of them that it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The lower left corner of the cell in column 0 and row 0, in metres.
    pub origin: Point,
    /// The side of a cell, in metres.
    pub cell_m: f64,
    /// The cells that it has.
    pub cells: Rectangle,
}

impl Grid {
    /// The cells over a box from its lower left corner on; [`Grid::size`] is their number, with a tolerance of
    /// [`MARGIN`].
    #[must_use]
    pub fn over(bounds: &Bounds, cell_m: f64) -> Self {
        let (columns, rows) = Self::size(bounds, cell_m, MARGIN);
        let cells = Rectangle { first: Cell::default(), columns: columns as i32, rows: rows as i32 };
        Self { origin: bounds.min, cell_m, cells }
    }

    /// The columns and rows of cells of this side, in metres, that cover a box: at least one each. A box of four
    /// cells that is larger by less than `tolerance` cells has no fifth. Whole numbers, but they may be too large for
    /// an integer.
    #[must_use]
    pub fn size(bounds: &Bounds, cell_m: f64, tolerance: f64) -> (f64, f64) {
        let along = |length: f64| math::ceil(length / cell_m - tolerance).max(1.0);
        let size = bounds.size();
        (along(size.x), along(size.y))
    }

    /// The point in the *grid frame*: the lower left corner of cell (0, 0) is the origin, and a cell's side is 1. There,
    /// borders and centres of cells are exact.
    #[must_use]
    pub fn grid_from_world(&self, point: Point) -> Point {
        Point::from((point - self.origin) / self.cell_m)
    }

    /// The cell around a point, whether the grid has it or not. A point on a border lies in the cell with the greater
    /// place.
    #[must_use]
    pub fn cell_at(&self, point: Point) -> Cell {
        Cell::at(self.grid_from_world(point))
    }

    /// The centre of a cell, in metres.
    #[must_use]
    pub fn center(&self, cell: Cell) -> Point {
        let along = |place: i32| (f64::from(place) + 0.5) * self.cell_m;
        Point::new(self.origin.x + along(cell.column), self.origin.y + along(cell.row))
    }

    /// The lower left corner of a cell, in metres.
    #[must_use]
    pub fn corner(&self, cell: Cell) -> Point {
        self.origin + Vector::new(f64::from(cell.column), f64::from(cell.row)) * self.cell_m
    }
}

/// The greatest whole number that is not greater, or the one next to that that there is; what is not a number is 0.
pub(crate) fn floor(x: f64) -> i32 {
    // Towards zero. Conversions saturate.
    let whole = x as i32;
    whole.saturating_sub(i32::from(f64::from(whole) > x))
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    #[test]
    fn a_whole_number_is_that_of_the_rounded_float() {
        let large =
            [1e9, 2_147_483_646.5, 2_147_483_647.0, 2_147_483_647.5, 2_147_483_648.5, 1e300, f64::INFINITY];
        for x in [0.0, 1e-300, 0.3, 0.5, 1.0, 1.5, 7.999_999_999, f64::NAN].into_iter().chain(large) {
            for x in [x, -x] {
                assert_eq!(floor(x), math::floor(x) as i32, "{x}");
            }
        }
    }

    fn bounds(width: f64, height: f64) -> Bounds {
        Bounds { min: Point::origin(), max: Point::new(width, height) }
    }

    #[test]
    fn a_rounding_makes_no_column_more() {
        assert_eq!(2.1 / 0.3, 7.000000000000001);
        assert_eq!(Grid::size(&bounds(2.1, 0.9), 0.3, MARGIN), (7.0, 3.0));
        assert_eq!(Grid::size(&bounds(2.11, 0.0), 0.3, MARGIN), (8.0, 1.0), "a line has one row");
    }

    #[test]
    fn cells_and_numbers_are_each_others_inverse() {
        let cells = Rectangle::between(Cell { column: -2, row: 3 }, Cell { column: 1, row: 5 });
        assert_eq!((cells.columns, cells.rows, cells.count()), (4, 3, 12));
        let all: Vec<_> = cells.cells().collect();
        for (number, &cell) in all.iter().enumerate() {
            assert_eq!((cells.cell(number), cells.number(cell)), (cell, Some(number)));
        }
        assert_eq!((all[0], all[11]), (cells.first, cells.last()));
        for outside in [(-3, 4), (2, 4), (0, 2), (0, 6), (i32::MIN, i32::MAX)] {
            assert!(!cells.contains(Cell { column: outside.0, row: outside.1 }), "{outside:?}");
        }
        assert_eq!(Rectangle::default().cells().count(), 0);
    }

    #[test]
    fn a_point_lies_in_the_cell_whose_centre_is_near() {
        let cells = Rectangle { first: Cell::default(), columns: 4, rows: 3 };
        let grid = Grid { origin: Point::new(-1.0, 2.0), cell_m: 0.5, cells };
        for cell in grid.cells.cells() {
            assert_eq!(grid.cell_at(grid.center(cell)), cell);
            assert_eq!(grid.cell_at(grid.corner(cell)), cell);
        }
        assert_eq!(grid.cell_at(Point::new(-1.01, 2.1)), Cell { column: -1, row: 0 });
    }
}
