//! The arena: what a file may say of it, and what becomes of that.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use super::names::Names;
#[cfg(feature = "schema")]
use super::shapes::Corners;
use super::shapes::{corners, disc, each, look, outline, point, raised};
use super::things::{RawMovable, RawMover};
use super::trail::{MOST_CELLS, RawTrail, trail};
use baudbot_fields::number::{
    Between, Coordinate, Length, Millis, NotNegative, Number, Positive, Rule, Share,
};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::arena::{Arena, Pillar, Polygon};
use baudbot_sim::surroundings::{Field, Light, Region, Source, Surroundings, Zone};

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawArena {
    /// Walls and obstacles with corners.
    polygons: Vec<RawPolygon>,
    /// Round obstacles, such as pillars.
    circles: Vec<RawCircle>,
    /// Regions of the floor with special properties.
    zones: Vec<RawZone>,
    /// Lamps.
    lights: Vec<RawLight>,
    /// Scalar fields over the floor, such as scents.
    fields: Vec<RawField>,
    /// Things that move by themselves: doors, people.
    pub(super) movers: Vec<RawMover>,
    /// Things that robots push: boxes, balls.
    pub(super) movables: Vec<RawMovable>,
    /// Ambient light: the illuminance everywhere, without shadows.
    ambient_lux: Number<NotNegative>,
    /// Brightness of the floor outside zones with a `floor` of their own; 1 is white.
    floor: Number<Share>,
    /// The sky is hidden everywhere: satellite receivers have no fix.
    indoors: bool,
    /// Latitude of the arena's origin. x is east, y is north.
    latitude_deg: Number<Between<-89, 89>>,
    /// Longitude of the arena's origin.
    longitude_deg: Number<Between<-179, 179>>,
    /// Height of the floor above mean sea level, for satellite receivers.
    altitude_m: Number<Between<-500, 9000>>,
    /// Maps in other files: see [below](#files-that-a-scenario-refers-to).
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    maps: Vec<toml::Table>,
}

impl Default for RawArena {
    fn default() -> Self {
        Self {
            polygons: Vec::new(),
            circles: Vec::new(),
            zones: Vec::new(),
            lights: Vec::new(),
            fields: Vec::new(),
            movers: Vec::new(),
            movables: Vec::new(),
            ambient_lux: Number::default(),
            floor: Number::constant::<1>(),
            indoors: false,
            latitude_deg: Number::default(),
            longitude_deg: Number::default(),
            altitude_m: Number::default(),
            maps: Vec::new(),
        }
    }
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawPolygon {
    /// Unique among all obstacles. Range: see [names](#names).
    name: String,
    /// Corners in order. The last one may repeat the first. Type: list of `[x, y]`. Range: 2 to 4096 points, at least 3
    /// if solid; each −10^6 to 10^6.
    #[cfg_attr(feature = "schema", schemars(with = "Corners", length(min = 2, max = 4096)))]
    points_m: Vec<[f64; 2]>,
    /// `true`: the polygon is filled, so nothing can be in it, and its outline must not cross itself. `false`: only
    /// the outline is an obstacle, such as the border of a room.
    #[serde(default = "yes")]
    solid: bool,
    /// `true`: the last point is joined to the first. `false`: it is not, as in a wall with a gap. Range: a solid one
    /// is closed.
    #[serde(default = "yes")]
    closed: bool,
    /// Height. Sensors that are mounted higher see over it, but bodies hit it at any height. Default: unlimited.
    height_m: Option<Number<Length>>,
    /// Height at which it begins, as of a table: sensors that are mounted lower see under it. Bodies hit it at any height. Default: the floor. Range: to `height_m`.
    lower_edge_m: Option<Number<Length>>,
    /// Colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
    color: Option<[u8; 3]>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawCircle {
    /// Unique among all obstacles. Range: see [names](#names).
    name: String,
    /// Centre of the circle.
    x_m: Number<Coordinate>,
    /// Centre of the circle.
    y_m: Number<Coordinate>,
    /// Radius of the circle, which is solid.
    radius_m: Number<Length>,
    /// Height. Sensors that are mounted higher see over it. Default: unlimited.
    height_m: Option<Number<Length>>,
    /// Height at which it begins, as of a table: sensors that are mounted lower see under it. Bodies hit it at any height. Default: the floor. Range: to `height_m`.
    lower_edge_m: Option<Number<Length>>,
    /// Colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
    color: Option<[u8; 3]>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawZone {
    /// Unique among the zones. Range: see [names](#names).
    name: String,
    /// Corners in order; the outline must not cross itself. Type: list of `[x, y]`. Default: this or
    /// `radius_m`. Range: 3 to 4096 points; each −10^6 to 10^6.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Corners>", length(min = 3, max = 4096)))]
    points_m: Option<Vec<[f64; 2]>>,
    /// Centre of a disc. Default: required with `radius_m`.
    x_m: Option<Number<Coordinate>>,
    /// Centre of a disc. Default: required with `radius_m`.
    y_m: Option<Number<Coordinate>>,
    /// Radius of a disc. Default: this or `points_m`.
    radius_m: Option<Number<Length>>,
    /// Charging power for batteries here. Chargers of overlapping zones add up.
    #[serde(default)]
    charger_w: Number<NotNegative>,
    /// Brightness of the floor here. Where zones overlap, the last in the file counts. Default: the arena's.
    floor: Option<Number<Share>>,
    /// Fraction of its rolling that a wheel loses here: with 1 it spins on the spot. Where zones overlap, the largest
    /// slip counts, for each wheel separately. Encoders count the rolling; gyroscope, accelerometer and gps measure
    /// the body's motion.
    #[serde(default)]
    slip: Number<Share>,
    /// The sky is hidden here: satellite receivers have no fix.
    #[serde(default)]
    indoors: bool,
    /// Elevation up to which houses or trees hide the sky here, all around. A receiver with `satellites` loses those below; where zones
    /// overlap, the highest counts.
    #[serde(default)]
    horizon_deg: Number<Between<0, 90>>,
    /// Deviation of compasses here. Offsets of overlapping zones add up.
    #[serde(default)]
    compass_offset_rad: Number<Between<-10, 10>>,
    /// The zone is a goal, for `end.all_goals`.
    #[serde(default)]
    goal: bool,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawLight {
    /// Unique among the lights. Range: see [names](#names).
    name: String,
    /// Position of the lamp.
    x_m: Number<Coordinate>,
    /// Position of the lamp.
    y_m: Number<Coordinate>,
    /// Height above the floor.
    #[serde(default)]
    height_m: Number<Between<0, 1000>>,
    /// Luminous intensity, the same in all directions, in candela.
    intensity_cd: Number<Positive>,
    /// Period at which the lamp blinks. Without it, the lamp is always lit.
    blink_ms: Option<Number<Blink>>,
    /// Time for which the lamp is lit in each period, from the start of the period. Default: half the period. Range:
    /// to `blink_ms`; only with it.
    lit_ms: Option<Number<NotNegative>>,
    /// Obstacles cast shadows in its light.
    #[serde(default = "yes")]
    shadows: bool,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawField {
    /// Unique among the fields. Range: see [names](#names).
    name: String,
    /// Value at the origin without sources, in the field's own unit.
    #[serde(default)]
    background: Number<Amount>,
    /// Change per metre along x and along y. Type: `[x, y]`. Range: each −10^9 to 10^9.
    #[serde(default)]
    slope_per_m: [Number<Amount>; 2],
    /// Bell-shaped sources, which are added to the field.
    #[serde(default)]
    sources: Vec<RawSource>,
    /// Robots with a `dispenser` add to the field: see [below](#arenafieldstrail).
    trail: Option<RawTrail>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawSource {
    /// Centre of the bell.
    x_m: Number<Coordinate>,
    /// Centre of the bell.
    y_m: Number<Coordinate>,
    /// Height of the bell; a negative one makes a dip.
    strength: Number<Amount>,
    /// Standard deviation of the bell.
    width_m: Number<Length>,
}

/// A number of a field: so large that sums of them are numbers, too.
type Amount = Between<-1_000_000_000, 1_000_000_000>;

baudbot_fields::rules! {
    /// The period of a lamp that blinks, in milliseconds.
    Blink: Any, 0.01, 1e8;
}

fn yes() -> bool {
    true
}

type Result<T> = core::result::Result<T, FieldError>;

/// Obstacles that stand still.
pub(super) fn arena(path: &Path, raw: &RawArena, names: &mut Names) -> Result<Arena> {
    if !raw.maps.is_empty() {
        let problem = "refers to a file, which only the program that reads scenario files can look at; write polygons instead";
        return Err(path.field("maps").error(problem));
    }
    let mut polygons = Vec::new();
    for (i, raw) in raw.polygons.iter().enumerate() {
        polygons.push(polygon(&path.field("polygons").index(i), raw, names)?);
    }
    let mut pillars = Vec::new();
    for (i, circle) in raw.circles.iter().enumerate() {
        let path = path.field("circles").index(i);
        let name = names.take(&path.field("name"), &circle.name)?;
        let look = raised(look(circle.height_m, circle.color), &path, circle.lower_edge_m)?;
        pillars.push(Pillar { name, circle: disc(circle.x_m, circle.y_m, circle.radius_m), look });
    }
    Ok(Arena::new(polygons, pillars))
}

fn polygon(path: &Path, raw: &RawPolygon, names: &mut Names) -> Result<Polygon> {
    let name = names.take(&path.field("name"), &raw.name)?;
    let at = path.field("points_m");
    if raw.solid && !raw.closed {
        return Err(path
            .field("closed")
            .error("a solid polygon is closed; an open line needs solid = false"));
    }
    let points =
        if raw.solid { outline(&at, &raw.points_m) } else { corners(&at, &raw.points_m, raw.closed) }?;
    if points.len() < 2 {
        return Err(at.error(format!(
            "a hollow polygon has at least 2 corners in different places; this one has {}",
            points.len()
        )));
    }
    let look = raised(look(raw.height_m, raw.color), path, raw.lower_edge_m)?;
    Ok(Polygon { name, points, solid: raw.solid, closed: raw.closed, look })
}

/// What else there is.
pub(super) fn surroundings(path: &Path, raw: &RawArena, step_ns: u64) -> Result<Surroundings> {
    let mut names = Names::default();
    let zones = each(path, "zones", &raw.zones, |path, raw| zone(path, raw, &mut names))?;
    let mut names = Names::default();
    let lights = each(path, "lights", &raw.lights, |path, raw| light(path, raw, &mut names))?;
    let mut names = Names::default();
    let mut room = MOST_CELLS;
    let fields =
        each(path, "fields", &raw.fields, |path, raw| field(path, raw, &mut names, step_ns, &mut room))?;
    Ok(Surroundings {
        zones,
        lights,
        fields,
        ambient_lux: raw.ambient_lux.get(),
        floor: raw.floor.get(),
        indoors: raw.indoors,
        origin_deg: (raw.latitude_deg.get(), raw.longitude_deg.get()),
        altitude_m: raw.altitude_m.get(),
    })
}

fn zone(path: &Path, raw: &RawZone, names: &mut Names) -> Result<Zone> {
    let region = match (&raw.points_m, raw.x_m, raw.y_m, raw.radius_m) {
        (Some(points), None, None, None) => Region::Polygon(outline(&path.field("points_m"), points)?),
        (None, Some(x), Some(y), Some(radius)) => Region::Disc(disc(x, y, radius)),
        _ => return Err(path.error("needs either `points_m`, or `x_m`, `y_m` and `radius_m`")),
    };
    Ok(Zone {
        name: names.take(&path.field("name"), &raw.name)?,
        region,
        charger_w: raw.charger_w.get(),
        floor: raw.floor.map(Number::get),
        slip: raw.slip.get(),
        indoors: raw.indoors,
        horizon_rad: raw.horizon_deg.get().to_radians(),
        compass_offset_rad: raw.compass_offset_rad.get(),
        goal: raw.goal,
    })
}

fn light(path: &Path, raw: &RawLight, names: &mut Names) -> Result<Light> {
    let blink_ns = match (raw.blink_ms, raw.lit_ms) {
        (None, None) => None,
        (Some(period), lit) => {
            let period = period.get();
            let lit_ns = path.ms("lit_ms", lit.map_or(0.5 * period, Number::get), 0.0, period)?;
            Some((Millis::<Blink>::value(period), lit_ns))
        }
        (None, Some(_)) => return Err(path.field("lit_ms").error("needs `blink_ms`, the period")),
    };
    Ok(Light {
        name: names.take(&path.field("name"), &raw.name)?,
        position: point(raw.x_m, raw.y_m),
        height_m: raw.height_m.get(),
        intensity_cd: raw.intensity_cd.get(),
        blink_ns,
        shadows: raw.shadows,
    })
}

fn field(path: &Path, raw: &RawField, names: &mut Names, step_ns: u64, room: &mut f64) -> Result<Field> {
    let [x, y] = raw.slope_per_m.map(Number::get);
    let source = |raw: &RawSource| Source {
        position: point(raw.x_m, raw.y_m),
        strength: raw.strength.get(),
        width_m: raw.width_m.get(),
    };
    Ok(Field {
        name: names.take(&path.field("name"), &raw.name)?,
        background: raw.background.get(),
        slope_per_m: (x, y),
        sources: raw.sources.iter().map(source).collect(),
        trail: raw.trail.as_ref().map(|raw| trail(&path.field("trail"), raw, step_ns, room)).transpose()?,
    })
}
