//! The meaning of a reading of an infra-red sensor or a sonar: the objects in front of it.
//!
//! A reading of an infra-red sensor is the mean of what its rays reflect (3.12), (3.13), so half of a cone near by reads as a
//! whole one farther off.

use baudbot_brain::{Sensor, SensorKind};
use baudbot_geometry::{Direction, Pose, Vector, math};

use crate::vfh::sight::{self, Infrared};

/// An infra-red sensor or a sonar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Eye {
    pub(super) sensor: usize,
    pub(super) robot_from_sensor: Pose,
    pub(super) opening_rad: f64,
    pub(super) range_m: f64,
    /// The parameters of an infra-red sensor; the readings of a sonar are metres.
    infrared: Option<Infrared>,
    /// Nothing is taken to be nearer than that, in metres.
    least_m: f64,
    pub(super) stale_ns: u64,
    /// The instant at which the last reading came, in nanoseconds, and its value.
    pub(super) heard: Option<(u64, f64)>,
}

impl Eye {
    /// The sensor of this number, if it is wanted, and one by which something on the body is felt.
    pub(super) fn new(
        parameters: &sight::Parameters,
        infrared: Infrared,
        i: usize,
        sensor: &Sensor,
        radius_m: f64,
    ) -> Option<Self> {
        let is_wanted = parameters.names.is_empty() || parameters.names.contains(&sensor.name);
        let mount = sensor.mount.filter(|mount| is_wanted && mount.is_fixed_and_level())?;
        let range_m = sensor.range_m.filter(|range_m| range_m.is_finite() && *range_m > 0.0)?;
        if !matches!(sensor.kind, SensorKind::Infrared | SensorKind::Sonar) {
            return None;
        }
        let infrared = (sensor.kind == SensorKind::Infrared).then_some(infrared);
        Some(Self {
            sensor: i,
            robot_from_sensor: Pose::new(mount.x_m, mount.y_m, mount.heading_rad),
            opening_rad: parameters.cone_rad.or(sensor.opening_rad).unwrap_or_default().max(LEAST_CONE_RAD),
            range_m,
            infrared,
            least_m: LEAST * radius_m,
            stale_ns: STALE_NS.max(sensor.period_ns.saturating_mul(5)),
            heard: None,
        })
    }

    /// The directions of its rays.
    pub(super) fn rays(&self, world_from_sensor: &Pose) -> [Vector; RAYS] {
        std::array::from_fn(|i| {
            let part = i as f64 / (RAYS - 1) as f64 - 0.5;
            Direction::from_angle(world_from_sensor.heading + self.opening_rad * part).vector()
        })
    }

    /// So far its cone is certainly free, in metres: the reading is of one ray alone.
    pub(super) fn free_m(&self, value: f64, cell_m: f64) -> f64 {
        match self.infrared {
            None => value.min(self.range_m) - cell_m,
            Some(constants) => constants.far_m(RAYS as f64 * value, self.range_m).min(self.range_m),
        }
    }

    /// So near something may be, in metres: half of the cone is full of it. From a reading of a half on that is nearer and
    /// nearer, but not so near that a sensor that looks aside would stop the robot for what it passes.
    pub(super) fn near_m(&self, value: f64) -> f64 {
        match self.infrared {
            None if value >= self.range_m => f64::INFINITY,
            None => value,
            Some(constants) if 2.0 * value < 1.0 => constants.far_m(2.0 * value, self.range_m),
            Some(constants) => {
                (constants.far_m(1.0, self.range_m).min(self.range_m) * 2.0 * (1.0 - value)).max(self.least_m)
            }
        }
    }

    /// The possible error of a mark's place, in metres: within the distance at which a whole cone reads 1 the distance
    /// is unknown.
    pub(super) fn blur_m(&self) -> f64 {
        let range_m = self.range_m;
        self.infrared.map_or(0.0, |constants| BLUR * constants.far_m(1.0, range_m).min(0.5 * range_m))
    }

    /// The distance of an object that must be there, in metres, and the rays that may have met it, if these marks do
    /// not explain the reading.
    pub(super) fn unexplained(
        &self,
        value: f64,
        hits: &[Option<f64>; RAYS],
        cell_m: f64,
    ) -> Option<(f64, [bool; RAYS])> {
        let whole_m = self.infrared.map_or(value, |constants| constants.far_m(value, self.range_m));
        let explains = |hit: &Option<f64>| hit.is_some_and(|m| m <= SAME * whole_m + cell_m);
        let is_new = hits.each_ref().map(|hit| !explains(hit));
        let Some(constants) = self.infrared else {
            return (value < self.range_m && is_new.iter().all(|is_new| *is_new)).then_some((value, is_new));
        };
        let known: f64 =
            hits.iter().flatten().filter(|m| explains(&Some(**m))).map(|m| constants.reading(*m)).sum();
        let rest = value - known / RAYS as f64;
        let left = is_new.iter().filter(|is_new| **is_new).count();
        if left == 0 || rest < UNSURE * value {
            return None;
        }
        let distance_m = constants.far_m(rest * RAYS as f64 / left as f64, self.range_m);
        distance_m.is_finite().then_some((distance_m, is_new))
    }
}

impl Infrared {
    /// The reading of a ray that meets something at a distance, in metres (3.13).
    fn reading(&self, distance_m: f64) -> f64 {
        (self.c1_m2 / (distance_m * distance_m) + self.c2).min(1.0)
    }

    /// The distance of an object by the reading of a ray, in metres; infinite if it is not within the range.
    fn far_m(&self, reading: f64, range_m: f64) -> f64 {
        let least = self.reading(range_m).min(1.0);
        if reading < least {
            f64::INFINITY
        } else {
            math::sqrt(self.c1_m2 / (reading.min(1.0) - self.c2)).min(range_m)
        }
    }
}

/// Rays by which a cone is thought of.
pub(super) const RAYS: usize = 5;
/// Part of the distance at which a whole cone reads 1 by which marks are wrong.
const BLUR: f64 = 0.65;
/// A mark within this part of a distance explains it.
const SAME: f64 = 1.15;
/// The part of a reading that noise and coarse marks leave unexplained.
const UNSURE: f64 = 0.25;
/// Nothing is taken to be nearer to an infra-red sensor, in radii of the body: something ahead is then near enough to stop
/// for, and something at 60° is passed.
const LEAST: f64 = 0.36;
/// No cone is taken to be narrower, in radians.
const LEAST_CONE_RAD: f64 = 0.1;
/// The silence, in nanoseconds, after which a sensor is no longer used, if it is also five of its periods.
const STALE_NS: u64 = 500_000_000;
