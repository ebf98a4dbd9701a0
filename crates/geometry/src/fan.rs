//! The rays of one sensor: Wahde, Eqs. (3.10), (3.11) and (3.14).
//!
//! *Deviations.*
//!
//! - One ray alone points straight ahead. Eq. (3.11) would divide by zero.
//! - The relative angles are computed as multiples of half the spacing, counted from the middle. This is
//!   equal to Eq. (3.14), but rounded alike on both sides: the left half of the fan is the exact mirror
//!   image of the right half, and the middle ray of an odd number is exactly at 0.
//! - The sum in Eq. (3.10) is a product of rotations, so no trigonometry is done while the robot moves.

use alloc::vec::Vec;
use core::ops::Range;

use serde::{Deserialize, Serialize};

use crate::pose::{Direction, Point};
use crate::ray::Ray;

/// Equally spaced directions, relative to the forward direction of a sensor, from right to left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fan {
    kappas: Vec<f64>,
    relative: Vec<Direction>,
    /// Half the angle between two neighbours, in radians; 0 if there is only one ray.
    half_spacing: f64,
}

impl Fan {
    /// The bytes that it has on the heap.
    #[must_use]
    pub fn heap_bytes(&self) -> usize {
        size_of_val(&*self.kappas) + size_of_val(&*self.relative)
    }

    /// A fan of `rays` rays over an opening angle in radians, spaced by (3.11).
    ///
    /// The first and the last ray are the sides of the opening; over a full turn they coincide.
    ///
    /// # Panics
    ///
    /// If there are no rays.
    #[must_use]
    pub fn new(opening_rad: f64, rays: usize) -> Self {
        assert!(rays >= 1, "a fan needs a ray");
        let gaps = rays - 1;
        let half_spacing = if gaps == 0 { 0.0 } else { 0.5 * (opening_rad / gaps as f64) };
        let kappas: Vec<_> = (0..rays).map(|i| ((2 * i) as f64 - gaps as f64) * half_spacing).collect();
        let relative = kappas.iter().map(|&kappa| Direction::from_angle(kappa)).collect();
        Self { kappas, relative, half_spacing }
    }

    /// The number of rays, at least 1.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a fan is never empty")]
    pub fn len(&self) -> usize {
        self.relative.len()
    }

    /// The angle from the first ray to the last, in radians; 0 of a single ray.
    #[must_use]
    pub fn opening_rad(&self) -> f64 {
        2.0 * (self.len() - 1) as f64 * self.half_spacing
    }

    /// The relative ray angles, in radians. Eq. (3.14).
    #[must_use]
    pub fn kappas(&self) -> &[f64] {
        &self.kappas
    }

    /// The relative directions: those at the angles [`kappas`](Self::kappas).
    #[must_use]
    pub fn relative(&self) -> &[Direction] {
        &self.relative
    }

    /// The rays, by their places, whose relative angles are in an interval of angles in [-pi, pi]; the one before it
    /// may be among them. An interval that begins after its end wraps around behind the sensor, and has two parts.
    pub(crate) fn between(&self, from: f64, to: f64) -> [Range<usize>; 2] {
        if self.half_spacing == 0.0 {
            return [0..self.len(), 0..0];
        }
        // The conversions take what is below 0 to 0.
        let place = |kappa: f64| 0.5 * (kappa / self.half_spacing + (self.len() - 1) as f64);
        let first = (place(from) as usize).min(self.len());
        let end = ((place(to) + 1.0) as usize).min(self.len());
        if from <= to { [first..end.max(first), 0..0] } else { [first..self.len(), 0..end] }
    }

    /// The cosine of the relative angle of ray `i`, counted from 0, as Eq. (3.13) needs it.
    ///
    /// # Panics
    ///
    /// If there is no such ray.
    #[must_use]
    pub fn cos_kappa(&self, i: usize) -> f64 {
        self.relative[i].cos
    }

    /// The rays of a sensor at `origin` that looks `forward`, both in the world. Eq. (3.10), with
    /// `forward` at the angle phi + alpha.
    pub fn rays(&self, origin: Point, forward: Direction) -> impl ExactSizeIterator<Item = Ray> {
        self.relative.iter().map(move |&relative| Ray { origin, direction: forward.rotate(relative) })
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn one_ray_looks_ahead() {
        let fan = Fan::new(1.0, 1);
        assert_eq!(fan.kappas(), [0.0]);
        assert_eq!(fan.cos_kappa(0), 1.0);
    }

    /// (3.11).
    #[test]
    fn spacing_is_that_of_the_equation() {
        let (opening, n) = (1.1, 7);
        let fan = Fan::new(opening, n);
        let spacing = opening / (n - 1) as f64;
        for (i, kappa) in fan.kappas().iter().enumerate() {
            assert!((kappa - (-opening / 2.0 + i as f64 * spacing)).abs() < 1e-15);
        }
    }

    /// (3.14), on both sides to the last bit.
    #[test]
    fn halves_are_mirror_images() {
        let fan = Fan::new(1.3, 11);
        for (right, left) in fan.relative().iter().zip(fan.relative().iter().rev()) {
            assert_eq!(*right, left.inverse());
        }
        assert_eq!(fan.kappas()[5], 0.0);
    }

    /// (3.10).
    #[test]
    fn rays_turn_with_the_sensor() {
        let fan = Fan::new(1.0, 3);
        let forward = Direction::from_angle(FRAC_PI_2);
        let rays: Vec<_> = fan.rays(Point::new(1.0, 2.0), forward).collect();
        assert_eq!(rays.len(), fan.len());
        assert!((rays[0].direction.angle() - (FRAC_PI_2 - 0.5)).abs() < 1e-15);
        assert!((rays[2].direction.angle() - (FRAC_PI_2 + 0.5)).abs() < 1e-15);
    }

    #[test]
    #[should_panic(expected = "a fan needs a ray")]
    fn no_rays() {
        let _ = Fan::new(1.0, 0);
    }
}
