//! Light: illuminance from the arena's lamps and those that robots carry.
//!
//! A lamp of intensity I at distance d gives I cos θ / d² lux on a surface that is turned away by θ (the inverse
//! square law and Lambert's cosine). Walls cast shadows; light is not reflected.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

use baudbot_geometry::{Direction, Ray, angle, math};
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, levels};
use super::lowpass::LowPass;
use super::style::Style;
use super::{Measurement, Mount};
use crate::random::Stream;
use baudbot_fields::number::{Between, Number, Opening, Positive};
use baudbot_fields::{FieldError, Path};

/// A sensor of illuminance.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSensor {
    /// The place; its surface faces along its heading.
    pub mount: Mount,
    /// The opening angle for the surroundings, in radians.
    pub opening_rad: f64,
    /// No reading is larger, in lux.
    pub range_lux: f64,
    /// The time constant, in seconds.
    pub lag_s: f64,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Opening angle within which lamps are seen.
    #[serde(default = "half_turn")]
    opening_rad: Number<Opening>,
    /// Largest reading.
    range_lux: Number<Positive>,
    /// Time constant with which the reading follows the light.
    #[serde(default)]
    lag_s: Number<Between<0, 1000>>,
}

pub(super) fn half_turn() -> Number<Opening> {
    Number::of(PI)
}

impl Sense for LightSensor {
    const NAME: &str = "light";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#b58900");
    type Sheet = Sheet;
    type Memory = LowPass;

    fn new(sheet: Sheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let range_lux = sheet.range_lux.get();
        let device = Self {
            mount: fit.mount,
            opening_rad: sheet.opening_rad.get(),
            range_lux,
            lag_s: sheet.lag_s.get(),
        };
        Ok(Built::new(device, levels(fit.bits, 1, 0.0, range_lux)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "lx")]
    }

    fn acceptance_rad(&self) -> Option<f64> {
        Some(self.opening_rad)
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    /// Illuminance, in lux.
    fn read(&self, at: &Measurement<'_>, filter: &mut LowPass, _: &mut Stream, values: &mut [f64]) -> Effect {
        let lux = illuminance(at, &self.mount, self.opening_rad);
        values[0] = filter.follow(lux, self.lag_s, at.now);
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].clamp(0.0, self.range_lux);
    }
}

/// Illuminance of a surface at `mount` that sees the lamps within `opening_rad`, in lux.
pub(super) fn illuminance(at: &Measurement<'_>, mount: &Mount, opening_rad: f64) -> f64 {
    let surroundings = at.scene.surroundings;
    let pose = mount.world_from_sensor(at);
    let mut lux = surroundings.ambient_lux;
    for lamp in at.scene.frozen.lights.iter().filter(|lamp| lamp.robot != Some(at.scene.own)) {
        let way = lamp.position - pose.position;
        let (along, up) = (way.norm(), lamp.height_m - mount.height.above_floor_m);
        let bearing = Direction::from_angle(math::atan2(way.y, way.x));
        let turned = angle::wrap(bearing.angle() - pose.heading).abs();
        if turned > 0.5 * opening_rad {
            continue;
        }
        let shaded = lamp.shadows && {
            let ray = Ray { origin: pose.position, direction: bearing };
            let hit = mount.look(at, &pose, along).see(&ray);
            // A robot's body does not shade its own lamp.
            let is_carrier = |hit: &crate::scene::RayHit| {
                lamp.robot.is_some_and(|robot| at.scene.frozen.is_hit(hit, robot))
            };
            hit.is_some_and(|hit| !is_carrier(&hit) && hit.distance_m < along)
        };
        if !shaded {
            let distance2 = (along * along + up * up).max(NEAREST_M * NEAREST_M);
            let cosine = (math::cos(turned) * along / math::sqrt(distance2)).max(0.0);
            lux += lamp.intensity_cd * cosine / distance2;
        }
    }
    lux
}

/// A lamp is no point: nearer than this it gets no brighter.
const NEAREST_M: f64 = 0.01;
