//! Local positioning by infra-red beacons (Section 6.3), two spots of light on the ceiling, as Evolution Robotics' Northstar does it: a projector throws them
//! there, and a sensor that looks up tells them apart and measures the direction of each.
//!
//! At the horizontal distance d from a spot on a ceiling H above the sensor, the light comes at the angle θ from the vertical, tan θ = d / H.
//! Directions are measured with an error N(0, σ²) along two axes, which moves the spot's image on the ceiling, away from the sensor and across, by
//!
//! e_r = H σ / cos² θ, e_t = H σ / cos θ
//!
//! With the images m₁ and m₂ in the sensor's frame of the spots b₁ and b₂ its heading and place are
//!
//! φ = arg(b₂ − b₁) − arg(m₂ − m₁), p = (b₁ + b₂) / 2 − R(φ) (m₁ + m₂) / 2
//!
//! Deviations. The notes name the system in a sentence and compute nothing. Errors are of first order in σ, independent, and new at each read; those that stay,
//! of lens and mounting, are left out, and the heights are known exactly. Light comes through what is lower than the sensor, and through nothing that is
//! higher, however low that is. Other lamps do not disturb it, and its reach has no limit but its field of view.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

use baudbot_geometry::{Direction, Point, Pose, Ray, Vector, angle, math};
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, level};
use super::style::Style;
use super::{Measurement, Mount};
use crate::random::Stream;
use baudbot_fields::number::{Coordinate, Length, Number, Opening, Sigma};
use baudbot_fields::{FieldError, Path};

/// The model of a sensor of spots on the ceiling.
#[derive(Clone, Debug, PartialEq)]
pub struct IrBeacons {
    /// The place; its first axis is along its heading.
    pub mount: Mount,
    /// The spots, in metres, in the arena's frame.
    pub spots: [Point; 2],
    /// The ceiling's height above the sensor, in metres.
    pub above_m: f64,
    /// The opening angle of the cone in which it sees, about the vertical.
    pub opening_rad: f64,
    /// Standard deviation of a direction, along each of two axes, in radians.
    pub sigma_rad: f64,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Places of the two spots. Type: two `[x, y]`. Range: each −10^6 to 10^6; at least a centimetre apart.
    spots_m: [[Number<Coordinate>; 2]; 2],
    /// Height of the ceiling above the floor. Range: above the sensor.
    ceiling_m: Number<Length>,
    /// Opening angle of the cone about the vertical in which the sensor sees.
    opening_rad: Number<Opening>,
    /// Standard deviation of the error of a spot's direction, along each of two axes, new at each read.
    #[serde(default)]
    sigma_rad: Number<Sigma>,
    /// With `bits`: x and y are sent as levels from minus this to this, the heading as a level from −π to π.
    #[serde(default = "Number::<Length>::constant::<10>")]
    position_range_m: Number<Length>,
}

impl Sense for IrBeacons {
    const NAME: &str = "ir-beacons";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#999933");
    const IS_ANALOG: bool = false;
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let spots = sheet.spots_m.map(|[x, y]| Point::new(x.get(), y.get()));
        if (spots[1] - spots[0]).norm() < LEAST_BASE_M {
            return Err(path.field("spots_m").error("must be two places at least 0.01 m apart"));
        }
        let (ceiling_m, height_m) = (sheet.ceiling_m.get(), fit.mount.height.above_floor_m);
        if ceiling_m <= height_m {
            let problem =
                alloc::format!("must be above the sensor, which is {height_m} m high, is {ceiling_m}");
            return Err(path.field("ceiling_m").error(problem));
        }
        let range = sheet.position_range_m.get();
        let position = level(fit.bits, -range, range);
        let encodings = vec![position, position, level(fit.bits, -PI, PI), level(fit.bits, 0.0, 2.0)];
        let device = Self {
            mount: fit.mount,
            spots,
            above_m: ceiling_m - height_m,
            opening_rad: sheet.opening_rad.get(),
            sigma_rad: sheet.sigma_rad.get(),
        };
        Ok(Built::new(device, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![
            Component::one("x_m", "m"),
            Component::one("y_m", "m"),
            Component::one("heading_rad", "rad"),
            Component::one("spots", "1"),
        ]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    /// The sensor's own pose in the arena's frame, and the number of spots that it sees: with fewer than two the pose is 0.
    fn read(&self, at: &Measurement<'_>, _: &mut (), stream: &mut Stream, values: &mut [f64]) -> Effect {
        let pose = self.mount.world_from_sensor(at);
        let seen = self.spots.iter().filter(|spot| self.sees(at, &pose, **spot)).count();
        values.copy_from_slice(&[0.0, 0.0, 0.0, seen as f64]);
        if seen == self.spots.len() {
            let sensor_from_world = pose.inverse();
            let sigma_rad = if at.noise { self.sigma_rad } else { 0.0 };
            let images = self.spots.map(|spot| {
                let image = sensor_from_world.transform(spot).coords;
                image + self.error(image, sigma_rad, stream)
            });
            let found = self.pose_of(images);
            values[..3].copy_from_slice(&[found.position.x, found.position.y, found.heading]);
        }
        Effect::NONE
    }
}

impl IrBeacons {
    /// Whether a spot is in the cone, and no wall in between.
    fn sees(&self, at: &Measurement<'_>, pose: &Pose, spot: Point) -> bool {
        let way = spot - pose.position;
        let along_m = way.norm();
        if math::atan2(along_m, self.above_m) > 0.5 * self.opening_rad {
            return false;
        }
        let ray = Ray { origin: pose.position, direction: Direction::from_angle(math::atan2(way.y, way.x)) };
        self.mount.look(at, pose, along_m).see(&ray).is_none_or(|hit| hit.distance_m >= along_m)
    }

    /// The displacement of an image on the ceiling by an error of its direction.
    fn error(&self, image: Vector, sigma_rad: f64, stream: &mut Stream) -> Vector {
        if sigma_rad == 0.0 {
            return Vector::zeros();
        }
        let away = Direction::from_angle(math::atan2(image.y, image.x));
        let cosine = self.above_m / math::hypot(image.norm(), self.above_m);
        let across_m = self.above_m * sigma_rad / cosine;
        away.apply(Vector::new(across_m / cosine * stream.normal(), across_m * stream.normal()))
    }

    /// The sensor's pose that shows it the spots there.
    fn pose_of(&self, images: [Vector; 2]) -> Pose {
        let bearing = |way: Vector| math::atan2(way.y, way.x);
        let turn = bearing(self.spots[1] - self.spots[0]) - bearing(images[1] - images[0]);
        let middle = self.spots[0] + 0.5 * (self.spots[1] - self.spots[0]);
        let position = middle - Direction::from_angle(turn).apply(0.5 * (images[0] + images[1]));
        Pose { position, heading: angle::wrap(turn) }
    }
}

/// Spots that are nearer tell no heading.
const LEAST_BASE_M: f64 = 0.01;
