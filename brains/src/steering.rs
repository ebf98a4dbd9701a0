//! The way from a target to wheel speeds: the P-regulation of Wahde 2016, Eqs. (6.4) to (6.7), with pure rotations.

use baudbot_brain::Signals;
use baudbot_geometry::{Point, Pose, angle, math};
use serde::Deserialize;

use crate::parameter::{ParameterError, check_positive};

/// Constants of Section 6.2.2, and what a signal is worth.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Steering {
    /// K_p of (6.5), a radian.
    pub gain: f64,
    /// V_nav: speed when driving, in metres a second.
    pub speed_m_s: f64,
    /// V_rot: speed of the wheels when turning on the spot, in metres a second.
    pub rotation_m_s: f64,
    /// Turns on the spot if the heading is off by more than that, in radians ...
    pub rotate_above_rad: f64,
    /// ... until it is off by less than that.
    pub rotate_until_rad: f64,
    /// The speed of a wheel at a signal of 1, in metres a second. No data sheet states it; a robot that is faster or
    /// slower than that drives faster or slower than it is commanded to, and goes the same way.
    pub full_speed_m_s: f64,
}

impl Default for Steering {
    fn default() -> Self {
        Self {
            gain: 1.5,
            speed_m_s: 0.2,
            rotation_m_s: 0.1,
            rotate_above_rad: std::f64::consts::FRAC_PI_4,
            rotate_until_rad: std::f64::consts::PI / 36.0,
            full_speed_m_s: 0.5,
        }
    }
}

/// A way to steer, and whether it turns on the spot now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Helm {
    steering: Steering,
    rotates: bool,
}

impl Helm {
    pub(crate) fn new(steering: Steering) -> Self {
        Self { steering, rotates: false }
    }

    /// Whether it turns on the spot.
    #[cfg(test)]
    pub(crate) fn rotates(&self) -> bool {
        self.rotates
    }

    /// Speeds of the left and the right wheel that bring the heading of `world_from_robot` to φ_ref, in metres a second: (6.4) to (6.7).
    pub(crate) fn wheels(&mut self, world_from_robot: &Pose, heading_rad: f64) -> [f64; 2] {
        let s = self.steering;
        let off_rad = angle::difference(heading_rad, world_from_robot.heading);
        let limit_rad = if self.rotates { s.rotate_until_rad } else { s.rotate_above_rad };
        self.rotates = off_rad.abs() > limit_rad;
        if self.rotates {
            let speed_m_s = s.rotation_m_s.copysign(off_rad);
            return [-speed_m_s, speed_m_s];
        }
        let difference_m_s = s.gain * s.speed_m_s * off_rad;
        [s.speed_m_s - difference_m_s / 2.0, s.speed_m_s + difference_m_s / 2.0]
    }

    /// The same as signals, at a part of the speed.
    pub(crate) fn signals(&mut self, world_from_robot: &Pose, heading_rad: f64, part: f64) -> Signals {
        let [left, right] = self.wheels(world_from_robot, heading_rad);
        let part = if self.rotates { 1.0 } else { part };
        let signal = |speed_m_s: f64| speed_m_s * part / self.steering.full_speed_m_s;
        Signals { left: signal(left), right: signal(right) }
    }
}

impl Helm {
    /// Signals that lead to a point on a circle, by pure pursuit (Coulter 1992), or turn on the spot if it is too far aside.
    ///
    /// The circle touches the robot's heading and passes through the point, so with (x, y) for the point in the robot's frame
    /// its curvature is κ = 2y / (x² + y²). In bends it slows down, so that a wheel differs from the robot's speed by
    /// no more than V_rot. K_p is of no use here.
    pub(crate) fn pursue(
        &mut self,
        world_from_robot: &Pose,
        to: Point,
        half_track_m: f64,
        part: f64,
    ) -> Signals {
        let s = self.steering;
        let offset = to - world_from_robot.position;
        let heading_rad = math::atan2(offset.y, offset.x);
        let off_rad = angle::difference(heading_rad, world_from_robot.heading);
        let limit_rad = if self.rotates { s.rotate_until_rad } else { s.rotate_above_rad };
        if off_rad.abs() > limit_rad {
            return self.signals(world_from_robot, heading_rad, part);
        }
        self.rotates = false;
        let bend = 2.0 * math::sin(off_rad) / offset.norm().max(LEAST_M) * half_track_m;
        let speed_m_s = (s.speed_m_s * part).min(s.rotation_m_s / bend.abs().max(f64::MIN_POSITIVE));
        let signal = |side: f64| speed_m_s * (1.0 + side * bend) / s.full_speed_m_s;
        Signals { left: signal(-1.0), right: signal(1.0) }
    }
}

/// A point that is nearer than this, in metres, is no point to drive at on a circle.
const LEAST_M: f64 = 1e-3;

/// The part of its speed at which a robot drives that stops after so many metres.
pub(crate) fn braking(left_m: f64) -> f64 {
    (left_m / BRAKING_M).clamp(SLOWEST, 1.0)
}

/// The distance from which on the robot slows down, in metres.
const BRAKING_M: f64 = 0.3;
/// Part of its speed that is left at the end.
const SLOWEST: f64 = 0.25;

impl Steering {
    /// All numbers must be positive.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        check_positive([
            ("steering.gain", self.gain),
            ("steering.speed_m_s", self.speed_m_s),
            ("steering.rotation_m_s", self.rotation_m_s),
            ("steering.rotate_above_rad", self.rotate_above_rad),
            ("steering.rotate_until_rad", self.rotate_until_rad),
            ("steering.full_speed_m_s", self.full_speed_m_s),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The heading's error is that of a first-order loop with the time constant 2R / (K_p V_nav).
    /// (6.4)–(6.7).
    #[test]
    fn a_heading_is_reached_as_a_first_order_loop_reaches_it() {
        let (half_track_m, dt_s) = (0.2, 0.01);
        let steering = Steering { rotate_above_rad: 3.0, ..Steering::default() };
        let (mut helm, mut pose) = (Helm::new(steering), Pose::new(0.0, 0.0, 0.0));
        for _ in 0..100 {
            let [left, right] = helm.wheels(&pose, 1.0);
            pose.heading += (right - left) / (2.0 * half_track_m) * dt_s;
        }
        assert!((1.0 - pose.heading - 0.471033).abs() < 1e-6, "{}", 1.0 - pose.heading);
        let exact = math::exp(-1.0 / 1.3333333333333333);
        assert!((1.0 - pose.heading - exact).abs() < 2e-3);
    }

    /// A point at 45° is reached on a quarter of a circle, whose radius is that of a square's side.
    #[test]
    fn a_point_is_reached_on_the_circle_through_it() {
        let (half_track_m, dt_s) = (0.2, 0.001);
        let steering =
            Steering { rotate_above_rad: 1.0, full_speed_m_s: 1.0, rotation_m_s: 0.1, ..Steering::default() };
        let (mut helm, mut pose) = (Helm::new(steering), Pose::new(0.0, 0.0, 0.0));
        let to = Point::new(1.0, 1.0);
        for _ in 0..7_500 {
            let Signals { left, right } = helm.pursue(&pose, to, half_track_m, 1.0);
            assert!(((left + right) / 2.0 - 0.2).abs() < 1e-9, "{left} {right}");
            pose.heading += (right - left) / (2.0 * half_track_m) * dt_s;
            pose.position += pose.direction().vector() * ((left + right) / 2.0 * dt_s);
            let radius = (pose.position - Point::new(0.0, 1.0)).norm();
            assert!((radius - 1.0).abs() < 1e-3, "{radius}");
        }
        let steering = Steering { rotation_m_s: 0.02, ..steering };
        let Signals { left, right } =
            Helm::new(steering).pursue(&Pose::new(0.0, 0.0, 0.0), to, half_track_m, 1.0);
        assert!(
            ((right - left) / 2.0 - 0.02).abs() < 1e-12 && left > 0.0,
            "slower in the bend: {left} {right}"
        );
        let Signals { left, right } =
            helm.pursue(&Pose::new(0.0, 0.0, 0.0), Point::new(0.0, 1.0), half_track_m, 1.0);
        assert!(left == -right && right > 0.0, "on the spot: {left} {right}");
    }

    #[test]
    fn a_large_error_is_turned_away_on_the_spot_until_it_is_small() {
        let mut helm = Helm::new(Steering::default());
        let mut at = |heading_rad: f64| helm.wheels(&Pose::new(0.0, 0.0, heading_rad), 0.0);
        assert_eq!(at(0.8), [0.1, -0.1]);
        assert_eq!(at(0.1), [0.1, -0.1]);
        let [left, right] = at(0.08);
        assert!(left > right && (left + right - 0.4).abs() < 1e-12);
        let [left, right] = at(-0.7);
        assert!(left < right && left > 0.0);
    }
}
