//! The cells along a ray, in order: J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm for Ray
//! Tracing*, Eurographics 1987.
//!
//! *Deviations.* The distance to each border is computed afresh from the border's number, so that nothing
//! adds up; and the first and the last cell are computed beforehand, so that the walk ends whatever is
//! rounded.

use baudbot_geometry::{Point, math};

use super::grid::Grid;

/// Visits the cells on the straight line, but for a hair at either end.
pub(super) fn cells(grid: &Grid, from: Point, to: Point, mut visit: impl FnMut(usize)) {
    let origin = grid.grid_from_world(from);
    let way = grid.grid_from_world(to) - origin;
    let length = math::hypot(way.x, way.y);
    let hair = HAIR_M / grid.cell_m;
    let part = Part { enter: hair, leave: length - hair };
    // Not for NaN, and not for a ray without end.
    let goes = length.is_finite() && part.enter < part.leave;
    if !goes {
        return;
    }
    let slope = way / length;
    let inside = part.within(origin.x, slope.x, grid.columns).within(origin.y, slope.y, grid.rows);
    if inside.enter > inside.leave {
        return;
    }
    let mut x = Axis::new(origin.x, slope.x, &inside, grid.columns);
    let mut y = Axis::new(origin.y, slope.y, &inside, grid.rows);
    visit(y.place * grid.columns + x.place);
    while let Some(next) = nearer(&mut x, &mut y) {
        next.advance();
        visit(y.place * grid.columns + x.place);
    }
}

/// From which to which distance along the ray, in sides of a cell.
struct Part {
    enter: f64,
    leave: f64,
}

impl Part {
    /// The part of this where one coordinate is between 0 and `count`.
    fn within(self, origin: f64, slope: f64, count: usize) -> Self {
        let size = count as f64;
        if slope == 0.0 {
            let leave = if (0.0..=size).contains(&origin) { self.leave } else { f64::NEG_INFINITY };
            return Self { leave, ..self };
        }
        let (a, b) = (-origin / slope, (size - origin) / slope);
        let (enter, leave) = if a <= b { (a, b) } else { (b, a) };
        Self { enter: self.enter.max(enter), leave: self.leave.min(leave) }
    }
}

/// The walk in one axis of the grid frame.
struct Axis {
    origin: f64,
    slope: f64,
    /// The present column or row.
    place: usize,
    /// The one in which the walk ends.
    last: usize,
}

impl Axis {
    fn new(origin: f64, slope: f64, part: &Part, count: usize) -> Self {
        // The conversion takes negative numbers, which only a rounding can make, to 0.
        let place_at = |distance: f64| (math::floor(origin + slope * distance) as usize).min(count - 1);
        Self { origin, slope, place: place_at(part.enter), last: place_at(part.leave) }
    }

    /// How far along the ray the border to the next column or row is.
    fn exit(&self) -> f64 {
        let border = if self.last > self.place { self.place + 1 } else { self.place };
        (border as f64 - self.origin) / self.slope
    }

    fn advance(&mut self) {
        if self.last > self.place {
            self.place += 1;
        } else {
            self.place -= 1;
        }
    }
}

/// The axis whose border comes next, of those in which the walk has not ended.
fn nearer<'a>(x: &'a mut Axis, y: &'a mut Axis) -> Option<&'a mut Axis> {
    match (x.place == x.last, y.place == y.last) {
        (true, true) => None,
        (false, true) => Some(x),
        (true, false) => Some(y),
        (false, false) => Some(if x.exit() <= y.exit() { x } else { y }),
    }
}

/// How much of a ray is left out at either end: more than roundings, less than anything of interest.
const HAIR_M: f64 = 0.5e-9;

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use baudbot_geometry::Bounds;

    use super::*;

    /// Three columns and two rows, 1 m each.
    fn walk(from: (f64, f64), to: (f64, f64)) -> Vec<usize> {
        let grid = Grid::new(&Bounds { min: Point::origin(), max: Point::new(3.0, 2.0) }, 1.0);
        let mut found = Vec::new();
        cells(&grid, Point::new(from.0, from.1), Point::new(to.0, to.1), |cell| found.push(cell));
        found
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
