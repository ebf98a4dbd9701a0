//! IR proximity sensor: Wahde 2016, Eqs. (3.9)–(3.14) and (3.1).
//!
//! Deviations. The notes give a ray no reading if d > D; ARSim, which we follow, if d ≥ D. ρ is limited to 1
//! before the mean is taken (3.13), and the mean's noise is clamped to [0, 1], as in ARSim. One ray looks
//! straight ahead, where (3.11) would divide by 0 (ARSim then always reads 0). ARSim draws its noise once a
//! ray and keeps the last; the distribution is that of one draw, which is what we do.

use baudbot_geometry::{Fan, Pose};

use super::{Measurement, noise};
use crate::random::Stream;

/// Where a sensor sits on its robot and which way it looks: robot from sensor.
pub type Mount = Pose;

/// What an IR sensor is.
#[derive(Clone, Debug, PartialEq)]
pub struct Infrared {
    /// Robot from sensor.
    pub mount: Mount,
    /// The N rays over the opening angle γ.
    pub fan: Fan,
    /// Range D, in metres.
    pub range_m: f64,
    /// c₁ of (3.13), in m².
    pub c1_m2: f64,
    /// c₂ of (3.13).
    pub c2: f64,
    /// σ of (3.1).
    pub sigma: f64,
}

impl Infrared {
    /// The reading S in [0, 1], larger when nearer: the mean of the rays' readings (3.12), with noise (3.1).
    pub(super) fn read(&self, at: &Measurement<'_>, stream: &mut Stream) -> f64 {
        let pose = at.motion.pose.compose(&self.mount);
        let eye = at.scene.look(pose.position, self.range_m);
        let sum: f64 = self
            .fan
            .rays(pose.position, pose.direction())
            .enumerate()
            .map(|(i, ray)| eye.cast(&ray).map_or(0.0, |d| self.ray_reading(d, self.fan.cos_kappa(i))))
            .sum();
        let mean = sum / self.fan.len() as f64;
        let sigma = if at.noise { self.sigma } else { 0.0 };
        noise::multiplicative(mean, sigma, stream).clamp(0.0, 1.0)
    }

    /// ρ of (3.13) for an obstacle at distance `d`.
    fn ray_reading(&self, d: f64, cos_kappa: f64) -> f64 {
        if d >= self.range_m {
            return 0.0;
        }
        // At d = 0 the quotient is infinite and the minimum 1, unless c₁ is 0 (0/0 is not a number, and
        // `min` then takes the other operand).
        (cos_kappa * (self.c1_m2 / (d * d) + self.c2)).min(1.0)
    }
}
