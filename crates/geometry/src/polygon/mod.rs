//! Closed chains of segments, given by their corners in order; the last corner is joined to the first.
//!
//! The files beside this one are `measure` (area, centroid, inertia), `outline` (what bounds a region) and `overlap` (with discs,
//! segments, others).

mod measure;
mod outline;
mod overlap;

use crate::pose::Point;
use crate::segment::Segment;

pub use measure::{area, bounding_radius, centroid, is_convex, perimeter, second_moment};
pub use outline::{Defect, defect, is_simple, without_repeats};
pub use overlap::{ROUNDING_M, overlaps_circle, overlaps_polygon, overlaps_segment};

/// The edges in the order of the corners; the last one closes the chain. No corners have no edges.
pub fn edges(points: &[Point]) -> impl Iterator<Item = Segment> {
    let ends = points.iter().cycle().skip(1);
    points.iter().zip(ends).map(|(&start, &end)| Segment { start, end })
}

/// Whether the point is inside, by the even-odd rule: a walk from it to infinity crosses an odd number of
/// edges.
///
/// A point on an edge may be judged either way.
#[must_use]
pub fn contains(points: &[Point], p: Point) -> bool {
    edges(points).filter(|edge| crosses_to_the_right(edge, p)).count() % 2 == 1
}

/// Whether the edge crosses the half-line from `p` towards greater x. Of an edge's ends the lower belongs
/// to it and the upper does not, so that a corner on the half-line counts once.
fn crosses_to_the_right(edge: &Segment, p: Point) -> bool {
    if (edge.start.y <= p.y) == (edge.end.y <= p.y) {
        return false;
    }
    let (low, high) = if edge.start.y <= p.y { (edge.start, edge.end) } else { (edge.end, edge.start) };
    (high - low).perp(&(p - low)) > 0.0
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    fn points<const N: usize>(corners: [(f64, f64); N]) -> Vec<Point> {
        corners.map(|(x, y)| Point::new(x, y)).to_vec()
    }

    #[test]
    fn edges_close_the_chain() {
        let triangle = points([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]);
        let found: Vec<_> = edges(&triangle).collect();
        assert_eq!(found.len(), 3);
        assert_eq!(found[2], Segment { start: triangle[2], end: triangle[0] });
        assert_eq!(edges(&[]).count(), 0);
    }

    #[test]
    fn inside_of_a_hook() {
        let hook = points([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (3.0, 4.0), (3.0, 1.0), (0.0, 1.0)]);
        assert!(contains(&hook, Point::new(3.5, 3.0)));
        assert!(contains(&hook, Point::new(1.0, 0.5)));
        assert!(!contains(&hook, Point::new(1.0, 3.0)));
        assert!(!contains(&hook, Point::new(-1.0, 0.0)), "level with corners");
        assert!(!contains(&[], Point::new(0.0, 0.0)));
    }
}
