//! The arena: what a file may say of it, and what becomes of that.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use super::names::Names;
use super::shapes::{corners, disc, look, outline, point};
use super::things::{RawMovable, RawMover};
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
    /// Scents and the like.
    fields: Vec<RawField>,
    /// Things that move by themselves: doors, people.
    pub(super) movers: Vec<RawMover>,
    /// Things that robots push: boxes, balls.
    pub(super) movables: Vec<RawMovable>,
    /// Light that is everywhere and casts no shadows. Range: not negative.
    ambient_lux: f64,
    /// Brightness of the floor where no zone says otherwise; 1 is white. Range: 0 to 1.
    floor: f64,
    /// The sky is hidden everywhere: satellite receivers have no fix.
    indoors: bool,
    /// Latitude of the arena's origin. x is east, y is north. Range: −89 to 89.
    latitude_deg: f64,
    /// Longitude of the arena's origin. Range: −179 to 179.
    longitude_deg: f64,
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
            ambient_lux: 0.0,
            floor: 1.0,
            indoors: false,
            latitude_deg: 0.0,
            longitude_deg: 0.0,
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
    /// Corners in order. The last one is joined to the first, and may repeat it. Type: list of `[x, y]`. Range: 2 to 4096 points,
    /// at least 3 if solid; each −10^6 to 10^6.
    points_m: Vec<[f64; 2]>,
    /// Filled: nothing can stand in it, and its outline must not cross itself. `false`: an outline only, such
    /// as the border of a room.
    #[serde(default = "yes")]
    solid: bool,
    /// `false`: the last point is not joined to the first; a wall with a gap. Range: a solid one is closed.
    #[serde(default = "yes")]
    closed: bool,
    /// Sensors that are mounted higher see over it. Bodies hit it at any height. Default: unlimited. Range:
    /// 10^−6 to 10^6.
    height_m: Option<f64>,
    /// Its colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
    color: Option<[u8; 3]>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawCircle {
    /// Unique among all obstacles. Range: see [names](#names).
    name: String,
    /// Centre. Range: −10^6 to 10^6.
    x_m: f64,
    /// Centre. Range: −10^6 to 10^6.
    y_m: f64,
    /// Radius. A circle is solid. Range: 10^−6 to 10^6.
    radius_m: f64,
    /// Sensors that are mounted higher see over it. Default: unlimited. Range: 10^−6 to 10^6.
    height_m: Option<f64>,
    /// Its colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
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
    points_m: Option<Vec<[f64; 2]>>,
    /// Centre of a disc. Default: required with `radius_m`. Range: −10^6 to 10^6.
    x_m: Option<f64>,
    /// Centre of a disc. Default: required with `radius_m`. Range: −10^6 to 10^6.
    y_m: Option<f64>,
    /// Radius of a disc. Default: this or `points_m`. Range: 10^−6 to 10^6.
    radius_m: Option<f64>,
    /// Power with which batteries are charged here. Chargers add up. Range: not negative.
    #[serde(default)]
    charger_w: f64,
    /// Brightness of the floor here. Of several zones the last in the file counts. Default: the arena's. Range:
    /// 0 to 1.
    floor: Option<f64>,
    /// Share of its rolling that a wheel loses here: 1 spins on the spot. The largest counts, for each wheel
    /// separately. Encoders count the rolling; gyroscope, accelerometer and gps measure the body's motion.
    /// Range: 0 to 1.
    #[serde(default)]
    slip: f64,
    /// The sky is hidden here.
    #[serde(default)]
    indoors: bool,
    /// Deviation of compasses here. Offsets add up. Range: −10 to 10.
    #[serde(default)]
    compass_offset_rad: f64,
    /// A place to reach, for `end.all_goals`.
    #[serde(default)]
    goal: bool,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawLight {
    /// Unique among the lights. Range: see [names](#names).
    name: String,
    /// Position. Range: −10^6 to 10^6.
    x_m: f64,
    /// Position. Range: −10^6 to 10^6.
    y_m: f64,
    /// Height above the floor. Range: 0 to 1000.
    #[serde(default)]
    height_m: f64,
    /// Luminous intensity, the same in all directions, in candela. Range: positive.
    intensity_cd: f64,
    /// It blinks with this period. Range: 0.01 to 10^8.
    blink_ms: Option<f64>,
    /// How long it is lit in each period, from its start. Default: half the period. Range: 0 to `blink_ms`;
    /// only with it.
    lit_ms: Option<f64>,
    /// Whether obstacles cast shadows.
    #[serde(default = "yes")]
    shadows: bool,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawField {
    /// Unique among the fields. Range: see [names](#names).
    name: String,
    /// Value at the origin without bells, in the field's own unit. Range: −10^9 to 10^9.
    #[serde(default)]
    background: f64,
    /// Change per metre along x and along y. Type: `[x, y]`. Range: each −10^9 to 10^9.
    #[serde(default)]
    slope_per_m: [f64; 2],
    /// Bells.
    #[serde(default)]
    sources: Vec<RawSource>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawSource {
    /// Its centre. Range: −10^6 to 10^6.
    x_m: f64,
    /// Its centre. Range: −10^6 to 10^6.
    y_m: f64,
    /// Its height; a negative one makes a dip. Range: −10^9 to 10^9.
    strength: f64,
    /// Its standard deviation. Range: 10^−6 to 10^6.
    width_m: f64,
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
        let look = look(&path, circle.height_m, circle.color)?;
        pillars.push(Pillar { name, circle: disc(&path, circle.x_m, circle.y_m, circle.radius_m)?, look });
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
    let look = look(path, raw.height_m, raw.color)?;
    Ok(Polygon { name, points, solid: raw.solid, closed: raw.closed, look })
}

/// What else there is.
pub(super) fn surroundings(path: &Path, raw: &RawArena) -> Result<Surroundings> {
    let mut names = Names::default();
    let zones = each(path, "zones", &raw.zones, |path, raw| zone(path, raw, &mut names))?;
    let mut names = Names::default();
    let lights = each(path, "lights", &raw.lights, |path, raw| light(path, raw, &mut names))?;
    let mut names = Names::default();
    let fields = each(path, "fields", &raw.fields, |path, raw| field(path, raw, &mut names))?;
    Ok(Surroundings {
        zones,
        lights,
        fields,
        ambient_lux: path.not_negative("ambient_lux", raw.ambient_lux)?,
        floor: path.within("floor", raw.floor, 0.0, 1.0)?,
        indoors: raw.indoors,
        origin_deg: (
            path.within("latitude_deg", raw.latitude_deg, -89.0, 89.0)?,
            path.within("longitude_deg", raw.longitude_deg, -179.0, 179.0)?,
        ),
    })
}

/// Makes something of each element of a list.
pub(super) fn each<R, T>(
    path: &Path,
    field: &str,
    list: &[R],
    mut make: impl FnMut(&Path, &R) -> Result<T>,
) -> Result<Vec<T>> {
    list.iter().enumerate().map(|(i, raw)| make(&path.field(field).index(i), raw)).collect()
}

fn zone(path: &Path, raw: &RawZone, names: &mut Names) -> Result<Zone> {
    let region = match (&raw.points_m, raw.x_m, raw.y_m, raw.radius_m) {
        (Some(points), None, None, None) => Region::Polygon(outline(&path.field("points_m"), points)?),
        (None, Some(x), Some(y), Some(radius)) => Region::Disc(disc(path, x, y, radius)?),
        _ => return Err(path.error("needs either `points_m`, or `x_m`, `y_m` and `radius_m`")),
    };
    Ok(Zone {
        name: names.take(&path.field("name"), &raw.name)?,
        region,
        charger_w: path.not_negative("charger_w", raw.charger_w)?,
        floor: raw.floor.map(|floor| path.within("floor", floor, 0.0, 1.0)).transpose()?,
        slip: path.within("slip", raw.slip, 0.0, 1.0)?,
        indoors: raw.indoors,
        compass_offset_rad: path.within("compass_offset_rad", raw.compass_offset_rad, -10.0, 10.0)?,
        goal: raw.goal,
    })
}

fn light(path: &Path, raw: &RawLight, names: &mut Names) -> Result<Light> {
    let blink_ns = match (raw.blink_ms, raw.lit_ms) {
        (None, None) => None,
        (Some(period), lit) => {
            let period_ns = path.ms("blink_ms", period, 0.01, 1e8)?;
            Some((period_ns, path.ms("lit_ms", lit.unwrap_or(0.5 * period), 0.0, period)?))
        }
        (None, Some(_)) => return Err(path.field("lit_ms").error("needs `blink_ms`, the period")),
    };
    Ok(Light {
        name: names.take(&path.field("name"), &raw.name)?,
        position: point(path, raw.x_m, raw.y_m)?,
        height_m: path.within("height_m", raw.height_m, 0.0, 1e3)?,
        intensity_cd: path.positive("intensity_cd", raw.intensity_cd)?,
        blink_ns,
        shadows: raw.shadows,
    })
}

/// A number of a field: so large that sums of them are numbers, too.
fn amount(path: &Path, name: &str, value: f64) -> Result<f64> {
    path.finite(name, value)?;
    path.within(name, value, -1e9, 1e9)
}

fn field(path: &Path, raw: &RawField, names: &mut Names) -> Result<Field> {
    let [x, y] = raw.slope_per_m;
    let slope = path.field("slope_per_m");
    let sources = each(path, "sources", &raw.sources, |path, raw| {
        Ok(Source {
            position: point(path, raw.x_m, raw.y_m)?,
            strength: amount(path, "strength", raw.strength)?,
            width_m: path.length("width_m", raw.width_m)?,
        })
    })?;
    Ok(Field {
        name: names.take(&path.field("name"), &raw.name)?,
        background: amount(path, "background", raw.background)?,
        slope_per_m: (amount(&slope, "x", x)?, amount(&slope, "y", y)?),
        sources,
    })
}
