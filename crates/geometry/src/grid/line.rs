//! The cells along a straight line, in order: J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm for Ray
//! Tracing*, Eurographics 1987.
//!
//! *Deviations.* The first and the last cell are computed beforehand, so that the walk ends whatever is rounded.
//! [`line`] adds up the distances from border to border, as the paper does; [`Grid::visit_line`] computes each afresh
//! from the border's number, so that nothing adds up. Where a line meets a corner, the two may differ in which of
//! the cells beside it they visit; results that depend on the one must not change to the other.

use core::iter;

use super::{Cell, Grid, Rectangle, floor};
use crate::math;
use crate::pose::Point;

/// All cells that the line between two points, in units of a cell's side, goes through, in order and with both ends'
/// cells. Where it goes through a corner, it goes through one of the cells beside it too, so that neighbours in the
/// list have a side in common.
pub fn line(from: Point, to: Point) -> impl Iterator<Item = Cell> {
    whole(from, to).cells()
}

fn whole(from: Point, to: Point) -> Staircase<impl FnMut() -> f64, impl FnMut() -> f64> {
    let (first, last) = (Cell::at(from), Cell::at(to));
    let way = to - from;
    Staircase { first, last, x: summed(from.x, way.x, first.column), y: summed(from.y, way.y, first.row) }
}

impl Rectangle {
    /// Visits the cells of [`line()`] by their numbers; none if the rectangle lacks the cell of one of the ends.
    pub fn visit_line(&self, from: Point, to: Point, visit: impl FnMut(usize)) {
        whole(from, to).visit(self, visit);
    }
}

impl Grid {
    /// Visits the numbers of those cells of the grid that the line between two points runs through, in order, without a
    /// little of the line at either end, in metres. None if the line is not longer than that, or not finite.
    pub fn visit_line(&self, from: Point, to: Point, left_out_m: f64, visit: impl FnMut(usize)) {
        if let Some(clipped) = self.clipped(from, to, left_out_m) {
            clipped.visit(&self.cells, visit);
        }
    }

    fn clipped(
        &self,
        from: Point,
        to: Point,
        left_out_m: f64,
    ) -> Option<Staircase<impl FnMut() -> f64 + use<>, impl FnMut() -> f64 + use<>>> {
        let origin = self.grid_from_world(from);
        let way = self.grid_from_world(to) - origin;
        let length = math::hypot(way.x, way.y);
        let left_out = left_out_m / self.cell_m;
        let part = Part { enter: left_out, leave: length - left_out };
        // Not for NaN, and not for a ray without end.
        let goes = length.is_finite() && part.enter < part.leave && self.cells.count() > 0;
        if !goes {
            return None;
        }
        let slope = way / length;
        let columns = (self.cells.first.column, self.cells.columns);
        let rows = (self.cells.first.row, self.cells.rows);
        let inside = part.within(origin.x, slope.x, columns).within(origin.y, slope.y, rows);
        if inside.enter > inside.leave {
            return None;
        }
        let cell = |distance| {
            let place = |origin, slope, (first, count)| {
                floor(origin + slope * distance).clamp(first, first + count - 1)
            };
            Cell { column: place(origin.x, slope.x, columns), row: place(origin.y, slope.y, rows) }
        };
        let (first, last) = (cell(inside.enter), cell(inside.leave));
        let x = exact(origin.x, slope.x, first.column, last.column);
        let y = exact(origin.y, slope.y, first.row, last.row);
        Some(Staircase { first, last, x, y })
    }
}

/// The cells from one to another, with a side in common each. `x` and `y` are how far along the line its borders
/// between columns and between rows are, one at each call: the nearer one is crossed next.
struct Staircase<X, Y> {
    first: Cell,
    last: Cell,
    x: X,
    y: Y,
}

impl<X: FnMut() -> f64, Y: FnMut() -> f64> Staircase<X, Y> {
    fn cells(self) -> impl Iterator<Item = Cell> {
        let (right, up) = self.direction();
        let Self { first, last, mut x, mut y } = self;
        let (mut next_x, mut next_y) = (x(), y());
        let steps = first.column.abs_diff(last.column) + first.row.abs_diff(last.row);
        let mut cell = first;
        iter::once(first).chain((0..steps).map(move |_| {
            // Near the end rounding may ask for a step beyond it.
            let is_across = cell.row == last.row || (cell.column != last.column && next_x <= next_y);
            if is_across {
                cell.column += right;
                next_x = x();
            } else {
                cell.row += up;
                next_y = y();
            }
            cell
        }))
    }

    /// Visits the same cells by their numbers in a rectangle. It has all of them if it has the first and the last.
    fn visit(mut self, cells: &Rectangle, mut visit: impl FnMut(usize)) {
        let (Some(mut number), Some(_)) = (cells.number(self.first), cells.number(self.last)) else { return };
        let direction = self.direction();
        let (right, up) = (direction.0 as isize, direction.1 as isize * cells.columns as isize);
        let mut columns = self.first.column.abs_diff(self.last.column);
        let mut rows = self.first.row.abs_diff(self.last.row);
        visit(number);
        let (mut next_x, mut next_y) = ((self.x)(), (self.y)());
        'both: while columns > 0 && rows > 0 {
            while next_x <= next_y {
                number = number.wrapping_add_signed(right);
                visit(number);
                next_x = (self.x)();
                columns -= 1;
                if columns == 0 {
                    break 'both;
                }
            }
            number = number.wrapping_add_signed(up);
            visit(number);
            next_y = (self.y)();
            rows -= 1;
        }
        // Near the end rounding may ask for a step beyond it.
        for (steps, along) in [(columns, right), (rows, up)] {
            for _ in 0..steps {
                number = number.wrapping_add_signed(along);
                visit(number);
            }
        }
    }

    /// The steps of the column and of the row.
    fn direction(&self) -> (i32, i32) {
        let towards = |first: i32, last: i32| if last > first { 1 } else { -1 };
        (towards(self.first.column, self.last.column), towards(self.first.row, self.last.row))
    }
}

/// The borders of columns, or of rows, from this place on, as parts of the way: each is the sum of those before.
fn summed(from: f64, way: f64, place: i32) -> impl FnMut() -> f64 {
    let border = if way > 0.0 { f64::from(place) + 1.0 } else { f64::from(place) };
    let mut next = if way == 0.0 { f64::INFINITY } else { (border - from) / way };
    let gap = 1.0 / way.abs();
    move || {
        let now = next;
        next += gap;
        now
    }
}

/// The same, as distances along a line with this slope from one place to another: each is computed by itself.
fn exact(origin: f64, slope: f64, first: i32, last: i32) -> impl FnMut() -> f64 {
    let (mut border, step) = if last > first { (first + 1, 1) } else { (first, -1) };
    move || {
        let now = f64::from(border);
        border += step;
        (now - origin) / slope
    }
}

/// The distances from which to which it goes along a line, in sides of a cell.
struct Part {
    enter: f64,
    leave: f64,
}

impl Part {
    /// The part of this where one coordinate is within so many places from the first on.
    fn within(self, origin: f64, slope: f64, (first, count): (i32, i32)) -> Self {
        let (low, high) = (f64::from(first), f64::from(first) + f64::from(count));
        if slope == 0.0 {
            let leave = if (low..=high).contains(&origin) { self.leave } else { f64::NEG_INFINITY };
            return Self { leave, ..self };
        }
        let (a, b) = ((low - origin) / slope, (high - origin) / slope);
        let (enter, leave) = if a <= b { (a, b) } else { (b, a) };
        Self { enter: self.enter.max(enter), leave: self.leave.min(leave) }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::bounds::Bounds;
    use crate::segment::Segment;

    fn cells(from: (f64, f64), to: (f64, f64)) -> Vec<(i32, i32)> {
        let cells = line(Point::new(from.0, from.1), Point::new(to.0, to.1));
        cells.map(|cell| (cell.column, cell.row)).collect()
    }

    #[test]
    fn a_line_goes_through_all_cells_between_its_ends() {
        assert_eq!(cells((0.5, 0.5), (2.5, 1.5)), [(0, 0), (1, 0), (1, 1), (2, 1)]);
        assert_eq!(cells((0.5, 0.5), (-1.5, 0.6)), [(0, 0), (-1, 0), (-2, 0)]);
        assert_eq!(cells((0.2, 0.2), (0.8, 0.9)), [(0, 0)]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn every_line_arrives_and_its_cells_are_neighbours(
            whole in prop::bool::ANY,
            ends in [-10.0..10.0_f64, -10.0..10.0, -10.0..10.0, -10.0..10.0],
        ) {
            let [x0, y0, x1, y1] = ends.map(|end| if whole { end.round() } else { end });
            let (from, to) = (Point::new(x0, y0), Point::new(x1, y1));
            let cells: Vec<_> = line(from, to).collect();
            prop_assert_eq!(cells.last(), Some(&Cell::at(to)), "{} to {}", from, to);
            let all = Rectangle { first: Cell { column: -11, row: -12 }, columns: 23, rows: 25 };
            let mut numbers = Vec::new();
            all.visit_line(from, to, |number| numbers.push(number));
            prop_assert_eq!(numbers.into_iter().map(|number| all.cell(number)).collect::<Vec<_>>(), cells.clone());
            for pair in cells.windows(2) {
                let (a, b) = (pair[0], pair[1]);
                prop_assert_eq!(a.column.abs_diff(b.column) + a.row.abs_diff(b.row), 1, "{} to {}", from, to);
            }
            for cell in cells {
                let center = Point::new(f64::from(cell.column) + 0.5, f64::from(cell.row) + 0.5);
                let off = Segment { start: from, end: to }.distance(center);
                prop_assert!(off <= 0.5_f64.sqrt() + 1e-9, "{} to {} is not in {:?}", from, to, cell);
            }
        }
    }

    /// Three columns and two rows, 1 m each; a hair of the ends is left out.
    fn walk(from: (f64, f64), to: (f64, f64)) -> Vec<usize> {
        let grid = Grid::over(&Bounds { min: Point::origin(), max: Point::new(3.0, 2.0) }, 1.0);
        let (from, to) = (Point::new(from.0, from.1), Point::new(to.0, to.1));
        let mut numbers = Vec::new();
        grid.visit_line(from, to, 0.5e-9, |number| numbers.push(number));
        let cells = grid.clipped(from, to, 0.5e-9).map(Staircase::cells).into_iter().flatten();
        assert_eq!(cells.filter_map(|cell| grid.cells.number(cell)).collect::<Vec<_>>(), numbers);
        numbers
    }

    #[test]
    fn cells_in_order() {
        assert_eq!(walk((0.5, 0.5), (2.5, 0.5)), [0, 1, 2]);
        assert_eq!(walk((2.5, 1.5), (0.5, 0.5)), [5, 4, 1, 0]);
        assert_eq!(walk((0.5, 0.5), (0.5, 1.5)), [0, 3]);
        assert_eq!(walk((0.2, 0.2), (0.3, 0.3)), [0]);
    }

    #[test]
    fn what_is_behind_a_wall_on_a_border_is_not_met() {
        assert_eq!(walk((0.5, 0.5), (2.0, 0.5)), [0, 1]);
        assert_eq!(walk((2.0, 0.5), (0.5, 0.5)), [1, 0], "nor behind the sensor");
        assert_eq!(walk((0.5, 0.5), (0.5, 2.0)), [0, 3]);
    }

    #[test]
    fn from_outside_and_beside() {
        assert_eq!(walk((-9.0, 0.5), (9.0, 0.5)), [0, 1, 2]);
        assert_eq!(walk((1.5, 9.0), (1.5, -9.0)), [4, 1]);
        assert!(walk((-9.0, 0.5), (-1.0, 0.5)).is_empty());
        assert!(walk((-1.0, 2.5), (4.0, 2.5)).is_empty());
        assert!(walk((-1.0, 1.0), (1.0, 4.0)).is_empty(), "past the corner");
    }

    #[test]
    fn nonsense_meets_nothing() {
        assert!(walk((0.5, 0.5), (0.5, 0.5)).is_empty(), "no length");
        assert!(walk((f64::NAN, 0.5), (0.5, 0.5)).is_empty());
        assert!(walk((0.5, 0.5), (f64::INFINITY, 0.5)).is_empty());
        assert!(walk((0.5, 0.5), (f64::MAX, f64::MAX)).is_empty());
    }
}
