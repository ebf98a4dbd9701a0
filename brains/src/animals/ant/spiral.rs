//! Systematic search: a spiral about where the nest should be.
//!
//! Real ants search in loops that grow and come back to the middle, as the nest is likelier to be near it. The
//! spiral of Archimedes is simpler and misses nothing: r = p φ / 2π, with the pitch p from one winding to the next.

use std::f64::consts::TAU;

use baudbot_geometry::{Direction, Vector, math};

/// A place on a spiral that begins in the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spiral {
    pitch_m: f64,
    angle_rad: f64,
}

impl Spiral {
    /// The middle of a spiral with so much room between its windings, in metres.
    pub fn new(pitch_m: f64) -> Self {
        Self { pitch_m, angle_rad: 0.0 }
    }

    /// The place, in metres from the middle.
    pub fn place(&self) -> Vector {
        let turn = Direction::from_angle(self.angle_rad % TAU);
        turn.vector() * (self.pitch_m * self.angle_rad / TAU)
    }

    /// Goes on along the spiral by so many metres, in one step of the midpoint method.
    pub fn advance(&mut self, distance_m: f64) {
        // ds² = dr² + r² dφ², in units of p / 2π.
        let unit_m = self.pitch_m / TAU;
        let rate = |angle_rad: f64| 1.0 / (unit_m * math::hypot(1.0, angle_rad));
        let half_way = self.angle_rad + 0.5 * distance_m * rate(self.angle_rad);
        self.angle_rad += distance_m * rate(half_way);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windings_are_as_far_apart_as_the_pitch_and_as_long_as_they_should_be() {
        let mut spiral = Spiral::new(0.3);
        let (mut length, mut last) = (0.0, spiral.place());
        while spiral.angle_rad < 10.0 * TAU {
            spiral.advance(0.01);
            length += (spiral.place() - last).norm();
            last = spiral.place();
        }
        assert!((last.norm() - 3.0).abs() < 0.01, "{}", last.norm());
        // The arc: p/4π (φ √(1 + φ²) + asinh φ).
        let angle = spiral.angle_rad;
        let exact = 0.3 / (2.0 * TAU) * (angle * (1.0 + angle * angle).sqrt() + angle.asinh());
        assert!((length / exact - 1.0).abs() < 1e-3, "{length} {exact}");
    }

    #[test]
    fn it_passes_every_place_within_half_the_pitch() {
        let mut spiral = Spiral::new(0.4);
        let mut places = Vec::new();
        while spiral.place().norm() < 2.4 {
            places.push(spiral.place());
            spiral.advance(0.02);
        }
        for i in 0..400 {
            let (column, row) = (f64::from(i % 20), f64::from(i / 20));
            let place = Vector::new(0.2 * column - 1.9, 0.2 * row - 1.9);
            if place.norm() < 2.0 {
                let nearest = places.iter().map(|p| (p - place).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 0.201, "{place}: {nearest}");
            }
        }
    }
}
