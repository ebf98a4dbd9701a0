//! The box, with sides along the axes, around shapes.

use serde::{Deserialize, Serialize};

use crate::circle::Circle;
use crate::math;
use crate::pose::{Point, Vector};
use crate::segment::Segment;

/// A box with sides along the axes. Its sides belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// The corner with the least coordinates, in metres.
    pub min: Point,
    /// The corner with the greatest coordinates, in metres.
    pub max: Point,
}

impl Bounds {
    /// The box around a segment.
    #[must_use]
    pub fn of_segment(segment: &Segment) -> Self {
        let corner = Self { min: segment.start, max: segment.start };
        corner.union(&Self { min: segment.end, max: segment.end })
    }

    /// The box around a circle.
    #[must_use]
    pub fn of_circle(circle: &Circle) -> Self {
        let half = Vector::new(circle.radius, circle.radius);
        Self { min: circle.center - half, max: circle.center + half }
    }

    /// The box around all points; `None` if there are none.
    #[must_use]
    pub fn of_points(points: &[Point]) -> Option<Self> {
        points.iter().map(|&point| Self { min: point, max: point }).reduce(|a, b| a.union(&b))
    }

    /// Whether the point is in the box.
    #[must_use]
    pub fn contains(&self, point: Point) -> bool {
        (self.min.x..=self.max.x).contains(&point.x) && (self.min.y..=self.max.y).contains(&point.y)
    }

    /// The middle of the box.
    #[must_use]
    pub fn center(&self) -> Point {
        self.min + self.size() * 0.5
    }

    /// The box around both boxes.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: Point::new(least(self.min.x, other.min.x), least(self.min.y, other.min.y)),
            max: Point::new(-least(-self.max.x, -other.max.x), -least(-self.max.y, -other.max.y)),
        }
    }

    /// The width and the height, in metres.
    #[must_use]
    pub fn size(&self) -> Vector {
        self.max - self.min
    }

    /// The distance, in metres, from the point to the box: 0 inside.
    #[must_use]
    pub fn distance(&self, to: Point) -> f64 {
        math::hypot(outside(to.x, self.min.x, self.max.x), outside(to.y, self.min.y, self.max.y))
    }
}

/// Unlike `f64::min`, this promises which zero it returns when both signs meet: the first.
fn least(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

fn outside(value: f64, min: f64, max: f64) -> f64 {
    if value < min {
        min - value
    } else if value > max {
        value - max
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn around_a_wall_and_a_pillar() {
        let wall = Segment { start: Point::new(3.0, 1.0), end: Point::new(0.0, 2.0) };
        let pillar = Circle { center: Point::new(-1.0, 0.0), radius: 0.5 };
        let bounds = Bounds::of_segment(&wall).union(&Bounds::of_circle(&pillar));
        assert_eq!(bounds, Bounds { min: Point::new(-1.5, -0.5), max: Point::new(3.0, 2.0) });
        assert_eq!(bounds.size(), Vector::new(4.5, 2.5));
        assert_eq!(bounds.distance(Point::new(6.0, 6.0)), 5.0);
        assert_eq!(bounds.distance(Point::new(0.0, 0.0)), 0.0);
        assert!(bounds.contains(Point::new(0.0, 0.0)) && bounds.contains(bounds.min));
        assert!(!bounds.contains(Point::new(0.0, 2.1)) && !bounds.contains(Point::new(-1.6, 0.0)));
    }
}
