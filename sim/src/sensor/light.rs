//! Light: illuminance from the arena's lamps and those that robots carry.
//!
//! A lamp of intensity I at distance d gives I cos θ / d² lux on a surface that is turned away by θ (the inverse
//! square law and Lambert's cosine). Walls cast shadows; light is not reflected.

use baudbot_geometry::{Direction, Ray, angle, math};

use super::lowpass::LowPass;
use super::{Measurement, Mount};

/// A sensor of illuminance.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSensor {
    /// Where it sits; its surface faces along its heading.
    pub mount: Mount,
    /// What it sees of the surroundings, in radians.
    pub opening_rad: f64,
    /// No reading is larger, in lux.
    pub range_lux: f64,
    /// How slowly it follows, in seconds.
    pub lag_s: f64,
}

impl LightSensor {
    /// Illuminance, in lux.
    pub(super) fn read(&self, at: &Measurement<'_>, filter: &mut LowPass) -> f64 {
        let lux = illuminance(at, &self.mount, self.opening_rad);
        filter.follow(lux, self.lag_s, at.now)
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
            let carrier = lamp.robot.map(crate::scene::What::Figure);
            hit.is_some_and(|sight| Some(sight.what) != carrier && sight.distance_m < along)
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
