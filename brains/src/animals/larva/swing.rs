//! A head that swings, and remembers what it saw on either side.

use std::f64::consts::TAU;

use baudbot_geometry::math;

use crate::animals::sense::Sides;

/// A head that swings to and fro, to the left first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Swing {
    amplitude_rad: f64,
    hz: f64,
    /// Part of a swing that is over: up to 0.5 the head is on the left.
    phase: f64,
    /// Light and time on the side on which the head is.
    light_s: f64,
    seconds: f64,
    /// The mean light on the left and on the right, the last time that the head was there.
    sides: [Option<f64>; 2],
}

impl Swing {
    pub(super) fn new(amplitude_rad: f64, hz: f64) -> Self {
        Self { amplitude_rad, hz, phase: 0.0, light_s: 0.0, seconds: 0.0, sides: [None; 2] }
    }

    /// The direction of the head, to the left of the body.
    pub(super) fn angle_rad(&self) -> f64 {
        self.amplitude_rad * math::sin(TAU * self.phase)
    }

    /// The rate at which the head turns to the left.
    pub(super) fn rate_rad_s(&self) -> f64 {
        self.amplitude_rad * TAU * self.hz * math::cos(TAU * self.phase)
    }

    /// Sees so much light for `dt_s` seconds, in which the head swings on. What both sides were like, as far as is
    /// known; equal as long as one is not.
    pub(super) fn see(&mut self, light: f64, dt_s: f64) -> Sides {
        self.light_s += light * dt_s;
        self.seconds += dt_s;
        let side = usize::from(self.phase >= 0.5);
        self.phase = (self.phase + self.hz * dt_s).fract();
        if side != usize::from(self.phase >= 0.5) && self.seconds > 0.0 {
            self.sides[side] = Some(self.light_s / self.seconds);
            (self.light_s, self.seconds) = (0.0, 0.0);
        }
        match self.sides {
            [Some(left), Some(right)] => Sides { left, right },
            _ => Sides::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_compares_what_it_saw_on_both_sides() {
        let mut swing = Swing::new(0.5, 0.5);
        let mut largest = 0.0_f64;
        for step in 0..399 {
            largest = largest.max(swing.angle_rad());
            let left = swing.angle_rad() > 0.0;
            let sides = swing.see(if left { 3.0 } else { 1.0 }, 0.01);
            // A swing takes 2 s.
            if step < 198 {
                assert_eq!(sides, Sides::default(), "{step}");
            } else if step > 202 {
                assert!(
                    (sides.left - 3.0).abs() < 0.05 && (sides.right - 1.0).abs() < 0.05,
                    "{step} {sides:?}"
                );
            }
        }
        assert!((largest - 0.5).abs() < 1e-3, "{largest}");
    }

    #[test]
    fn the_rate_is_that_of_the_angle() {
        let mut swing = Swing::new(0.5, 0.5);
        for _ in 0..300 {
            let before = swing;
            swing.see(0.0, 1e-4);
            let rate = (swing.angle_rad() - before.angle_rad()) / 1e-4;
            assert!((rate - before.rate_rad_s()).abs() < 1e-3);
        }
    }
}
