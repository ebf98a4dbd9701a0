//! How the floor is divided into cells.

use core::ops::Range;

use baudbot_geometry::{Bounds, Circle, Point, Segment, math};

/// Square cells, counted row by row from the lower left corner.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// The lower left corner, in metres.
    pub(super) min: Point,
    /// The side of a cell, in metres.
    pub(super) cell_m: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Grid {
    /// The cells over a box; [`count`] says how many.
    pub(super) fn new(bounds: &Bounds, cell_m: f64) -> Self {
        let (columns, rows) = count(bounds, cell_m);
        Self { min: bounds.min, cell_m, columns: columns as usize, rows: rows as usize }
    }

    pub(super) fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// The number of the cell, if the grid has it.
    pub(super) fn cell(&self, column: usize, row: usize) -> Option<usize> {
        (column < self.columns && row < self.rows).then(|| row * self.columns + column)
    }

    /// Where the centre of a cell is, in metres.
    pub(super) fn center(&self, column: usize, row: usize) -> Point {
        let along = |count: usize| (count as f64 + 0.5) * self.cell_m;
        Point::new(self.min.x + along(column), self.min.y + along(row))
    }

    /// The point in the *grid frame*: the lower left corner is the origin, and a cell's side is 1. There,
    /// borders and centres of cells are exact.
    pub(super) fn grid_from_world(&self, point: Point) -> Point {
        Point::from((point - self.min) / self.cell_m)
    }

    /// Visits the cells whose centre is strictly inside the disc, as ranges.
    pub(super) fn in_disc(&self, disc: &Circle, mut visit: impl FnMut(Range<usize>)) {
        let (center, radius) = (disc.center, disc.radius);
        for row in self.rows_between(center.y - radius, center.y + radius) {
            let up = self.center(0, row).y - center.y;
            // Beside the disc this is NaN, and there are no columns.
            let half = math::sqrt((radius - up) * (radius + up));
            let near = self.columns_between(center.x - half, center.x + half);
            visit(self.trimmed(row, near, |point| disc.contains(point)));
        }
    }

    /// Visits the cells whose centre is strictly nearer to the way than the radius, as ranges: a row's cells
    /// are always one range, because all that is near a straight line is convex.
    pub(super) fn in_swept(&self, way: &Segment, radius: f64, mut visit: impl FnMut(Range<usize>)) {
        let around = Bounds::of_segment(way);
        for row in self.rows_between(around.min.y - radius, around.max.y + radius) {
            let y = self.center(0, row).y;
            let (left, right) = x_range(way, y - radius, y + radius);
            let near = self.columns_between(left - radius, right + radius);
            visit(self.trimmed(row, near, |point| way.distance_squared(point) < radius * radius));
        }
    }

    /// Visits the cells, as column and row, that a segment in the grid frame touches or nearly touches.
    pub(super) fn along(&self, segment_in_grid: &Segment, mut visit: impl FnMut(usize, usize)) {
        let around = Bounds::of_segment(segment_in_grid);
        for row in places(around.min.y - MARGIN, around.max.y + MARGIN, self.rows) {
            let bottom = row as f64 - MARGIN;
            let (left, right) = x_range(segment_in_grid, bottom, bottom + 1.0 + 2.0 * MARGIN);
            places(left - MARGIN, right + MARGIN, self.columns).for_each(|column| visit(column, row));
        }
    }

    /// The rows whose centres are between two heights, in metres, and a few more.
    fn rows_between(&self, low: f64, high: f64) -> Range<usize> {
        places((low - self.min.y) / self.cell_m - 1.5, (high - self.min.y) / self.cell_m + 0.5, self.rows)
    }

    /// The columns whose centres are between two x, in metres, and a few more.
    fn columns_between(&self, left: f64, right: f64) -> Range<usize> {
        places(
            (left - self.min.x) / self.cell_m - 1.5,
            (right - self.min.x) / self.cell_m + 0.5,
            self.columns,
        )
    }

    /// The row's cells between the first and the last of these columns whose centre is inside.
    fn trimmed(&self, row: usize, columns: Range<usize>, inside: impl Fn(Point) -> bool) -> Range<usize> {
        let is_inside = |&column: &usize| inside(self.center(column, row));
        let first = columns.clone().find(is_inside);
        let last = columns.rev().find(is_inside);
        let base = row * self.columns;
        match (first, last) {
            (Some(first), Some(last)) => base + first..base + last + 1,
            (None, _) | (_, None) => 0..0,
        }
    }
}

/// How many columns and rows of cells of this side, in metres, a box has: at least one each. Whole numbers,
/// but they may be too large for an integer.
pub(super) fn count(bounds: &Bounds, cell_m: f64) -> (f64, f64) {
    // A box of four cells that a rounding made a bit larger has no fifth.
    let along = |length: f64| math::ceil(length / cell_m - MARGIN).max(1.0);
    (along(bounds.size().x), along(bounds.size().y))
}

/// The x between which a segment lies where its y is within a range, or where its end next to it is.
fn x_range(segment: &Segment, bottom: f64, top: f64) -> (f64, f64) {
    let (start, end) = (segment.start, segment.end);
    let (low, high) = if start.y <= end.y { (start, end) } else { (end, start) };
    let x_at = |y: f64| {
        if y <= low.y {
            low.x
        } else if y >= high.y {
            high.x
        } else {
            low.x + (high.x - low.x) * ((y - low.y) / (high.y - low.y))
        }
    };
    let (a, b) = (x_at(bottom), x_at(top));
    if a <= b { (a, b) } else { (b, a) }
}

/// The whole numbers below `count` of the unit intervals that a range touches; none for NaN.
fn places(low: f64, high: f64, count: usize) -> Range<usize> {
    let meets = low <= high && high >= 0.0;
    if !meets {
        return 0..0;
    }
    // The conversions take negative numbers to 0, and large ones to the largest.
    let first = (math::floor(low) as usize).min(count);
    first..(math::floor(high) as usize).saturating_add(1).min(count)
}

/// What is nearer than this, as a part of a cell's side, is taken to touch: far more than the rounding of any
/// computation here.
pub(super) const MARGIN: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(width: f64, height: f64) -> Bounds {
        Bounds { min: Point::origin(), max: Point::new(width, height) }
    }

    #[test]
    fn a_rounding_makes_no_column_more() {
        assert_eq!(2.1 / 0.3, 7.000000000000001);
        assert_eq!(count(&bounds(2.1, 0.9), 0.3), (7.0, 3.0));
        assert_eq!(count(&bounds(2.11, 0.0), 0.3), (8.0, 1.0), "a line has one row");
    }

    #[test]
    fn no_place_is_out_of_the_grid() {
        assert_eq!(places(-3.0, 1.5, 4), 0..2);
        assert_eq!(places(1.0, 1.0, 4), 1..2);
        assert_eq!(places(3.0, f64::INFINITY, 4), 3..4);
        assert!(places(-3.0, -0.1, 4).is_empty());
        assert!(places(4.0, 9.0, 4).is_empty());
        assert!(places(f64::NAN, 1.0, 4).is_empty() && places(0.0, f64::NAN, 4).is_empty());
    }
}
