//! The round shape: a solid disc, such as a pillar or a robot's body.

use serde::{Deserialize, Serialize};

use crate::math;
use crate::pose::Point;
use crate::segment::Segment;

/// A solid disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Circle {
    /// The centre, in metres.
    pub center: Point,
    /// The radius, in metres; not negative.
    pub radius: f64,
}

impl Circle {
    /// Whether the point is strictly inside.
    #[inline]
    #[must_use]
    pub fn contains(&self, point: Point) -> bool {
        (point - self.center).norm_squared() < self.radius * self.radius
    }

    /// Whether some point of the segment is strictly nearer to the centre than the radius. Touching is not
    /// overlapping. The collision of §3.2.5.
    #[inline]
    #[must_use]
    pub fn overlaps_segment(&self, segment: &Segment) -> bool {
        segment.distance_squared(self.center) < self.radius * self.radius
    }

    /// Whether the centres are strictly nearer than the sum of the radii. Touching is not overlapping.
    #[inline]
    #[must_use]
    pub fn overlaps_circle(&self, other: &Self) -> bool {
        let reach = self.radius + other.radius;
        (other.center - self.center).norm_squared() < reach * reach
    }

    /// The point of the disc that is nearest to `to`: `to` itself if that is inside.
    #[must_use]
    pub fn nearest_point(&self, to: Point) -> Point {
        let outward = to - self.center;
        let distance_squared = outward.norm_squared();
        if distance_squared <= self.radius * self.radius {
            return to;
        }
        self.center + outward * (self.radius / math::sqrt(distance_squared))
    }

    /// The distance, in metres, from `to` to the disc: 0 inside.
    #[must_use]
    pub fn distance(&self, to: Point) -> f64 {
        let gap = math::sqrt((to - self.center).norm_squared()) - self.radius;
        if gap > 0.0 { gap } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(x: f64, y: f64, radius: f64) -> Circle {
        Circle { center: Point::new(x, y), radius }
    }

    #[test]
    fn touching_is_no_overlap() {
        let body = circle(0.0, 0.0, 1.0);
        let wall = |x| Segment { start: Point::new(x, -3.0), end: Point::new(x, 3.0) };
        assert!(!body.overlaps_segment(&wall(1.0)));
        assert!(body.overlaps_segment(&wall(0.999)));
        assert!(!body.overlaps_circle(&circle(3.0, 0.0, 2.0)));
        assert!(body.overlaps_circle(&circle(2.9, 0.0, 2.0)));
    }

    #[test]
    fn a_segment_inside_overlaps() {
        let inner = Segment { start: Point::new(0.1, 0.1), end: Point::new(0.2, 0.1) };
        assert!(circle(0.0, 0.0, 1.0).overlaps_segment(&inner));
    }

    #[test]
    fn nearest() {
        let pillar = circle(1.0, 0.0, 2.0);
        assert_eq!(pillar.nearest_point(Point::new(6.0, 0.0)), Point::new(3.0, 0.0));
        assert_eq!(pillar.distance(Point::new(6.0, 0.0)), 3.0);
        assert_eq!(pillar.nearest_point(Point::new(1.5, 0.0)), Point::new(1.5, 0.0));
        assert_eq!(pillar.distance(Point::new(1.5, 0.0)), 0.0);
        assert!(pillar.contains(Point::new(1.5, 0.0)) && !pillar.contains(Point::new(3.0, 0.0)));
    }
}
