//! Whether a polygon overlaps something: whether their insides have a point in common.
//!
//! Touching is no overlap, and being inside of the other is. Corners are computed, and rounded by it: what is no deeper than
//! [`ROUNDING_M`] counts as touching. Discs are taken as they are; an overlap or a gap of the size of a rounding error may be
//! judged either way there.

use super::{contains, edges};
use crate::circle::Circle;
use crate::pose::Point;
use crate::segment::Segment;

/// Whether the simple polygon and the disc overlap.
#[must_use]
pub fn overlaps_circle(points: &[Point], circle: &Circle) -> bool {
    edges(points).any(|edge| circle.overlaps_segment(&edge)) || contains(points, circle.center)
}

/// Whether some point of the segment is inside the simple polygon, and not only on its outline.
#[must_use]
pub fn overlaps_segment(points: &[Point], segment: &Segment) -> bool {
    if edges(points).any(|edge| crosses(&edge, segment)) {
        return true;
    }
    // A segment that has come this far can only touch the outline. Between two such places the segment is inside or
    // it is not, and places where this may change are the polygon's corners.
    let along = segment.end - segment.start;
    let length_squared = along.norm_squared();
    let corners = points.iter().filter(|&&corner| is_on(segment, corner));
    let places = corners.map(|corner| (corner - segment.start).dot(&along) / length_squared);
    let mut from = 0.0;
    loop {
        let next = places.clone().filter(|&place| place > from && place < 1.0).fold(1.0, f64::min);
        if contains_strictly(points, segment.start + along * (0.5 * (from + next))) {
            return true;
        }
        if next >= 1.0 {
            return false;
        }
        from = next;
    }
}

/// Whether the two simple polygons overlap.
#[must_use]
pub fn overlaps_polygon(a: &[Point], b: &[Point]) -> bool {
    // If no edge of one runs inside the other, the insides are apart, or the same.
    edges(a).any(|edge| overlaps_segment(b, &edge))
        || edges(b).any(|edge| overlaps_segment(a, &edge))
        || inner_point(a).is_some_and(|point| contains_strictly(b, point))
}

fn contains_strictly(points: &[Point], p: Point) -> bool {
    contains(points, p) && !edges(points).any(|edge| is_on(&edge, p))
}

/// Some point inside the simple polygon; none if it has no corners.
fn inner_point(points: &[Point]) -> Option<Point> {
    let n = points.len();
    // No polygon turns inwards at the corner that is farthest to the left.
    let left = (0..n).reduce(|a, b| if before(points[b], points[a]) { b } else { a })?;
    let [last, this, next] = [(left + n - 1) % n, left, (left + 1) % n].map(|i| points[i]);
    let base = next - last;
    // A corner in the triangle that is farthest from its base sees `this`: nothing is between them.
    let depth = |p: &Point| base.perp(&(p - last)) * base.perp(&(this - last));
    let triangle = [last, this, next];
    let inside = points.iter().filter(|&&p| !triangle.contains(&p) && depth(&p) > 0.0);
    let deepest =
        inside.filter(|&&p| in_triangle(&triangle, p)).reduce(|a, b| if depth(b) > depth(a) { b } else { a });
    let opposite = deepest.copied().unwrap_or(last + base * 0.5);
    Some(this + (opposite - this) * 0.5)
}

fn before(a: Point, b: Point) -> bool {
    (a.x, a.y) < (b.x, b.y)
}

fn in_triangle(triangle: &[Point; 3], p: Point) -> bool {
    let sides = [0, 1, 2].map(|i| side(&Segment { start: triangle[i], end: triangle[(i + 1) % 3] }, p));
    sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
}

/// Whether each of the segments has an end on either side of the other, farther away than rounding.
fn crosses(a: &Segment, b: &Segment) -> bool {
    is_between(a, b) && is_between(b, a)
}

/// Whether the line through a segment is between the ends of the other one.
fn is_between(line: &Segment, other: &Segment) -> bool {
    let (u, v) = (side(line, other.start), side(line, other.end));
    if !((u > 0.0 && v < 0.0) || (u < 0.0 && v > 0.0)) {
        return false;
    }
    let least = ROUNDING_M * ROUNDING_M * (line.end - line.start).norm_squared();
    u * u > least && v * v > least
}

fn is_on(segment: &Segment, p: Point) -> bool {
    segment.distance_squared(p) <= ROUNDING_M * ROUNDING_M
}

/// Depth, in metres, that is no more than the rounding of what was computed.
pub const ROUNDING_M: f64 = 5e-10;

/// Positive to the left when looking from start to end.
fn side(segment: &Segment, p: Point) -> f64 {
    (segment.end - segment.start).perp(&(p - segment.start))
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    fn points(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    fn segment(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
        Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) }
    }

    fn square(x: f64, y: f64, side: f64) -> Vec<Point> {
        points(&[(x, y), (x + side, y), (x + side, y + side), (x, y + side)])
    }

    /// A U, open to the top.
    fn cup() -> Vec<Point> {
        points(&[
            (0.0, 0.0),
            (5.0, 0.0),
            (5.0, 4.0),
            (4.0, 4.0),
            (4.0, 1.0),
            (1.0, 1.0),
            (1.0, 4.0),
            (0.0, 4.0),
        ])
    }

    #[test]
    fn discs() {
        let disc = |x, y, radius| Circle { center: Point::new(x, y), radius };
        assert!(!overlaps_circle(&cup(), &disc(2.5, 2.5, 1.5)), "touches three sides from inside the cup");
        assert!(overlaps_circle(&cup(), &disc(2.5, 2.5, 1.6)));
        assert!(overlaps_circle(&cup(), &disc(2.5, 0.5, 0.1)), "within the wood");
        assert!(overlaps_circle(&cup(), &disc(2.5, 2.0, 9.0)), "around it");
        assert!(!overlaps_circle(&[], &disc(0.0, 0.0, 1.0)));
    }

    #[test]
    fn segments() {
        assert!(overlaps_segment(&cup(), &segment(-1.0, 0.5, 6.0, 0.5)), "through");
        assert!(overlaps_segment(&cup(), &segment(2.0, 0.5, 3.0, 0.5)), "within");
        assert!(overlaps_segment(&cup(), &segment(0.0, 0.0, 1.0, 1.0)), "from corner to corner, inside");
        assert!(overlaps_segment(&cup(), &segment(-1.0, -1.0, 3.0, 3.0)), "through two corners");
        assert!(!overlaps_segment(&cup(), &segment(1.0, 4.0, 4.0, 4.0)), "the lid");
        assert!(!overlaps_segment(&cup(), &segment(1.0, 1.0, 4.0, 4.0)), "across the hollow");
        assert!(!overlaps_segment(&cup(), &segment(-1.0, 0.0, 9.0, 0.0)), "along the bottom");
        assert!(!overlaps_segment(&cup(), &segment(-1.0, 1.0, 0.0, 1.0)), "up to the side");
        assert!(!overlaps_segment(&cup(), &segment(-1.0, 1.0, 1.0, -1.0)), "past a corner");
        assert!(!overlaps_segment(&cup(), &segment(0.0, 4e-10, 5.0, 4e-10)), "no deeper than rounding");
        assert!(overlaps_segment(&cup(), &segment(0.0, 1e-9, 5.0, 1e-9)), "deeper");
        assert!(overlaps_segment(&cup(), &segment(0.5, 0.5, 0.5, 0.5)), "a point within");
        assert!(!overlaps_segment(&cup(), &segment(0.0, 0.5, 0.0, 0.5)), "a point of the outline");
    }

    #[test]
    fn polygons() {
        assert!(!overlaps_polygon(&cup(), &square(1.0, 1.0, 3.0)), "fills the hollow");
        assert!(!overlaps_polygon(&cup(), &square(1.0, 1.0 - 4e-10, 3.0)), "no deeper than rounding");
        assert!(overlaps_polygon(&cup(), &square(1.0, 1.0 - 1e-9, 3.0)), "deeper");
        assert!(overlaps_polygon(&cup(), &square(1.0, 0.9, 3.0)));
        assert!(!overlaps_polygon(&cup(), &square(5.0, 4.0, 1.0)), "corner to corner");
        assert!(overlaps_polygon(&cup(), &square(-1.0, -1.0, 9.0)), "around it");
        assert!(overlaps_polygon(&square(-1.0, -1.0, 9.0), &cup()), "within");
        assert!(overlaps_polygon(&cup(), &cup()), "the same");
        let mut turned = cup();
        turned.rotate_left(3);
        turned.reverse();
        assert!(overlaps_polygon(&cup(), &turned), "the same, from another corner, the other way round");
        assert!(!overlaps_polygon(&cup(), &[]) && !overlaps_polygon(&[], &cup()));
    }

    #[test]
    fn an_inner_point_is_inside() {
        let dented = points(&[(0.0, 0.0), (4.0, -2.0), (1.0, 0.1), (4.0, 2.0)]);
        for polygon in [cup(), square(1.0, 1.0, 2.0), dented] {
            assert!(inner_point(&polygon).is_some_and(|p| contains_strictly(&polygon, p)), "{polygon:?}");
        }
    }

    #[test]
    fn nonsense_ends() {
        let nan = segment(f64::NAN, 0.0, 1.0, f64::INFINITY);
        assert!(!overlaps_segment(&cup(), &nan));
        assert!(!overlaps_polygon(&cup(), &[nan.start, nan.end, nan.start]));
    }
}
