//! The cells along a ray, in order: J. Amanatides and A. Woo, *A Fast Voxel Traversal Algorithm for Ray
//! Tracing*, Eurographics 1987.
//!
//! *Deviations.* The distance to each border is computed afresh from the border's number. The paper adds up
//! one step at a time, which is quicker, but the sum of many steps drifts away from the border.
//!
//! The lines of [`grid`](crate::grid) end in a cell that is known beforehand. A ray ends with the first shape that it
//! meets, or where it leaves the grid, and needs of each cell how far away its exit is; nothing else in the crate is done
//! as often. So this walk stays by itself.

use super::layout::Layout;
use crate::ray::Ray;

/// An iterator over the cells that a ray passes through.
pub(super) struct Walk {
    x: Axis,
    y: Axis,
    columns: usize,
    ended: bool,
}

/// One cell on the way.
pub(super) struct Step {
    /// The cell's number.
    pub(super) cell: usize,
    /// The distance along the ray, in metres, at which it leaves the cell.
    pub(super) exit: f64,
}

impl Walk {
    /// `None` if the ray misses the grid.
    pub(super) fn new(layout: &Layout, ray: &Ray) -> Option<Self> {
        let origin = layout.grid_from_world(ray.origin);
        let direction = ray.direction.vector();
        let size = (layout.columns() as f64 * layout.cell(), layout.rows() as f64 * layout.cell());
        let (enter_x, leave_x) = inside(origin.x, direction.x, size.0)?;
        let (enter_y, leave_y) = inside(origin.y, direction.y, size.1)?;
        let enter = if enter_x > enter_y { enter_x } else { enter_y };
        let overlap = enter <= leave_x && enter <= leave_y;
        if !overlap {
            return None;
        }
        let at = origin + direction * enter;
        let axis = |origin, slope, place, count| {
            let mut axis = Axis { origin, slope, place, count, cell: layout.cell(), exit: 0.0 };
            axis.exit = axis.next_border();
            axis
        };
        Some(Self {
            x: axis(origin.x, direction.x, layout.column(at.x), layout.columns()),
            y: axis(origin.y, direction.y, layout.row(at.y), layout.rows()),
            columns: layout.columns(),
            ended: false,
        })
    }
}

impl Iterator for Walk {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        if self.ended {
            return None;
        }
        let cell = self.y.place * self.columns + self.x.place;
        let axis = if self.x.exit <= self.y.exit { &mut self.x } else { &mut self.y };
        let exit = axis.exit;
        self.ended = !axis.advance();
        Some(Step { cell, exit })
    }
}

/// The walk in one axis.
struct Axis {
    /// The ray's origin in the grid frame.
    origin: f64,
    /// The ray's direction.
    slope: f64,
    /// The present column or row, of so many, of this size.
    place: usize,
    count: usize,
    cell: f64,
    /// The distance along the ray to the border of the next column or row.
    exit: f64,
}

impl Axis {
    /// Moves on by one cell; false if this leaves the grid.
    fn advance(&mut self) -> bool {
        let next = if self.slope > 0.0 { self.place.checked_add(1) } else { self.place.checked_sub(1) };
        let Some(next) = next.filter(|&next| next < self.count) else { return false };
        self.place = next;
        self.exit = self.next_border();
        true
    }

    fn next_border(&self) -> f64 {
        if self.slope > 0.0 {
            ((self.place + 1) as f64 * self.cell - self.origin) / self.slope
        } else if self.slope < 0.0 {
            (self.place as f64 * self.cell - self.origin) / self.slope
        } else {
            f64::INFINITY
        }
    }
}

/// The distances along the ray between which one coordinate is in the grid. The first is not negative.
fn inside(origin: f64, slope: f64, size: f64) -> Option<(f64, f64)> {
    if slope == 0.0 {
        return (0.0 <= origin && origin <= size).then_some((0.0, f64::INFINITY));
    }
    let (low, high) = (-origin / slope, (size - origin) / slope);
    let (enter, leave) = if low <= high { (low, high) } else { (high, low) };
    Some((if enter > 0.0 { enter } else { 0.0 }, leave))
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;
    use crate::bounds::Bounds;
    use crate::pose::{Direction, Point};
    use crate::segment::Segment;

    /// 1 m cells: two segments across a square of 2 m ask for four cells.
    fn layout() -> Layout {
        let diagonals = vec![
            Segment { start: Point::new(0.0, 0.0), end: Point::new(2.0, 2.0) },
            Segment { start: Point::new(0.0, 2.0), end: Point::new(2.0, 0.0) },
        ];
        Layout::new(&Bounds { min: Point::new(0.0, 0.0), max: Point::new(2.0, 2.0) }, &diagonals, &[])
    }

    fn walk(x: f64, y: f64, cos: f64, sin: f64) -> Vec<usize> {
        let ray = Ray { origin: Point::new(x, y), direction: Direction { cos, sin } };
        Walk::new(&layout(), &ray).into_iter().flatten().map(|step| step.cell).collect()
    }

    #[test]
    fn cells_in_order() {
        assert_eq!((layout().columns(), layout().rows()), (3, 3), "the margin starts a third one");
        assert_eq!(walk(0.5, 0.5, 1.0, 0.0), [0, 1, 2]);
        assert_eq!(walk(0.5, 1.5, -1.0, 0.0), [3]);
        assert_eq!(walk(0.5, 0.6, 0.6, 0.8), [0, 3, 4, 7, 8]);
        assert_eq!(walk(-5.0, 0.5, 1.0, 0.0), [0, 1, 2], "from outside");
        assert!(walk(-5.0, 0.5, -1.0, 0.0).is_empty());
        assert!(walk(-5.0, 9.5, 1.0, 0.0).is_empty());
    }
}
