//! The way between two readings.

use baudbot_geometry::{Point, Pose, Twist, math};
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2};

use crate::estimate::Estimate;

/// The robot's way, and those of its wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Step {
    /// The robot's new frame in its old one.
    pub(super) then_from_now: Pose,
    /// Ways of the left and the right wheel, in metres.
    pub(super) ways_m: [f64; 2],
}

impl Default for Step {
    fn default() -> Self {
        Self { then_from_now: Pose::new(0.0, 0.0, 0.0), ways_m: [0.0; 2] }
    }
}

impl Step {
    /// The step of wheels which went so far, in metres, at constant speeds.
    pub(super) fn of_wheels(ways_m: [f64; 2], half_track_m: f64) -> Self {
        Self { then_from_now: Twist::of_wheels(ways_m, half_track_m).then_from_now(), ways_m }
    }

    /// A motion of which the wheels' ways are guessed: those of the arc with this chord and this turn.
    pub(super) fn of_motion(then_from_now: Pose, half_track_m: f64) -> Self {
        Self { then_from_now, ways_m: Twist::towards(&then_from_now).wheels(half_track_m) }
    }

    /// This one and then another.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self {
            then_from_now: self.then_from_now.compose(&next.then_from_now),
            ways_m: [0, 1].map(|i| self.ways_m[i] + next.ways_m[i]),
        }
    }

    /// Whether it hardly matters when in its time it was done.
    pub(super) fn is_small(&self) -> bool {
        let Pose { position, heading } = self.then_from_now;
        position.coords.norm() <= SMALL_M && heading.abs() <= SMALL_RAD
    }

    /// The beginning of it, up to a fraction.
    pub(super) fn part(&self, fraction: f64) -> Self {
        let Pose { position, heading } = self.then_from_now;
        let position = Point::from(position.coords * fraction);
        let then_from_now = Pose { position, heading: heading * fraction };
        Self { then_from_now, ways_m: self.ways_m.map(|way| way * fraction) }
    }

    /// The step behind the [`part`](Self::part) up to a fraction.
    pub(super) fn rest(&self, fraction: f64) -> Self {
        let then_from_now = self.part(fraction).then_from_now.inverse().compose(&self.then_from_now);
        Self { then_from_now, ways_m: self.ways_m.map(|way| way * (1.0 - fraction)) }
    }

    /// The pose after this step, world from robot.
    pub(super) fn pose_after(&self, world_from_then: &Pose) -> Pose {
        world_from_then.compose(&self.then_from_now)
    }

    /// The estimate after this step, for wheels with this variance per metre.
    pub(super) fn apply(&self, estimate: &Estimate, half_track_m: f64, variance_m2_per_m: f64) -> Estimate {
        let world_from_then = estimate.world_from_robot;
        let world_from_now = self.pose_after(&world_from_then);
        let moved = world_from_now.position - world_from_then.position;
        let [left, right] = self.ways_m;
        #[rustfmt::skip]
        let by_pose = Matrix3::new(
            1.0, 0.0, -moved.y,
            0.0, 1.0,  moved.x,
            0.0, 0.0,  1.0,
        );
        let (sin, cos) = math::sin_cos(world_from_then.heading + 0.5 * self.then_from_now.heading);
        let (half_sin, half_cos) = (0.5 * sin, 0.5 * cos);
        let lever = (left + right) / (8.0 * half_track_m);
        let per_m = 1.0 / (2.0 * half_track_m);
        #[rustfmt::skip]
        let by_ways = Matrix3x2::new(
            half_cos + lever * sin, half_cos - lever * sin,
            half_sin - lever * cos, half_sin + lever * cos,
            -per_m,                 per_m,
        );
        let noise = Matrix2::from_diagonal(&Vector2::new(left.abs(), right.abs())) * variance_m2_per_m;
        let covariance =
            by_pose * estimate.covariance * by_pose.transpose() + by_ways * noise * by_ways.transpose();
        Estimate { world_from_robot: world_from_now, covariance }
    }
}

/// A way that is longer matters, in metres, ...
const SMALL_M: f64 = 0.1;
/// ... and a turn that is wider, in radians.
const SMALL_RAD: f64 = 0.1;
