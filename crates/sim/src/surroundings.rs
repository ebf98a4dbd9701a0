//! The surroundings: zones of the floor, lights, and fields such as a scent.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Twist, math, polygon};

use crate::drive::{Deviation, Drive, Motion, Wheels};
use crate::time::SimTime;
use crate::trail::TrailGrid;

/// All of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// Regions of the floor, in the scenario's order.
    pub zones: Vec<Zone>,
    /// Lamps with a place.
    pub lights: Vec<Light>,
    /// Scalar fields.
    pub fields: Vec<Field>,
    /// Light that is everywhere, in lux.
    pub ambient_lux: f64,
    /// The fraction of the light that the bare floor throws back, in [0, 1].
    pub floor: f64,
    /// Whether the sky is hidden, so that no satellite is received.
    pub indoors: bool,
    /// Latitude and longitude of the arena's origin, in degrees; x is east, y is north.
    pub origin_deg: (f64, f64),
    /// Height of the floor above mean sea level, in metres.
    pub altitude_m: f64,
}

/// A region of the floor where something is different.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Unique among the zones.
    pub name: String,
    /// The region.
    pub region: Region,
    /// Power that a battery is charged with here, in watts.
    pub charger_w: f64,
    /// Reflectance of the floor, if it differs, in [0, 1].
    pub floor: Option<f64>,
    /// Share of its rolling that a wheel loses here, in [0, 1]: 0 on good ground, 1 if it spins on the spot.
    pub slip: f64,
    /// Whether the sky is hidden.
    pub indoors: bool,
    /// Elevation up to which the sky is hidden all around, in radians.
    pub horizon_rad: f64,
    /// The turn of compasses here, in radians.
    pub compass_offset_rad: f64,
    /// Whether it is a place to be reached: the referee counts who has been there.
    pub goal: bool,
}

/// A part of the plane.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// A disc.
    Disc(Circle),
    /// The inside of a simple polygon.
    Polygon(Vec<Point>),
}

impl Region {
    /// The distance from the origin to the point that is farthest from it, in metres.
    pub fn reach_m(&self) -> f64 {
        match self {
            Self::Disc(disc) => disc.center.coords.norm() + disc.radius,
            Self::Polygon(points) => polygon::bounding_radius(points),
        }
    }

    /// Whether `point` is in it.
    pub fn contains(&self, point: Point) -> bool {
        match self {
            Self::Disc(disc) => (point - disc.center).norm_squared() <= disc.radius * disc.radius,
            Self::Polygon(points) => polygon::contains(points, point),
        }
    }
}

/// A lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Unique among the lights.
    pub name: String,
    /// The place.
    pub position: Point,
    /// The height, in metres.
    pub height_m: f64,
    /// Luminous intensity, the same in all directions, in candela.
    pub intensity_cd: f64,
    /// If it blinks: the period and how long of it the lamp is lit, from its start, in nanoseconds.
    pub blink_ns: Option<(u64, u64)>,
    /// Whether walls shade it.
    pub shadows: bool,
}

impl Light {
    /// The light that it gives at `now`.
    pub(crate) fn lit(&self, now: SimTime) -> Option<Lit> {
        let on = self.blink_ns.is_none_or(|(period, lit)| now.as_ns() % period < lit);
        on.then_some(Lit {
            position: self.position,
            height_m: self.height_m,
            intensity_cd: self.intensity_cd,
            shadows: self.shadows,
            robot: None,
        })
    }
}

/// A lamp that is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lit {
    pub(crate) position: Point,
    pub(crate) height_m: f64,
    pub(crate) intensity_cd: f64,
    pub(crate) shadows: bool,
    /// The robot that carries it, which does not see its own.
    pub(crate) robot: Option<usize>,
}

/// A scalar field over the plane, such as the strength of a scent: a background, a slope, and bells.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Unique among the fields.
    pub name: String,
    /// Value far from everything, in the field's own unit.
    pub background: f64,
    /// Change a metre along x and along y.
    pub slope_per_m: (f64, f64),
    /// Bells on top.
    pub sources: Vec<Source>,
    /// The grid of what robots add to it, if they can.
    pub trail: Option<TrailGrid>,
}

/// A Gaussian bell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// The source's middle.
    pub position: Point,
    /// The source's height.
    pub strength: f64,
    /// The source's standard deviation, in metres.
    pub width_m: f64,
}

impl Field {
    /// The value at a point, without what robots have added.
    pub fn at(&self, point: Point) -> f64 {
        let (x, y) = self.slope_per_m;
        let bell = |source: &Source| {
            let distance2 = (point - source.position).norm_squared();
            source.strength * math::exp(-distance2 / (2.0 * source.width_m * source.width_m))
        };
        self.background + x * point.x + y * point.y + self.sources.iter().map(bell).sum::<f64>()
    }
}

impl Surroundings {
    /// The zones that a point is in.
    pub fn zones_at(&self, point: Point) -> impl Iterator<Item = &Zone> {
        self.zones.iter().filter(move |zone| zone.region.contains(point))
    }

    /// Reflectance of the floor at a point: that of the last zone that has one.
    pub fn floor_at(&self, point: Point) -> f64 {
        self.zones_at(point).filter_map(|zone| zone.floor).last().unwrap_or(self.floor)
    }

    /// The largest slip of the zones that a point is in.
    pub fn slip_at(&self, point: Point) -> f64 {
        self.zones_at(point).map(|zone| zone.slip).fold(0.0, f64::max)
    }

    /// The distances that a robot's wheels carry it for each metre that they seem to roll, in its place; `None`: a metre.
    #[inline]
    pub(crate) fn grip_of(&self, drive: &Drive, motion: &Motion) -> Option<Wheels> {
        if self.zones.is_empty() && drive.deviation.is_none() {
            None
        } else {
            self.grip_in_zones(drive, motion)
        }
    }

    /// The grip of a robot that differs from its data sheet, or in an arena with zones.
    fn grip_in_zones(&self, drive: &Drive, motion: &Motion) -> Option<Wheels> {
        if !self.zones.iter().any(|zone| zone.slip > 0.0) {
            return drive.deviation.map(|deviation| deviation.wheels);
        }
        let wheel = |y| 1.0 - self.slip_at(motion.pose.transform(Point::new(0.0, y)));
        let grip = Wheels { left: wheel(drive.half_track_m), right: wheel(-drive.half_track_m) };
        let Some(Deviation { wheels, .. }) = drive.deviation else { return Some(grip) };
        Some(Wheels { left: wheels.left * grip.left, right: wheels.right * grip.right })
    }

    /// A robot's true motion, which is that of its rolling wheels but for slip and for its deviation from its data sheet.
    #[inline]
    pub(crate) fn over_ground(&self, drive: &Drive, motion: &Motion) -> Twist {
        let rolled = motion.rolled();
        self.grip_of(drive, motion).map_or(rolled, |grip| drive.carried(rolled, grip))
    }

    /// The distance that a robot is carried for each metre that its wheels roll, and the speed, in m/s, by its
    /// turning alone, if that is not 1 and 0.
    pub(crate) fn share_over_ground(&self, drive: &Drive, motion: &Motion) -> Option<(f64, f64)> {
        let grip = self.grip_of(drive, motion)?;
        let carried = |forward| drive.carried(Twist { forward, turn: motion.turn_rate_rad_s }, grip).forward;
        let turned = carried(0.0);
        Some((carried(1.0) - turned, turned))
    }

    /// Power of the chargers at a point, in watts.
    pub fn charger_at(&self, point: Point) -> f64 {
        self.zones_at(point).map(|zone| zone.charger_w).sum()
    }

    /// The turn of a compass at a point, in radians.
    pub fn compass_offset_at(&self, point: Point) -> f64 {
        self.zones_at(point).map(|zone| zone.compass_offset_rad).sum()
    }

    /// Whether the sky is seen from a point.
    pub fn sky_at(&self, point: Point) -> bool {
        !self.indoors && !self.zones_at(point).any(|zone| zone.indoors)
    }

    /// Elevation up to which the sky is hidden at a point, in radians.
    pub fn horizon_at(&self, point: Point) -> f64 {
        self.zones_at(point).map(|zone| zone.horizon_rad).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bell_has_its_strength_in_the_middle_and_falls_off() {
        let source = Source { position: Point::new(1.0, 0.0), strength: 2.0, width_m: 0.5 };
        let field = Field {
            name: "f".into(),
            background: 1.0,
            slope_per_m: (0.5, 0.0),
            sources: alloc::vec![source],
            trail: None,
        };
        assert_eq!(field.at(Point::new(1.0, 0.0)), 3.5);
        let one_sigma = field.at(Point::new(1.0, 0.5));
        assert!((one_sigma - (1.5 + 2.0 * (-0.5_f64).exp())).abs() < 1e-15, "{one_sigma}");
    }

    #[test]
    fn a_blinking_lamp_is_lit_at_the_start_of_its_period() {
        let light = Light {
            name: "l".into(),
            position: Point::origin(),
            height_m: 0.0,
            intensity_cd: 1.0,
            blink_ns: Some((10, 4)),
            shadows: true,
        };
        let lit = |ns| light.lit(SimTime::from_ns(ns)).is_some();
        assert_eq!([lit(0), lit(3), lit(4), lit(9), lit(10)], [true, true, false, false, true]);
    }
}
