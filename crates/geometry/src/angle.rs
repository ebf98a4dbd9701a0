//! Angles, kept within half a turn of zero.

use core::f64::consts::{PI, TAU};

use crate::math;

/// The same angle in (-pi, pi], in radians.
///
/// An angle that is already in this range comes back with the same bits. Any other loses whole turns of
/// `TAU`, the number nearest to 2 pi, without further rounding.
#[must_use]
pub fn wrap(angle_rad: f64) -> f64 {
    if -PI < angle_rad && angle_rad <= PI {
        return angle_rad;
    }
    // Within a turn of the range the subtraction is exact (Sterbenz's lemma), and the remainder too.
    if angle_rad > PI && angle_rad < 9.0 {
        return angle_rad - TAU;
    }
    if angle_rad <= -PI && angle_rad > -9.0 {
        return angle_rad + TAU;
    }
    let wrapped = math::remainder(angle_rad, TAU);
    if wrapped == -PI { PI } else { wrapped }
}

/// The turn in (-pi, pi], in radians, that leads from the angle `from` to the angle `to`.
#[must_use]
pub fn difference(to: f64, from: f64) -> f64 {
    wrap(to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_turn_is_positive() {
        assert_eq!(wrap(PI), PI);
        assert_eq!(wrap(-PI), PI);
        assert_eq!(wrap(3.0 * PI), PI);
        assert_eq!(wrap(-3.0 * PI), PI);
    }

    #[test]
    fn whole_turns_vanish() {
        assert_eq!(wrap(TAU), 0.0);
        assert_eq!(wrap(-5.0 * TAU), 0.0);
        assert!((wrap(TAU + 0.25) - 0.25).abs() < 1e-15);
    }

    #[test]
    fn difference_takes_the_short_way() {
        assert!((difference(-3.0, 3.0) - (TAU - 6.0)).abs() < 1e-15);
        assert_eq!(difference(0.5, 0.25), 0.25);
    }

    #[test]
    fn nonsense_stays_nonsense() {
        assert!(wrap(f64::NAN).is_nan());
        assert!(wrap(f64::INFINITY).is_nan());
    }
}
