//! Path integration: the vector home, from steps and headings.
//!
//! With a compass, the headings' errors do not add up. With errors of σ radians that are independent from step to
//! step, after n steps of length 1 the end is off by σ √n to the side. Without a compass, from turns that are each
//! wrong by σ, the error of the heading grows with every step, and the end is off by σ √(n (n+1) (2n+1) / 6), about
//! σ n^1.5 / √3. This is why an ant looks at the sky, and why odometry needs a compass.

use baudbot_geometry::{Direction, Vector, angle};

/// An ant's belief about its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathIntegrator {
    from_nest: Vector,
    heading_rad: f64,
}

impl Default for PathIntegrator {
    /// A `PathIntegrator` at the nest, looking along the x axis.
    fn default() -> Self {
        Self { from_nest: Vector::zeros(), heading_rad: 0.0 }
    }
}

impl PathIntegrator {
    /// Sets the heading by the compass, in radians.
    pub fn face(&mut self, heading_rad: f64) {
        self.heading_rad = heading_rad;
    }

    /// Adds a turn to the left, in radians.
    pub fn turn(&mut self, turn_rad: f64) {
        self.heading_rad = angle::wrap(self.heading_rad + turn_rad);
    }

    /// Adds a way in the direction of the present heading, in metres.
    pub fn walk(&mut self, distance_m: f64) {
        self.from_nest += Direction::from_angle(self.heading_rad).vector() * distance_m;
    }

    /// The heading, in radians.
    pub fn heading_rad(&self) -> f64 {
        self.heading_rad
    }

    /// The way home, in metres.
    pub fn home(&self) -> Vector {
        -self.from_nest
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::Chance;

    #[test]
    fn three_sides_of_a_square_leave_the_fourth() {
        let mut path = PathIntegrator::default();
        for _ in 0..3 {
            path.walk(2.0);
            path.turn(FRAC_PI_2);
        }
        assert!((path.home() - Vector::new(0.0, -2.0)).norm() < 1e-15, "{}", path.home());
        let mut path = PathIntegrator::default();
        for heading in [0.0, FRAC_PI_2, 2.0 * FRAC_PI_2] {
            path.face(heading);
            path.walk(2.0);
        }
        assert!((path.home() - Vector::new(0.0, -2.0)).norm() < 1e-15, "{}", path.home());
    }

    /// The error of the vector to the side after so many steps straight on: the root of the mean square of 1000 ants.
    fn error(steps: u32, step: impl Fn(&mut PathIntegrator, f64)) -> f64 {
        let mut chance = Chance::new(2, "ants");
        let squares = (0..1000).map(|_| {
            let mut path = PathIntegrator::default();
            for _ in 0..steps {
                step(&mut path, SIGMA * chance.normal());
                path.walk(1.0);
            }
            path.home().y * path.home().y
        });
        (squares.sum::<f64>() / 1000.0).sqrt()
    }

    const SIGMA: f64 = 0.002;

    #[test]
    fn without_a_compass_the_error_grows_with_the_power_of_one_and_a_half() {
        for steps in [25, 100, 400] {
            let found = error(steps, PathIntegrator::turn);
            let n = f64::from(steps);
            let exact = SIGMA * (n * (n + 1.0) * (2.0 * n + 1.0) / 6.0).sqrt();
            // A standard error is 2.2 %.
            assert!((found / exact - 1.0).abs() < 0.08, "{steps}: {found} {exact}");
            let about = SIGMA * n.powf(1.5) / 3.0_f64.sqrt();
            assert!((exact / about - 1.0).abs() < 0.04, "{steps}: {exact} {about}");
        }
    }

    #[test]
    fn with_a_compass_it_grows_with_the_square_root() {
        for steps in [25, 100, 400] {
            let found = error(steps, PathIntegrator::face);
            let exact = SIGMA * f64::from(steps).sqrt();
            assert!((found / exact - 1.0).abs() < 0.08, "{steps}: {found} {exact}");
        }
    }
}
