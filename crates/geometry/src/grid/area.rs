//! Cells in and along shapes.

use core::ops::Range;

use super::{Cell, Grid};
use crate::bounds::Bounds;
use crate::circle::Circle;
use crate::math;
use crate::pose::Point;
use crate::segment::Segment;

impl Grid {
    /// Visits the numbers of the cells whose centre is strictly inside the disc, as ranges.
    pub fn in_disc(&self, disc: &Circle, mut visit: impl FnMut(Range<usize>)) {
        let (center, radius) = (disc.center, disc.radius);
        for row in self.rows_between(center.y - radius, center.y + radius) {
            let up = self.center(Cell { column: 0, row }).y - center.y;
            // Beside the disc this is NaN, and there are no columns.
            let half = math::sqrt((radius - up) * (radius + up));
            let near = self.columns_between(center.x - half, center.x + half);
            visit(self.trimmed(row, near, |point| disc.contains(point)));
        }
    }

    /// Visits the numbers of the cells whose centre is strictly nearer to the way than the radius, as ranges: a row's
    /// cells are always one range, because all that is near a straight line is convex.
    pub fn in_swept(&self, way: &Segment, radius: f64, mut visit: impl FnMut(Range<usize>)) {
        let around = Bounds::of_segment(way);
        for row in self.rows_between(around.min.y - radius, around.max.y + radius) {
            let y = self.center(Cell { column: 0, row }).y;
            let (left, right) = way.x_range(y - radius, y + radius);
            let near = self.columns_between(left - radius, right + radius);
            visit(self.trimmed(row, near, |point| way.distance_squared(point) < radius * radius));
        }
    }

    /// Visits the cells that a segment in the grid frame touches, or misses by less than [`MARGIN`].
    pub fn along(&self, segment_in_grid: &Segment, mut visit: impl FnMut(Cell)) {
        let around = Bounds::of_segment(segment_in_grid);
        for row in self.rows(around.min.y - MARGIN, around.max.y + MARGIN) {
            let bottom = f64::from(row) - MARGIN;
            let (left, right) = segment_in_grid.x_range(bottom, bottom + 1.0 + 2.0 * MARGIN);
            self.columns(left - MARGIN, right + MARGIN).for_each(|column| visit(Cell { column, row }));
        }
    }

    /// The rows whose centres are between two heights, in metres, and a few more.
    fn rows_between(&self, low: f64, high: f64) -> Range<i32> {
        self.rows((low - self.origin.y) / self.cell_m - 1.5, (high - self.origin.y) / self.cell_m + 0.5)
    }

    /// The columns whose centres are between two x, in metres, and a few more.
    fn columns_between(&self, left: f64, right: f64) -> Range<i32> {
        self.columns((left - self.origin.x) / self.cell_m - 1.5, (right - self.origin.x) / self.cell_m + 0.5)
    }

    /// The rows that a range of y in the grid frame touches.
    fn rows(&self, low: f64, high: f64) -> Range<i32> {
        places(low, high, self.cells.first.row, self.cells.rows)
    }

    /// The columns that a range of x in the grid frame touches.
    fn columns(&self, left: f64, right: f64) -> Range<i32> {
        places(left, right, self.cells.first.column, self.cells.columns)
    }

    /// The numbers of the row's cells between the first and the last of these columns whose centre is inside.
    fn trimmed(&self, row: i32, columns: Range<i32>, inside: impl Fn(Point) -> bool) -> Range<usize> {
        let is_inside = |&column: &i32| inside(self.center(Cell { column, row }));
        let first = columns.clone().find(is_inside);
        let last = columns.rev().find(is_inside);
        let number = |column: Option<i32>| self.cells.number(Cell { column: column?, row });
        match (number(first), number(last)) {
            (Some(first), Some(last)) => first..last + 1,
            (None, _) | (_, None) => 0..0,
        }
    }
}

/// The places, so many from the first on, of the unit intervals that a range touches; none for NaN.
fn places(low: f64, high: f64, first: i32, count: i32) -> Range<i32> {
    let meets = low <= high && high >= f64::from(first);
    if !meets {
        return first..first;
    }
    let end = first + count;
    // The conversions take large numbers to the largest.
    let place = |at: f64| math::floor(at) as i32;
    place(low).clamp(first, end)..place(high).saturating_add(1).clamp(first, end)
}

/// A part of a cell's side within which two things are taken to touch: far more than the rounding of any computation
/// here.
pub const MARGIN: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_is_out_of_the_grid() {
        assert_eq!(places(-3.0, 1.5, 0, 4), 0..2);
        assert_eq!(places(1.0, 1.0, 0, 4), 1..2);
        assert_eq!(places(3.0, f64::INFINITY, 0, 4), 3..4);
        assert!(places(-3.0, -0.1, 0, 4).is_empty());
        assert!(places(4.0, 9.0, 0, 4).is_empty());
        assert!(places(f64::NAN, 1.0, 0, 4).is_empty() && places(0.0, f64::NAN, 0, 4).is_empty());
        assert_eq!(places(-3.5, 9.0, -5, 7), -4..2);
    }
}
