//! The grid's division of the plane.
//!
//! All computations are in the *grid frame*: the origin is the grid's lower left corner, the axes are those
//! of the world. There, rounding errors are proportional to the size of the arena, and not to its distance
//! from the world's origin.

use core::ops::Range;

use crate::bounds::Bounds;
use crate::circle::Circle;
use crate::math;
use crate::pose::{Point, Vector};
use crate::segment::Segment;

/// Square cells, counted row by row from the lower left corner. It is no [`Grid`](crate::grid::Grid), whose module has
/// the reason.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    /// The lower left corner of the box around all shapes.
    min: Point,
    /// The side of a cell, in metres.
    cell: f64,
    columns: usize,
    rows: usize,
}

impl Layout {
    /// See [`Index::new`](super::Index::new) for the choice of the cell's side.
    pub(super) fn new(bounds: &Bounds, segments: &[Segment], circles: &[Circle]) -> Self {
        let size = bounds.size();
        assert!(size.norm().is_finite(), "shapes must be finite");
        let shapes = (segments.len() + circles.len()) as f64;
        let most_entries = ENTRIES_PER_SHAPE * shapes;
        let mut cell = first_cell(size, (CELLS_PER_SHAPE * shapes).min(MOST_CELLS));
        while entries(segments, circles, cell) > most_entries {
            cell *= 1.5;
        }
        // The corner keeps twice the margin, so that shapes on the border are inside by more than the margin.
        let count = |length: f64| (math::floor(length / cell + 4.0 * MARGIN) as usize) + 1;
        Self { min: bounds.min, cell, columns: count(size.x), rows: count(size.y) }
    }

    pub(super) fn cell(&self) -> f64 {
        self.cell
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    pub(super) fn grid_from_world(&self, point: Point) -> Vector {
        let inset = 2.0 * self.margin();
        point - self.min + Vector::new(inset, inset)
    }

    /// Whether the rounding errors of a ray from this origin may be as large as the margin.
    pub(super) fn is_far(&self, origin: Point) -> bool {
        let width = (self.columns + self.rows) as f64 * self.cell;
        let reach = origin.coords.abs().sum() + self.grid_from_world(origin).abs().sum() + width;
        ROUNDING * reach > self.margin()
    }

    /// The column of an x in the grid frame; the first or the last one for an x outside of the grid.
    pub(super) fn column(&self, x: f64) -> usize {
        place(x, self.cell, self.columns)
    }

    /// The row of a y in the grid frame; the first or the last one for a y outside of the grid.
    pub(super) fn row(&self, y: f64) -> usize {
        place(y, self.cell, self.rows)
    }

    /// Visits the cells that the segment touches, or misses by less than the margin, once each.
    pub(super) fn segment_cells(&self, segment: &Segment, mut visit: impl FnMut(usize)) {
        let [start, end] = [segment.start, segment.end].map(|end| Point::from(self.grid_from_world(end)));
        let in_grid = Segment { start, end };
        let around = Bounds::of_segment(&in_grid);
        let margin = self.margin();
        for row in self.row(around.min.y - margin)..=self.row(around.max.y + margin) {
            let (bottom, top) = (row as f64 * self.cell - margin, (row + 1) as f64 * self.cell + margin);
            let (left, right) = in_grid.x_range(bottom, top);
            for column in self.column(left - margin)..=self.column(right + margin) {
                visit(row * self.columns + column);
            }
        }
    }

    /// Visits the cells that the box around the circle touches, or misses by less than the margin, once each.
    pub(super) fn box_cells(&self, circle: &Circle, mut visit: impl FnMut(usize)) {
        let (columns, rows) = self.cells_of_box(circle);
        for row in rows {
            for column in columns.clone() {
                visit(row * self.columns + column);
            }
        }
    }

    /// The number of cells that the circle's box touches.
    pub(super) fn cells_in_box(&self, circle: &Circle) -> usize {
        let (columns, rows) = self.cells_of_box(circle);
        columns.len() * rows.len()
    }

    fn cells_of_box(&self, circle: &Circle) -> (Range<usize>, Range<usize>) {
        let center = self.grid_from_world(circle.center);
        let half = circle.radius + ROUNDING * (center.abs().sum() + circle.radius) + self.margin();
        let (low, high) = (center - Vector::new(half, half), center + Vector::new(half, half));
        let (width, height) = (self.columns as f64 * self.cell, self.rows as f64 * self.cell);
        let meets = low.x <= width && high.x >= 0.0 && low.y <= height && high.y >= 0.0;
        if !meets {
            return (0..0, 0..0);
        }
        (self.column(low.x)..self.column(high.x) + 1, self.row(low.y)..self.row(high.y) + 1)
    }

    /// The number of rings of cells, around any cell, that cover the grid.
    pub(super) fn rings(&self) -> usize {
        self.columns.max(self.rows)
    }

    /// Visits the cells that are `ring` rows or columns away from the cell of `point` (or from the cell
    /// nearest to it), and nearer than that in the other axis.
    pub(super) fn ring_cells(&self, point: Point, ring: usize, mut visit: impl FnMut(usize)) {
        let center = self.grid_from_world(point);
        let (column, row) = (self.column(center.x), self.row(center.y));
        let left = column.saturating_sub(ring);
        let right = (column + ring).min(self.columns - 1);
        for this in row.saturating_sub(ring)..=(row + ring).min(self.rows - 1) {
            let first = this * self.columns;
            if this.abs_diff(row) == ring {
                (left..=right).for_each(|column| visit(first + column));
            } else {
                column.checked_sub(ring).into_iter().for_each(|column| visit(first + column));
                Some(column + ring).filter(|&c| c < self.columns).into_iter().for_each(|c| visit(first + c));
            }
        }
    }

    fn margin(&self) -> f64 {
        MARGIN * self.cell
    }
}

/// The side of the cells that divide a box into about as many cells as wanted, and not more than twice as
/// many and one.
fn first_cell(size: Vector, cells: f64) -> f64 {
    // The second term is for a box that is thin in one axis, up to a mere line.
    let square = math::sqrt(size.x / cells * size.y);
    let thin = (size.x + size.y) / cells;
    let side = if square > thin { square } else { thin };
    if side > 0.0 { side } else { 1.0 }
}

/// About how many entries the lists of all cells have together. Each is counted generously, but a wall that
/// runs within the margin along a border of cells is listed on both sides of it.
fn entries(segments: &[Segment], circles: &[Circle], cell: f64) -> f64 {
    let straight: f64 =
        segments.iter().map(|segment| (segment.end - segment.start).abs().sum() / cell + 3.0).sum();
    let round: f64 =
        circles.iter().map(|circle| 2.0 * circle.radius / cell + 2.0).map(|side| side * side).sum();
    straight + round
}

fn place(coordinate: f64, cell: f64, count: usize) -> usize {
    // The conversion rounds down, and takes negative numbers and NaN to 0.
    ((coordinate / cell) as usize).min(count - 1)
}

/// More cells than this for a shape cost more to walk than they save.
const CELLS_PER_SHAPE: f64 = 2.0;

/// With [`first_cell`], this bounds the grid to a million cells.
const MOST_CELLS: f64 = 500_000.0;

/// A segment in general position has about 3 entries; this allows for walls through many cells.
const ENTRIES_PER_SHAPE: f64 = 16.0;

/// The margin (see the parent module) as a part of a cell's side.
const MARGIN: f64 = 1e-6;

/// A generous bound on the relative rounding error of the computations along a ray.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;

    fn segment(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
        Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) }
    }

    fn layout(segments: &[Segment], circles: &[Circle]) -> Layout {
        let round = circles.iter().map(Bounds::of_circle);
        let bounds = segments.iter().map(Bounds::of_segment).chain(round).reduce(|a, b| a.union(&b));
        Layout::new(&bounds.expect("shapes"), segments, circles)
    }

    #[test]
    fn memory_is_bounded_for_walls_through_the_whole_arena() {
        let walls: Vec<_> =
            (0..2000).map(|i| segment(0.0, f64::from(i), 2000.0, 2000.0 - f64::from(i))).collect();
        let layout = layout(&walls, &[]);
        let mut found = 0;
        walls.iter().for_each(|wall| layout.segment_cells(wall, |_| found += 1));
        assert!(found <= 16 * walls.len(), "{found}");
        assert!(layout.columns * layout.rows <= 4 * walls.len() + 1);
    }

    #[test]
    fn lines_and_points_have_few_cells() {
        let row: Vec<_> = (0..1000).map(|i| segment(f64::from(i), 0.0, f64::from(i) + 1.0, 0.0)).collect();
        let line = layout(&row, &[]);
        assert!(line.rows == 1 && line.columns > 1000 && line.columns <= 4001);
        let point = layout(&[segment(1.0, 1.0, 1.0, 1.0)], &[]);
        assert_eq!((point.columns, point.rows), (1, 1));
    }

    #[test]
    fn a_wall_is_listed_where_a_sample_of_its_points_lies() {
        let walls =
            vec![segment(0.0, 0.0, 9.0, 7.0), segment(9.0, 0.5, 0.3, 6.0), segment(0.0, 3.5, 9.0, 3.5)];
        let fine = Layout { cell: 0.25, columns: 37, rows: 29, ..layout(&walls, &[]) };
        for wall in &walls {
            let mut listed = vec![];
            fine.segment_cells(wall, |cell| listed.push(cell));
            for i in 0..=1000 {
                let p = fine.grid_from_world(wall.start + (wall.end - wall.start) * (f64::from(i) / 1000.0));
                assert!(listed.contains(&(fine.row(p.y) * fine.columns + fine.column(p.x))));
            }
        }
    }

    #[test]
    fn rings_cover_the_grid_once() {
        let grid = Layout { min: Point::origin(), cell: 1.0, columns: 5, rows: 3 };
        for (x, y) in [(0.5, 0.5), (2.5, 1.5), (4.5, 2.5), (-7.0, 1.0), (9.0, 9.0)] {
            let mut visits = vec![0; 15];
            (0..grid.rings())
                .for_each(|ring| grid.ring_cells(Point::new(x, y), ring, |cell| visits[cell] += 1));
            // Ring 0 is one cell, visited from its row; it must not be visited from its columns as well.
            assert!(visits.iter().all(|&n| n == 1), "{visits:?}");
        }
    }
}
