//! Compass: the heading with additive Gaussian noise, as ARSim's.

use baudbot_geometry::angle;

use super::{Measurement, noise};
use crate::random::Stream;

/// What a compass is.
#[derive(Clone, Debug, PartialEq)]
pub struct Compass {
    /// Standard deviation, in radians.
    pub sigma_rad: f64,
}

impl Compass {
    /// Heading in (−π, π], in radians, counter-clockwise from the x axis.
    pub(super) fn read(&self, at: &Measurement<'_>, stream: &mut Stream) -> f64 {
        let sigma = if at.noise { self.sigma_rad } else { 0.0 };
        angle::wrap(noise::additive(at.motion.pose.heading, sigma, stream))
    }
}
