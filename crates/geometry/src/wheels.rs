//! Kinematics of a differential drive: Wahde 2016, §2.1.
//!
//! With R for half the track, the left and the right wheel at v_L and v_R move the middle between them by
//!
//! ```text
//! V = (v_L + v_R) / 2    ω = (v_R − v_L) / 2R       (2.5), (2.6)
//! v_L = V − R ω          v_R = V + R ω              (2.2), (2.3)
//! ```
//!
//! The same holds for the ways of the wheels in place of their speeds.

use crate::math;
use crate::pose::{Direction, Pose, Vector};

/// The motion of the middle between two wheels: as speeds (m/s, rad/s), or as ways (m, rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Along the heading, in m/s or m.
    pub forward: f64,
    /// The turn to the left, in rad/s or rad.
    pub turn: f64,
}

impl Twist {
    /// The motion that wheels with these speeds (m/s) or ways (m) make: (2.5), (2.6).
    #[inline]
    #[must_use]
    pub fn of_wheels([left, right]: [f64; 2], half_track_m: f64) -> Self {
        Self { forward: 0.5 * (left + right), turn: (right - left) / (2.0 * half_track_m) }
    }

    /// The speeds (m/s) or ways (m) of the left and of the right wheel: (2.2), (2.3).
    #[inline]
    #[must_use]
    pub fn wheels(self, half_track_m: f64) -> [f64; 2] {
        let aside = half_track_m * self.turn;
        [self.forward - aside, self.forward + aside]
    }

    /// The frame after a way at constant speeds in the frame before it: a chord of a circle.
    #[must_use]
    pub fn then_from_now(self) -> Pose {
        let chord = self.forward * chord_of_arc(self.turn);
        let (sin, cos) = math::sin_cos(0.5 * self.turn);
        Pose::new(chord * cos, chord * sin, self.turn)
    }

    /// The way at constant speeds that ends with this turn and comes nearest to this place: the inverse of
    /// [`then_from_now`](Self::then_from_now).
    #[must_use]
    pub fn towards(then_from_now: &Pose) -> Self {
        Self { forward: arc(then_from_now).x, turn: then_from_now.heading }
    }
}

/// The way, along its own two axes, of a frame that goes at constant speeds and ends there: the integral of its velocity.
///
/// A frame that turns by θ goes along an arc, whose chord is shorter by sin(θ/2) / (θ/2) and points θ/2 off.
#[must_use]
pub fn arc(then_from_now: &Pose) -> Vector {
    let turn = then_from_now.heading;
    Direction::from_angle(-0.5 * turn).apply(then_from_now.position.coords) / chord_of_arc(turn)
}

/// The length of an arc's chord, as a part of the arc, by the angle of the arc.
fn chord_of_arc(turn_rad: f64) -> f64 {
    let half = 0.5 * turn_rad;
    // By its series, where the quotient has no digits.
    if half.abs() < 1e-4 { 1.0 - half * half / 6.0 } else { math::sin(half) / half }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    /// (2.2), (2.3) undo (2.5), (2.6).
    #[test]
    fn wheels_and_motions_are_the_same_thing_said_twice() {
        let twist = Twist::of_wheels([0.25, 0.75], 0.25);
        assert_eq!(twist, Twist { forward: 0.5, turn: 1.0 });
        assert_eq!(twist.wheels(0.25), [0.25, 0.75]);
        assert_eq!(Twist::of_wheels([-0.5, 0.5], 0.25), Twist { forward: 0.0, turn: 2.0 });
    }

    #[test]
    fn a_quarter_of_a_circle_ends_beside_its_middle() {
        let quarter = Twist { forward: FRAC_PI_2, turn: FRAC_PI_2 };
        let end = quarter.then_from_now();
        assert!((end.position.x - 1.0).abs() < 1e-15 && (end.position.y - 1.0).abs() < 1e-15, "{end:?}");
        let again = Twist::towards(&end);
        assert!((again.forward - quarter.forward).abs() < 1e-15, "{again:?}");
        let straight = Twist { forward: 2.0, turn: 0.0 };
        assert_eq!(straight.then_from_now(), Pose::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn what_is_carried_round_sideways_goes_along_an_arc_too() {
        // A quarter of a circle to the left, of radius 1, with the left side ahead.
        let way = arc(&Pose::new(-1.0, 1.0, FRAC_PI_2));
        assert!(way.x.abs() < 1e-15 && (way.y - FRAC_PI_2).abs() < 1e-15, "{way:?}");
        assert_eq!(arc(&Pose::new(3.0, 4.0, 0.0)), Vector::new(3.0, 4.0));
    }
}
