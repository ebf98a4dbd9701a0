//! The straight piece of a wall: Wahde, Eqs. (3.4) and (3.5) with the parameter in [0, 1].

use serde::{Deserialize, Serialize};

use crate::math;
use crate::pose::Point;

/// The straight line between two points. Both belong to it; they may be equal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Segment {
    /// One end, in metres.
    pub start: Point,
    /// The other end, in metres.
    pub end: Point,
}

impl Segment {
    /// The point of the segment that is nearest to `to`; an end itself, not a rounded copy, where it is one.
    #[inline]
    #[must_use]
    pub fn nearest_point(&self, to: Point) -> Point {
        let along = self.end - self.start;
        let length_squared = along.norm_squared();
        let ahead = (to - self.start).dot(&along);
        // The first comparison also catches the segment of no length, before it is divided by.
        if ahead <= 0.0 {
            self.start
        } else if ahead >= length_squared {
            self.end
        } else {
            self.start + along * (ahead / length_squared)
        }
    }

    /// The distance, in metres, from `to` to the nearest point.
    #[must_use]
    pub fn distance(&self, to: Point) -> f64 {
        math::sqrt(self.distance_squared(to))
    }

    /// The square of [`distance`](Self::distance), in square metres, which spares a root in comparisons.
    #[inline]
    #[must_use]
    pub fn distance_squared(&self, to: Point) -> f64 {
        (to - self.nearest_point(to)).norm_squared()
    }

    /// The distance, in metres, between the nearest points of the two; 0 if they [touch](Self::touches).
    #[must_use]
    pub fn gap(&self, other: &Self) -> f64 {
        if self.touches(other) {
            return 0.0;
        }
        // Of two segments apart, an end of one is nearest to the other.
        let ends = [self.distance_squared(other.start), self.distance_squared(other.end)];
        let others = [other.distance_squared(self.start), other.distance_squared(self.end)];
        math::sqrt(ends.into_iter().chain(others).fold(f64::INFINITY, f64::min))
    }

    /// The x between which the segment lies where its y is within a range, or of its end next to the range.
    #[must_use]
    pub fn x_range(&self, bottom: f64, top: f64) -> (f64, f64) {
        let (low, high) =
            if self.start.y <= self.end.y { (self.start, self.end) } else { (self.end, self.start) };
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

    /// Whether the segments have a point in common, an end included.
    ///
    /// Decided by the signs of rounded numbers: a gap or an overlap of the size of a rounding error may be
    /// judged either way.
    #[must_use]
    pub fn touches(&self, other: &Self) -> bool {
        let (a, b) = (self.side(other.start), self.side(other.end));
        let (c, d) = (other.side(self.start), other.side(self.end));
        let crossing = apart(a, b) && apart(c, d);
        // In line with each other, rounding alone gives the signs, however far apart they are.
        (crossing && self.may_meet(other))
            || (a == 0.0 && self.boxes(other.start))
            || (b == 0.0 && self.boxes(other.end))
            || (c == 0.0 && other.boxes(self.start))
            || (d == 0.0 && other.boxes(self.end))
    }

    /// Positive if the point is on the left when looking from start to end, negative on the right.
    fn side(&self, point: Point) -> f64 {
        (self.end - self.start).perp(&(point - self.start))
    }

    /// Whether the boxes around the two have a point in common.
    fn may_meet(&self, other: &Self) -> bool {
        let overlap = |a: f64, b: f64, c: f64, d: f64| a.max(b) >= c.min(d) && c.max(d) >= a.min(b);
        overlap(self.start.x, self.end.x, other.start.x, other.end.x)
            && overlap(self.start.y, self.end.y, other.start.y, other.end.y)
    }

    fn boxes(&self, point: Point) -> bool {
        between(point.x, self.start.x, self.end.x) && between(point.y, self.start.y, self.end.y)
    }
}

fn apart(a: f64, b: f64) -> bool {
    (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0)
}

fn between(value: f64, a: f64, b: f64) -> bool {
    (a <= value && value <= b) || (b <= value && value <= a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
        Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) }
    }

    /// The points of (3.4) and (3.5), whose parameter ends at 0 and 1.
    #[test]
    fn nearest_is_beside_or_an_end() {
        let wall = segment(1.0, 1.0, 4.0, 1.0);
        assert_eq!(wall.nearest_point(Point::new(2.0, 5.0)), Point::new(2.0, 1.0));
        assert_eq!(wall.nearest_point(Point::new(-2.0, 5.0)), wall.start);
        assert_eq!(wall.nearest_point(Point::new(9.0, 0.0)), wall.end);
        assert_eq!(wall.distance(Point::new(7.0, 5.0)), 5.0);
        assert_eq!(wall.distance_squared(Point::new(2.0, 5.0)), 16.0);
    }

    #[test]
    fn no_length_is_a_point() {
        let dot = segment(1.0, 2.0, 1.0, 2.0);
        assert_eq!(dot.distance(Point::new(4.0, 6.0)), 5.0);
    }

    #[test]
    fn touching() {
        let wall = segment(0.0, 0.0, 4.0, 0.0);
        assert!(wall.touches(&segment(1.0, -1.0, 1.0, 1.0)), "across");
        assert!(wall.touches(&segment(1.0, 0.0, 1.0, 1.0)), "an end on it");
        assert!(wall.touches(&segment(3.0, 0.0, 9.0, 0.0)), "along");
        assert!(wall.touches(&wall));
        assert!(!wall.touches(&segment(5.0, 0.0, 9.0, 0.0)), "in line, apart");
        assert!(!wall.touches(&segment(1.0, 0.5, 1.0, 1.0)));
        assert!(!wall.touches(&segment(5.0, -1.0, 5.0, 1.0)));
    }
}
