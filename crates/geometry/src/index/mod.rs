//! The first of many shapes on a ray: a uniform grid, which Wahde 2016 mentions in a footnote to Section 3.2.3.
//!
//! Its results are those of trying every shape,
//! to the last bit; only the time differs.
//!
//! Each cell lists the shapes that touch it. A ray visits cells in the order in which it enters them, and
//! stops when the nearest hit so far is not beyond the exit of the present cell: what is in later cells can
//! only be met later. The files beside this one are `layout` (how the plane is divided), `cells` (the lists)
//! and `walk` (the way of a ray).
//!
//! Rounding could break this where a shape or a ray runs along the border of a cell. Therefore a shape is
//! also listed in a cell that it misses by a small distance, the *margin*: a millionth of a cell's side,
//! which is far more than the rounding of any computation here. Only a ray from an origin some hundred
//! million cells away has a rounding as large as the margin, and for that ray every shape is tried.

mod cells;
mod layout;
mod walk;

use alloc::vec::Vec;

use crate::bounds::Bounds;
use crate::circle::Circle;
use crate::math;
use crate::polygon;
use crate::pose::Point;
use crate::ray::Ray;
use crate::segment::Segment;
use crate::sweep::Sweep;
use cells::Cells;
use layout::Layout;
use walk::Walk;

/// A shape of an [`Index`], by its place in the list that the index was made from.
///
/// In their order all segments come before all circles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Shape {
    /// A segment.
    Segment(usize),
    /// A circle.
    Circle(usize),
}

/// The first shape on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The distance, in metres, from the ray's origin.
    pub distance: f64,
    /// The shape that is met; of several at the same distance, the first in their order.
    pub shape: Shape,
}

/// Shapes that do not move, arranged so that those near a ray or a place are found without trying all.
#[derive(Clone, Debug, PartialEq)]
pub struct Index {
    segments: Vec<Segment>,
    circles: Vec<Circle>,
    /// None if there are no shapes.
    grid: Option<Grid>,
}

#[derive(Clone, Debug, PartialEq)]
struct Grid {
    bounds: Bounds,
    layout: Layout,
    cells: Cells,
}

impl Index {
    /// The bytes that it has on the heap.
    #[must_use]
    pub fn heap_bytes(&self) -> usize {
        let cells = self.grid.as_ref().map_or(0, |grid| grid.cells.heap_bytes());
        self.segments.capacity() * size_of::<Segment>()
            + self.circles.capacity() * size_of::<Circle>()
            + cells
    }

    /// Arranges the shapes.
    ///
    /// The grid has about two cells a shape, four at most, and never more than a million. Should the lists
    /// together come to more than about 16 entries a shape, as they do when many walls cross the whole
    /// arena, the cells are enlarged until they do not.
    ///
    /// # Panics
    ///
    /// If a coordinate or a radius is not finite, or the distance between two shapes is not.
    #[must_use]
    pub fn new(segments: Vec<Segment>, circles: Vec<Circle>) -> Self {
        let round = circles.iter().map(Bounds::of_circle);
        let bounds = segments.iter().map(Bounds::of_segment).chain(round).reduce(|a, b| a.union(&b));
        let grid = bounds.map(|bounds| {
            let layout = Layout::new(&bounds, &segments, &circles);
            let cells = Cells::new(&layout, &segments, &circles);
            Grid { bounds, layout, cells }
        });
        Self { segments, circles, grid }
    }

    /// The segments, in the order in which they were given.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The circles, in the order in which they were given.
    #[must_use]
    pub fn circles(&self) -> &[Circle] {
        &self.circles
    }

    /// The box around all shapes; `None` if there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.grid.as_ref().map(|grid| grid.bounds)
    }

    /// The nearest hit at a distance of at most `range`, in metres, which may be infinite (§3.2.3).
    #[must_use]
    pub fn cast(&self, ray: &Ray, range: f64) -> Option<Hit> {
        let grid = self.grid.as_ref()?;
        if grid.layout.is_far(ray.origin) {
            return self.all().fold(None, |best, shape| self.nearer(best, ray, range, shape));
        }
        let mut best = None;
        for step in Walk::new(&grid.layout, ray)? {
            for shape in grid.cells.shapes(step.cell) {
                best = self.nearer(best, ray, range, shape);
            }
            if best.map_or(range, |hit: Hit| hit.distance) <= step.exit {
                break;
            }
        }
        best
    }

    /// Adds all shapes that are in the range of a fan of rays.
    pub fn sweep(&self, sweep: &mut Sweep<'_>) {
        let Some(grid) = &self.grid else { return };
        let around = sweep.around();
        let many = self.segments.len() + self.circles.len();
        // Several shapes are in a cell, and many are in several.
        if 4 * grid.layout.cells_in_box(&around) < many {
            return self.near(&around, |shape| match shape {
                Shape::Segment(i) => sweep.segment(&self.segments[i]),
                Shape::Circle(i) => sweep.circle(&self.circles[i]),
            });
        }
        sweep.segments(&self.segments);
        self.circles.iter().for_each(|circle| sweep.circle(circle));
    }

    /// Visits every shape that may overlap the circle: all that touch a cell which the box around the
    /// circle touches.
    ///
    /// Some of these are not near, and one that touches several cells is visited several times. The order
    /// is the same in each run.
    pub fn near(&self, circle: &Circle, mut visit: impl FnMut(Shape)) {
        let Some(grid) = &self.grid else { return };
        grid.layout.box_cells(circle, |cell| grid.cells.shapes(cell).for_each(&mut visit));
    }

    /// The first shape, in the order of [`Shape`], that overlaps the circle. Touching is not overlapping.
    #[must_use]
    pub fn overlaps(&self, circle: &Circle) -> Option<Shape> {
        let mut first = None;
        self.near(circle, |shape| {
            if first.is_none_or(|first| shape < first) && self.overlaps_shape(circle, shape) {
                first = Some(shape);
            }
        });
        first
    }

    /// The first shape, in the order of [`Shape`], that overlaps the simple polygon; a segment does so if some
    /// of it is inside. Touching is not overlapping.
    #[must_use]
    pub fn meets_polygon(&self, points: &[Point]) -> Option<Shape> {
        let center = Bounds::of_points(points)?.center();
        let radius = points.iter().map(|point| (point - center).norm_squared()).fold(0.0, f64::max);
        let mut first = None;
        self.near(&Circle { center, radius: math::sqrt(radius) }, |shape| {
            if first.is_none_or(|first| shape < first) && self.polygon_overlaps(points, shape) {
                first = Some(shape);
            }
        });
        first
    }

    /// The point on any shape that is nearest to `p`, and its distance in metres. Circles are solid.
    ///
    /// Of several at the same distance it is that of the first shape.
    #[must_use]
    pub fn nearest_point(&self, p: Point) -> Option<(Point, f64)> {
        let grid = self.grid.as_ref()?;
        let gap = grid.bounds.distance(p);
        let mut best = None;
        for ring in 0..grid.layout.rings() {
            grid.layout.ring_cells(p, ring, |cell| {
                for shape in grid.cells.shapes(cell) {
                    best = self.closer(best, p, shape);
                }
            });
            // Shapes not yet seen are this far, or farther, from the place in the grid nearest to p.
            let unseen = ring as f64 * grid.layout.cell();
            let clear = (gap * gap + unseen * unseen) * ALMOST_ONE;
            if best.is_some_and(|near: Near| near.distance * near.distance < clear) {
                break;
            }
        }
        best.map(|near| (near.point, near.distance))
    }

    fn all(&self) -> impl Iterator<Item = Shape> {
        let circles = (0..self.circles.len()).map(Shape::Circle);
        (0..self.segments.len()).map(Shape::Segment).chain(circles)
    }

    /// The better of the best hit so far and that of one more shape.
    fn nearer(&self, best: Option<Hit>, ray: &Ray, range: f64, shape: Shape) -> Option<Hit> {
        let distance = match shape {
            Shape::Segment(i) => ray.hit_segment(&self.segments[i]),
            Shape::Circle(i) => ray.hit_circle(&self.circles[i]),
        };
        let found = distance.filter(|distance| *distance <= range).map(|distance| Hit { distance, shape });
        match (best, found) {
            (Some(best), Some(found)) => {
                Some(if (found.distance, found.shape) < (best.distance, best.shape) { found } else { best })
            }
            (best, found) => best.or(found),
        }
    }

    /// The better of the nearest point so far and that of one more shape.
    fn closer(&self, best: Option<Near>, to: Point, shape: Shape) -> Option<Near> {
        let (point, distance) = match shape {
            Shape::Segment(i) => (self.segments[i].nearest_point(to), self.segments[i].distance(to)),
            Shape::Circle(i) => (self.circles[i].nearest_point(to), self.circles[i].distance(to)),
        };
        let found = Near { point, distance, shape };
        match best {
            Some(best) if (best.distance, best.shape) <= (distance, shape) => Some(best),
            _ => Some(found),
        }
    }

    fn overlaps_shape(&self, circle: &Circle, shape: Shape) -> bool {
        match shape {
            Shape::Segment(i) => circle.overlaps_segment(&self.segments[i]),
            Shape::Circle(i) => circle.overlaps_circle(&self.circles[i]),
        }
    }

    fn polygon_overlaps(&self, points: &[Point], shape: Shape) -> bool {
        match shape {
            Shape::Segment(i) => polygon::overlaps_segment(points, &self.segments[i]),
            Shape::Circle(i) => polygon::overlaps_circle(points, &self.circles[i]),
        }
    }
}

#[derive(Clone, Copy)]
struct Near {
    point: Point,
    distance: f64,
    shape: Shape,
}

/// Keeps rounding, and the margin of the cells, from ending a search one ring too early.
const ALMOST_ONE: f64 = 1.0 - 1e-5;

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;
    use crate::pose::Direction;

    fn room() -> Index {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)].map(|(x, y)| Point::new(x, y));
        let pillar = Circle { center: Point::new(3.0, 1.0), radius: 0.5 };
        Index::new(polygon::edges(&corners).collect(), vec![pillar])
    }

    fn ray(x: f64, y: f64, angle_rad: f64) -> Ray {
        Ray { origin: Point::new(x, y), direction: Direction::from_angle(angle_rad) }
    }

    #[test]
    fn empty() {
        let nothing = Index::new(vec![], vec![]);
        assert_eq!(nothing.cast(&ray(0.0, 0.0, 1.0), f64::INFINITY), None);
        assert_eq!(nothing.overlaps(&Circle { center: Point::origin(), radius: 9.0 }), None);
        assert_eq!(nothing.nearest_point(Point::origin()), None);
        assert_eq!(nothing.bounds(), None);
    }

    #[test]
    fn nearest_hit_within_range() {
        let room = room();
        let eastward = ray(1.0, 1.0, 0.0);
        assert_eq!(room.cast(&eastward, 9.0), Some(Hit { distance: 1.5, shape: Shape::Circle(0) }));
        assert_eq!(room.cast(&eastward, 1.5), Some(Hit { distance: 1.5, shape: Shape::Circle(0) }));
        assert_eq!(room.cast(&eastward, 1.4), None);
        assert_eq!(room.cast(&eastward, f64::NAN), None);
    }

    #[test]
    fn the_first_of_two_shapes_at_the_same_distance() {
        let twice = Segment { start: Point::new(1.0, -1.0), end: Point::new(1.0, 1.0) };
        let disc = Circle { center: Point::new(2.0, 0.0), radius: 1.0 };
        let index = Index::new(vec![twice, twice], vec![disc]);
        let hit = index.cast(&ray(0.0, 0.0, 0.0), 5.0);
        assert_eq!(hit, Some(Hit { distance: 1.0, shape: Shape::Segment(0) }));
    }

    #[test]
    fn from_outside_and_from_far() {
        let room = room();
        let distance = |x, range| room.cast(&ray(x, 2.0, 0.0), range).map(|hit| hit.distance);
        assert_eq!(distance(-5.0, 9.0), Some(5.0));
        assert_eq!(distance(-5.0, 4.0), None);
        assert_eq!(distance(5.0, 9.0), None);
        assert_eq!(distance(-1e12, f64::INFINITY), Some(1e12));
    }

    #[test]
    fn overlapping_and_touching() {
        let room = room();
        let body = |x, y| Circle { center: Point::new(x, y), radius: 0.5 };
        assert_eq!(room.overlaps(&body(2.0, 1.0)), None, "touches the pillar");
        assert_eq!(room.overlaps(&body(2.1, 1.0)), Some(Shape::Circle(0)));
        assert_eq!(room.overlaps(&body(2.5, 0.4)), Some(Shape::Segment(0)), "both, the wall first");
        assert_eq!(room.overlaps(&body(-9.0, 9.0)), None);
    }

    #[test]
    fn polygons_among_the_shapes() {
        let room = room();
        let square = |x: f64, y: f64, side: f64| {
            [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)].map(|(u, v)| Point::new(x + u, y + v))
        };
        assert_eq!(room.meets_polygon(&square(0.0, 0.0, 1.0)), None, "in the corner");
        assert_eq!(room.meets_polygon(&square(-0.1, 0.0, 1.0)), Some(Shape::Segment(3)));
        assert_eq!(room.meets_polygon(&square(2.9, 0.9, 0.1)), Some(Shape::Circle(0)), "in the pillar");
        assert_eq!(room.meets_polygon(&square(-9.0, -9.0, 20.0)), Some(Shape::Segment(0)), "around all");
        assert_eq!(room.meets_polygon(&[]), None);
    }

    #[test]
    fn nearest_points() {
        let room = room();
        assert_eq!(room.nearest_point(Point::new(0.25, 1.0)), Some((Point::new(0.0, 1.0), 0.25)));
        assert_eq!(room.nearest_point(Point::new(7.0, 7.0)), Some((Point::new(4.0, 3.0), 5.0)));
        assert_eq!(room.nearest_point(Point::new(3.1, 1.0)), Some((Point::new(3.1, 1.0), 0.0)));
    }

    #[test]
    fn one_point_is_an_arena() {
        let dot = Segment { start: Point::new(2.0, 0.0), end: Point::new(2.0, 0.0) };
        let index = Index::new(vec![dot], vec![]);
        assert_eq!(index.cast(&ray(0.0, 0.0, 0.0), 5.0).map(|hit| hit.distance), Some(2.0));
    }

    #[test]
    fn nonsense_finds_nothing_and_ends() {
        let room = room();
        assert_eq!(room.cast(&ray(f64::NAN, 1.0, 0.0), 5.0), None);
        assert_eq!(room.cast(&ray(1.0, 1.0, f64::NAN), 5.0), None);
        assert_eq!(room.overlaps(&Circle { center: Point::new(f64::NAN, 0.0), radius: 1.0 }), None);
        let _ = room.nearest_point(Point::new(f64::NAN, f64::INFINITY));
    }

    #[test]
    #[should_panic(expected = "finite")]
    fn an_endless_wall() {
        let wall = Segment { start: Point::origin(), end: Point::new(f64::INFINITY, 0.0) };
        let _ = Index::new(vec![wall], vec![]);
    }
}
