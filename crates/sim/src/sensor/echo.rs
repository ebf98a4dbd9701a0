//! The strength of the echo of a target that sound meets: whether a sonar hears a thing that is small.
//!
//! A wide wall is a mirror. What comes back from it at a distance r is the sound of a source 2r away, of a pressure
//! proportional to 10^(−2 α r / 20) / (2r), with the absorption α of air in dB/m. Of a wall there works only the first Fresnel
//! zone, which is W = √(λ r / 2) wide and high. A target that fills a share s of it is as loud as s times a wall, and it is heard
//! if
//!
//! s ≥ (r / R) 10^(−α (R − r) / 10),
//!
//! where R is the distance beyond which a wall is not heard any more.
//!
//! - Of what is flat, the share is its width within 2 W around the ray that meets it over W, 1 at most; of what is round, with
//!   the radius a, it is √(a / (a + r)).
//! - A thing stands on the floor and is h high, so its share is less by the factor h / W, 1 at most.
//!
//! The two laws are those of plane and cylinder in acoustics. Deviations. The notes have no such thing: a sonar hears what one
//! of its rays meets. A wall is as loud from any side, as if it were rough; of a surface that runs away from the sensor
//! only what is nearer than half a pulse behind the nearest point counts. The pulse has eight periods of 40 kHz, and α is that
//! of air at 20 °C and a humidity of 50 %, about 1.3 dB/m.

use alloc::vec::Vec;

use baudbot_geometry::{Direction, Fan, Pose, Ray, Vector, math};

use crate::scene::Viewpoint;

/// Of the usual sonars, in Hz.
const FREQUENCY_HZ: f64 = 40e3;

/// α, in dB/m.
const ABSORPTION_DB_M: f64 = 1.3;

/// Periods of a pulse.
const PERIODS: f64 = 8.0;

/// So many rays are sent to one side within W, to see how wide something is.
const FINENESS: i32 = 32;

/// A target that is nearer than this, in metres, is as loud as here.
const NEAR_M: f64 = 0.01;

/// The strength that echoes must have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// R: a wall that is farther away is not heard, in metres.
    wall_range_m: f64,
    /// λ, in metres.
    wavelength_m: f64,
}

impl Echo {
    /// A sonar that hears walls up to `wall_range_m` away, where sound runs at `sound_m_s`.
    pub(super) fn new(wall_range_m: f64, sound_m_s: f64) -> Self {
        Self { wall_range_m, wavelength_m: sound_m_s / FREQUENCY_HZ }
    }

    /// The distance of the nearest thing that is loud enough, of those that the fan's rays meet.
    #[cold]
    #[inline(never)]
    pub(super) fn nearest(&self, viewpoint: &Viewpoint<'_>, pose: &Pose, fan: &Fan) -> Option<f64> {
        let mut met = Vec::new();
        viewpoint.each(pose, fan, |i, distance_m| {
            if distance_m.is_finite() {
                met.push((distance_m, i));
            }
        });
        met.sort_by(|a, b| a.0.total_cmp(&b.0));
        let forward = pose.direction();
        let ray = |i: usize| Ray { origin: pose.position, direction: forward.rotate(fan.relative()[i]) };
        met.into_iter().find(|&(_, i)| self.hears(viewpoint, &ray(i))).map(|(distance_m, _)| distance_m)
    }

    /// Whether what this ray meets is loud enough.
    fn hears(&self, viewpoint: &Viewpoint<'_>, ray: &Ray) -> bool {
        let Some(hit) = viewpoint.see(ray) else { return false };
        let r = hit.distance_m.max(NEAR_M);
        let zone_m = math::sqrt(0.5 * self.wavelength_m * r);
        let wide = match viewpoint.radius_of(&hit) {
            Some(radius_m) => math::sqrt(radius_m / (radius_m + r)),
            None => self.width(viewpoint, ray, (r, zone_m)),
        };
        let high = (viewpoint.look_of(&hit).height_m / zone_m).min(1.0);
        wide * high >= self.least_share(r)
    }

    /// The share s of a zone that is just heard at a distance, in metres.
    fn least_share(&self, r: f64) -> f64 {
        let behind_m = self.wall_range_m - r;
        let air = math::exp(-core::f64::consts::LN_10 / 10.0 * ABSORPTION_DB_M * behind_m);
        r / self.wall_range_m * air
    }

    /// The fraction of a zone that is filled by things about as far away as the one that the ray meets, on both sides
    /// of it.
    fn width(&self, viewpoint: &Viewpoint<'_>, ray: &Ray, (r, zone_m): (f64, f64)) -> f64 {
        let ahead = ray.direction.vector() * r;
        let left = Vector::new(-ray.direction.sin, ray.direction.cos) * (zone_m / f64::from(FINENESS));
        let half_pulse_m = 0.5 * PERIODS * self.wavelength_m;
        let is_filled = |i: &i32| {
            let way = ahead + left * f64::from(*i);
            let length = way.norm();
            let direction = Direction { cos: way.x / length, sin: way.y / length };
            let met = viewpoint.cast(&Ray { origin: ray.origin, direction });
            met.is_some_and(|distance_m| (distance_m - r).abs() <= half_pulse_m)
        };
        let filled = (-FINENESS..=FINENESS).filter(is_filled).count();
        (filled as f64 / f64::from(FINENESS)).min(1.0)
    }
}
