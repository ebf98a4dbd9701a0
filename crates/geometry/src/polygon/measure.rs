//! Sizes of simple polygons, by the shoelace formula. Each is a sum over the triangles that an edge makes with
//! a fixed corner.

use super::edges;
use super::outline::ROUNDING;
use crate::math;
use crate::pose::{Point, Vector};

/// The area, in square metres, whichever way round the corners run.
#[must_use]
pub fn area(points: &[Point]) -> f64 {
    triangles(points).map(|(u, v)| 0.5 * u.perp(&v)).sum::<f64>().abs()
}

/// The length of the outline, in metres.
#[must_use]
pub fn perimeter(points: &[Point]) -> f64 {
    edges(points).map(|edge| math::sqrt((edge.end - edge.start).norm_squared())).sum()
}

/// The centre of the area, `None` if there is no area.
#[must_use]
pub fn centroid(points: &[Point]) -> Option<Point> {
    let doubled: f64 = triangles(points).map(|(u, v)| u.perp(&v)).sum();
    let sum: Vector = triangles(points).map(|(u, v)| (u + v) * u.perp(&v)).sum();
    let centroid = points.first()? + sum / (3.0 * doubled);
    (doubled != 0.0).then_some(centroid)
}

/// The moment of inertia about the centroid divided by the mass, in square metres, of a plate of even
/// thickness: the square of the radius of gyration. 0 if there is no area.
#[must_use]
pub fn second_moment(points: &[Point]) -> f64 {
    let Some(centroid) = centroid(points) else { return 0.0 };
    let doubled: f64 = triangles(points).map(|(u, v)| u.perp(&v)).sum();
    let about_centroid = edges(points).map(|edge| (edge.start - centroid, edge.end - centroid));
    let sum: f64 = about_centroid.map(|(u, v)| u.perp(&v) * (u.dot(&u) + u.dot(&v) + v.dot(&v))).sum();
    sum / (6.0 * doubled)
}

/// Whether the simple polygon turns the same way at each corner; straight corners are allowed, and those that only rounding
/// turns the other way.
#[must_use]
pub fn is_convex(points: &[Point]) -> bool {
    let turns = || {
        let next = edges(points).skip(1).chain(edges(points).take(1));
        let pairs = edges(points).zip(next);
        pairs.map(|(this, next)| {
            let (u, v) = (this.end - this.start, next.end - next.start);
            (u.perp(&v), ROUNDING * u.dot(&v).abs())
        })
    };
    points.len() >= 3
        && (turns().all(|(turn, least)| turn >= -least) || turns().all(|(turn, least)| turn <= least))
}

/// The distance, in metres, from the origin of the polygon's frame to the farthest corner.
#[must_use]
pub fn bounding_radius(points: &[Point]) -> f64 {
    let farthest = points.iter().map(|point| point.coords.norm_squared()).fold(0.0, f64::max);
    math::sqrt(farthest)
}

/// Two sides of the triangle that each edge makes with the first corner. From there rounding errors are
/// proportional to the polygon's size, not to its distance from the origin.
fn triangles(points: &[Point]) -> impl Iterator<Item = (Vector, Vector)> {
    let first = points.first().copied().unwrap_or_else(Point::origin);
    edges(points).map(move |edge| (edge.start - first, edge.end - first))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x: f64, y: f64) -> [Point; 4] {
        [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)].map(|(u, v)| Point::new(x + u, y + v))
    }

    #[test]
    fn a_rectangle_far_from_the_origin() {
        let mut corners = rectangle(1000.0, -500.0);
        for _ in 0..2 {
            assert_eq!(area(&corners), 8.0);
            assert_eq!(perimeter(&corners), 12.0);
            assert_eq!(centroid(&corners), Some(Point::new(1002.0, -499.0)));
            assert!((second_moment(&corners) - 20.0 / 12.0).abs() < 1e-12, "(a² + b²) / 12");
            corners.reverse();
        }
        assert_eq!(bounding_radius(&rectangle(-1.0, 0.0)), 13.0_f64.sqrt());
    }

    #[test]
    fn a_hook_of_two_rectangles() {
        let hook = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (3.0, 4.0), (3.0, 1.0), (0.0, 1.0)];
        let hook = hook.map(|(x, y)| Point::new(x, y));
        assert_eq!(area(&hook), 7.0);
        let expected = Point::new((3.0 * 1.5 + 4.0 * 3.5) / 7.0, (3.0 * 0.5 + 4.0 * 2.0) / 7.0);
        assert!((centroid(&hook).unwrap() - expected).norm() < 1e-15);
        assert!(!is_convex(&hook));
        // The same the other way round.
        let mirrored = |point: Point| Point::new(-point.x, point.y);
        assert!(!is_convex(&hook.map(mirrored)) && is_convex(&rectangle(0.0, 0.0).map(mirrored)));
    }

    #[test]
    fn convex_and_not() {
        assert!(is_convex(&rectangle(0.0, 0.0)));
        let straight = [(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (0.0, 4.0)].map(|(x, y)| Point::new(x, y));
        assert!(is_convex(&straight));
        assert!(!is_convex(&straight[..2]));
    }

    #[test]
    fn nothing_has_no_size() {
        assert_eq!(
            (area(&[]), centroid(&[]), second_moment(&[]), bounding_radius(&[])),
            (0.0, None, 0.0, 0.0)
        );
        let line = [Point::new(0.0, 0.0), Point::new(1.0, 1.0), Point::new(2.0, 2.0)];
        assert_eq!((area(&line), centroid(&line), second_moment(&line)), (0.0, None, 0.0));
    }
}
