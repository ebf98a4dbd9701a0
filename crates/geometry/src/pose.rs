//! Points, directions and poses: where one frame lies in another.
//!
//! Wahde, Eq. (3.9), and the sum of angles in Eq. (3.10).
//!
//! *Deviations.* Eq. (3.9) adds the sensor's place to the robot's as if both were given along the axes of
//! the world. Here the place is given in the robot's frame (x forward, y to the left), and
//! [`Pose::transform`] turns it by the heading before it is added.

use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

use crate::{angle, math};

/// A place in the plane, in metres.
pub type Point = Point2<f64>;

/// A displacement in the plane, in metres by default.
pub type Vector = Vector2<f64>;

/// The place and the heading of one frame in another, say of a robot in the world.
///
/// A name such as `world_from_robot` has both: it takes what is known in the robot's frame to the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// The origin of the inner frame, in metres, in the outer one.
    pub position: Point,
    /// The angle in radians, counter-clockwise, from the outer frame's x axis to the inner one's.
    pub heading: f64,
}

impl Pose {
    /// A pose at (`x`, `y`), in metres, with a heading in radians, which is kept as it is given.
    #[must_use]
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self { position: Point::new(x, y), heading }
    }

    /// The heading as a unit vector. It costs a sine and a cosine, so take it once and keep it.
    #[must_use]
    pub fn direction(&self) -> Direction {
        Direction::from_angle(self.heading)
    }

    /// The position in the outer frame of a point of the inner one. Eq. (3.9), with the rotation (see above).
    #[must_use]
    pub fn transform(&self, point_in_robot: Point) -> Point {
        self.position + self.direction().apply(point_in_robot.coords)
    }

    /// `world_from_robot.compose(&robot_from_sensor)` is `world_from_sensor`, its heading wrapped into
    /// (-pi, pi].
    #[must_use]
    pub fn compose(&self, other: &Self) -> Self {
        self.compose_facing(self.direction(), other)
    }

    /// [`compose`](Self::compose) with the [`direction`](Self::direction) at hand, as if it were computed here.
    #[inline]
    #[must_use]
    pub fn compose_facing(&self, direction: Direction, other: &Self) -> Self {
        let position = self.position + direction.apply(other.position.coords);
        Self { position, heading: angle::wrap(self.heading + other.heading) }
    }

    /// The outer frame as seen from the inner one: `world_from_robot.inverse()` is `robot_from_world`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let back = self.direction().inverse().apply(-self.position.coords);
        Self { position: Point::from(back), heading: angle::wrap(-self.heading) }
    }
}

/// A unit vector, which is also a rotation: that of the x axis onto the vector.
///
/// Rotating costs four multiplications and no trigonometry. Thus a sensor's rays are computed once and
/// then turned with the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Direction {
    /// The x component: the cosine of the angle.
    pub cos: f64,
    /// The y component: the sine of the angle.
    pub sin: f64,
}

impl Direction {
    /// The direction at an angle in radians, counter-clockwise from the x axis.
    #[must_use]
    pub fn from_angle(angle_rad: f64) -> Self {
        let (sin, cos) = math::sin_cos(angle_rad);
        Self { cos, sin }
    }

    /// The angle in radians, in [-pi, pi].
    #[must_use]
    pub fn angle(&self) -> f64 {
        math::atan2(self.sin, self.cos)
    }

    /// The direction whose angle is the sum of both angles.
    ///
    /// Each call adds a rounding to the length, so do not chain it over the ticks of a simulation.
    #[must_use]
    pub fn rotate(&self, other: Self) -> Self {
        Self {
            cos: self.cos * other.cos - self.sin * other.sin,
            sin: self.sin * other.cos + self.cos * other.sin,
        }
    }

    /// The rotation that undoes this one: the direction at the opposite angle.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { cos: self.cos, sin: -self.sin }
    }

    /// The unit vector itself.
    #[must_use]
    pub fn vector(&self) -> Vector {
        Vector::new(self.cos, self.sin)
    }

    /// The vector, rotated.
    #[must_use]
    pub fn apply(&self, v: Vector) -> Vector {
        Vector::new(self.cos * v.x - self.sin * v.y, self.sin * v.x + self.cos * v.y)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    /// (3.9), with the rotation.
    #[test]
    fn a_sensor_on_the_left_of_a_robot_that_looks_up() {
        let world_from_robot = Pose::new(2.0, 1.0, FRAC_PI_2);
        let place = world_from_robot.transform(Point::new(0.3, 0.1));
        assert!((place - Point::new(1.9, 1.3)).norm() < 1e-15);
    }

    #[test]
    fn compose_follows_the_frames() {
        let world_from_robot = Pose::new(2.0, 1.0, 3.0);
        let robot_from_sensor = Pose::new(0.1, -0.2, 1.0);
        let world_from_sensor = world_from_robot.compose(&robot_from_sensor);
        let point_in_sensor = Point::new(0.7, 0.4);
        let by_steps = world_from_robot.transform(robot_from_sensor.transform(point_in_sensor));
        assert!((world_from_sensor.transform(point_in_sensor) - by_steps).norm() < 1e-15);
        assert!(world_from_sensor.heading < 0.0, "wrapped");
    }

    /// The sum of angles in (3.10).
    #[test]
    fn a_direction_adds_angles() {
        let sum = Direction::from_angle(0.4).rotate(Direction::from_angle(0.9));
        assert!((sum.angle() - 1.3).abs() < 1e-15);
        assert!((sum.inverse().angle() + 1.3).abs() < 1e-15);
    }
}
