//! IR proximity sensor: Wahde 2016, Eqs. (3.9)–(3.14) and (3.1); from measured samples (3.2); and as a meter of
//! the light around it.
//!
//! Deviations. The notes give a ray no reading if d > D; ARSim, which we follow, if d ≥ D. ρ is limited to 1
//! before the mean is taken (3.13), and the mean's noise is clamped to [0, 1], as in ARSim. One ray looks
//! straight ahead, where (3.11) would divide by 0 (ARSim then always reads 0). ARSim draws its noise once a
//! ray and keeps the last; the distribution is that of one draw, which is what we do.

use baudbot_geometry::Fan;

use super::lookup::Lookup;
use super::{Measurement, Mount, light};
use crate::random::Stream;

/// What an IR sensor is.
#[derive(Clone, Debug, PartialEq)]
pub struct Infrared {
    /// Where it sits.
    pub mount: Mount,
    /// The N rays over the opening angle γ.
    pub fan: Fan,
    /// Range D, in metres.
    pub range_m: f64,
    /// How a reading comes about.
    pub model: InfraredModel,
}

/// How an IR reading comes about.
#[derive(Clone, Debug, PartialEq)]
pub enum InfraredModel {
    /// Equations (3.12) and (3.13).
    Phenomenological {
        /// c₁ of (3.13), in m².
        c1_m2: f64,
        /// c₂ of (3.13).
        c2: f64,
    },
    /// Interpolated between samples of a real sensor (3.2).
    Lookup(Lookup),
    /// The emitter is off: 1 in the dark, falling to 0 at so many lux, as a Khepera's ambient mode.
    Ambient {
        /// Light at which it reads 0.
        saturation_lux: f64,
        /// What it sees of the surroundings, in radians; a fan of a single ray does not tell.
        opening_rad: f64,
    },
}

impl Infrared {
    /// The reading S in [0, 1], larger when nearer: the mean of the rays' readings (3.12).
    pub(super) fn read(&self, at: &Measurement<'_>, stream: &mut Stream) -> f64 {
        match &self.model {
            InfraredModel::Phenomenological { c1_m2, c2 } => self.reflected(at, *c1_m2, *c2),
            InfraredModel::Lookup(lookup) => self.sampled(at, lookup, stream),
            InfraredModel::Ambient { saturation_lux, opening_rad } => {
                1.0 - light::illuminance(at, &self.mount, *opening_rad) / saturation_lux
            }
        }
    }

    fn reflected(&self, at: &Measurement<'_>, c1_m2: f64, c2: f64) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        let eye = self.mount.look(at, &pose, self.range_m);
        let reading = |d: f64, cos_kappa: f64| {
            if d >= self.range_m {
                return 0.0;
            }
            // At d = 0 the quotient is infinite and the minimum 1, unless c₁ is 0 (0/0 is not a number, and
            // `min` then takes the other operand).
            (cos_kappa * (c1_m2 / (d * d) + c2)).min(1.0)
        };
        let mut sum = 0.0;
        eye.each(&pose, &self.fan, |i, d| sum += reading(d, self.fan.cos_kappa(i)));
        sum / self.fan.len() as f64
    }

    /// The distance L and the angle are those of the ray that comes back first; if none does, the reading is
    /// one of the samples at the largest distance.
    fn sampled(&self, at: &Measurement<'_>, lookup: &Lookup, stream: &mut Stream) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        let eye = self.mount.look(at, &pose, self.range_m);
        let seen =
            self.fan.rays(pose.position, pose.direction()).filter_map(|ray| Some((ray, eye.see(&ray)?)));
        let nearest = seen.reduce(|a, b| if b.1.distance_m < a.1.distance_m { b } else { a });
        let (distance_m, angle_rad) = nearest
            .map_or((f64::INFINITY, 0.0), |(ray, sight)| (sight.distance_m, eye.incidence_rad(&ray, &sight)));
        lookup.read(distance_m, angle_rad, at.noise.then_some(stream))
    }
}
