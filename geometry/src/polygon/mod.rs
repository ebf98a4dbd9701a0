//! Closed chains of segments, given by their corners in order; the last corner is joined to the first.
//!
//! The files beside this one are `measure` (area, centroid, inertia) and `overlap` (with discs, segments, others).

mod measure;
mod overlap;

use crate::pose::Point;
use crate::segment::Segment;

pub use measure::{area, bounding_radius, centroid, is_convex, perimeter, second_moment};
pub use overlap::{overlaps_circle, overlaps_polygon, overlaps_segment};

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

/// Whether the chain bounds one region: three corners or more, and no two edges meet but neighbours at
/// their common corner. It takes time proportional to the square of the number of corners.
///
/// As for [`Segment::touches`], a defect of the size of a rounding error may be judged either way.
#[must_use]
pub fn is_simple(points: &[Point]) -> bool {
    let n = points.len();
    let edge = |i: usize| Segment { start: points[i], end: points[(i + 1) % n] };
    n >= 3
        && (0..n).all(|i| {
            let (this, next) = (edge(i), edge((i + 1) % n));
            // The last edge is the first one's neighbour; all others from i + 2 on are strangers.
            let strangers = (i + 2)..if i == 0 { n - 1 } else { n };
            this.start != this.end
                && !folds_back(&this, &next)
                && !strangers.map(edge).any(|s| this.touches(&s))
        })
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

/// Whether the second of two edges that share a corner runs back along the first.
fn folds_back(first: &Segment, second: &Segment) -> bool {
    let (u, v) = (first.end - first.start, second.end - second.start);
    u.perp(&v) == 0.0 && u.dot(&v) < 0.0
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

    #[test]
    fn simple_and_not() {
        assert!(is_simple(&points([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])));
        assert!(is_simple(&points([(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (0.0, 4.0)])), "a straight corner");
        assert!(!is_simple(&points([(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 4.0)])), "a bow tie");
        assert!(!is_simple(&points([(0.0, 0.0), (4.0, 0.0), (2.0, 0.0)])), "flat");
        assert!(!is_simple(&points([(0.0, 0.0), (0.0, 0.0), (4.0, 0.0), (0.0, 4.0)])), "a corner twice");
        assert!(!is_simple(&points([(0.0, 0.0), (4.0, 0.0)])));
        let pinched = points([(0.0, 0.0), (2.0, 1.0), (4.0, 0.0), (4.0, 2.0), (2.0, 1.0), (0.0, 2.0)]);
        assert!(!is_simple(&pinched), "two corners in one place");
    }
}
