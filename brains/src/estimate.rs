//! A robot's belief about its pose, with its uncertainty.

use baudbot_brain::BelievedPose;
use baudbot_geometry::{Pose, math};
use nalgebra::{Matrix3, Vector3};

/// A pose with the covariance of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Robot in the world.
    pub world_from_robot: Pose,
    /// The covariance of x and y in metres, along the world's axes, and of the heading in radians.
    pub covariance: Matrix3<f64>,
}

impl Estimate {
    /// A pose that is known exactly.
    #[must_use]
    pub fn exact(world_from_robot: Pose) -> Self {
        Self { world_from_robot, covariance: Matrix3::zeros() }
    }

    /// A pose with these standard deviations along each axis, in metres, and of the heading, in radians.
    #[must_use]
    pub fn within(world_from_robot: Pose, sd_m: f64, sd_rad: f64) -> Self {
        let variances = Vector3::new(sd_m * sd_m, sd_m * sd_m, sd_rad * sd_rad);
        Self { world_from_robot, covariance: Matrix3::from_diagonal(&variances) }
    }

    /// The same in another frame of the world, with the error's axes.
    #[must_use]
    pub(crate) fn moved(&self, new_from_old: &Pose) -> Self {
        let (sin, cos) = math::sin_cos(new_from_old.heading);
        #[rustfmt::skip]
        let turn = Matrix3::new(
            cos, -sin, 0.0,
            sin,  cos, 0.0,
            0.0,  0.0, 1.0,
        );
        let world_from_robot = new_from_old.compose(&self.world_from_robot);
        Self { world_from_robot, covariance: turn * self.covariance * turn.transpose() }
    }

    /// The pose as observers are shown it.
    #[must_use]
    pub fn shown(&self) -> BelievedPose {
        let Self { world_from_robot: Pose { position, heading }, covariance } = self;
        BelievedPose {
            x_m: position.x,
            y_m: position.y,
            heading_rad: *heading,
            covariance_m2: Some([covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]]),
        }
    }

    /// The root of the mean square distance of the true position from the estimated one, in metres.
    #[must_use]
    pub fn position_sd_m(&self) -> f64 {
        math::sqrt(self.covariance[(0, 0)] + self.covariance[(1, 1)])
    }

    /// The standard deviation of the heading, in radians.
    #[must_use]
    pub fn heading_sd_rad(&self) -> f64 {
        math::sqrt(self.covariance[(2, 2)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_are_those_that_it_was_made_with() {
        let estimate = Estimate::within(Pose::new(1.0, 2.0, 3.0), 0.3, 0.05);
        assert!((estimate.position_sd_m() - 0.3 * 2.0_f64.sqrt()).abs() < 1e-15);
        assert!((estimate.heading_sd_rad() - 0.05).abs() < 1e-15);
        assert_eq!(Estimate::exact(Pose::new(1.0, 2.0, 3.0)).position_sd_m(), 0.0);
    }

    #[test]
    fn an_error_along_x_is_along_y_after_a_quarter_of_a_turn() {
        let covariance = Matrix3::new(4.0, 0.0, 0.3, 0.0, 1.0, 0.0, 0.3, 0.0, 0.1);
        let estimate = Estimate { world_from_robot: Pose::new(1.0, 0.0, 0.5), covariance };
        let moved = estimate.moved(&Pose::new(2.0, 0.0, std::f64::consts::FRAC_PI_2));
        let expected = Matrix3::new(1.0, 0.0, 0.0, 0.0, 4.0, 0.3, 0.0, 0.3, 0.1);
        assert!((moved.covariance - expected).norm() < 1e-12, "{moved:?}");
        let Pose { position, heading } = moved.world_from_robot;
        assert!((position.x - 2.0).abs() < 1e-12 && (position.y - 1.0).abs() < 1e-12);
        assert!((heading - 0.5 - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}
