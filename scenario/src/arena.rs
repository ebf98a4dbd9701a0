//! The arena: what a file may say of it, and what becomes of that.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::polygon::is_simple;

use super::names::Names;
use super::shapes::{disc, look, outline, point, points};
use super::things::{RawMovable, RawMover};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::arena::{Arena, Pillar, Polygon};
use baudbot_sim::surroundings::{Field, Light, Region, Source, Surroundings, Zone};

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RawArena {
    polygons: Vec<RawPolygon>,
    circles: Vec<RawCircle>,
    zones: Vec<RawZone>,
    lights: Vec<RawLight>,
    fields: Vec<RawField>,
    pub(super) movers: Vec<RawMover>,
    pub(super) movables: Vec<RawMovable>,
    ambient_lux: f64,
    floor: f64,
    indoors: bool,
    latitude_deg: f64,
    longitude_deg: f64,
    /// Maps are put in place of their names before a scenario is read; here they are only refused.
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
struct RawPolygon {
    name: String,
    points_m: Vec<[f64; 2]>,
    #[serde(default = "yes")]
    solid: bool,
    #[serde(default = "yes")]
    closed: bool,
    height_m: Option<f64>,
    color: Option<[u8; 3]>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCircle {
    name: String,
    x_m: f64,
    y_m: f64,
    radius_m: f64,
    height_m: Option<f64>,
    color: Option<[u8; 3]>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawZone {
    name: String,
    points_m: Option<Vec<[f64; 2]>>,
    x_m: Option<f64>,
    y_m: Option<f64>,
    radius_m: Option<f64>,
    #[serde(default)]
    charger_w: f64,
    floor: Option<f64>,
    #[serde(default)]
    slip: f64,
    #[serde(default)]
    indoors: bool,
    #[serde(default)]
    compass_offset_rad: f64,
    #[serde(default)]
    goal: bool,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLight {
    name: String,
    x_m: f64,
    y_m: f64,
    #[serde(default)]
    height_m: f64,
    intensity_cd: f64,
    blink_ms: Option<f64>,
    lit_ms: Option<f64>,
    #[serde(default = "yes")]
    shadows: bool,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawField {
    name: String,
    #[serde(default)]
    background: f64,
    #[serde(default)]
    slope_per_m: [f64; 2],
    #[serde(default)]
    sources: Vec<RawSource>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSource {
    x_m: f64,
    y_m: f64,
    strength: f64,
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
    let points = points(&at, &raw.points_m)?;
    if points.len() < 2 || (raw.solid && points.len() < 3) {
        return Err(at.error(format!(
            "a solid polygon has at least 3 points, a hollow one 2; here are {}",
            points.len()
        )));
    }
    if raw.solid && !raw.closed {
        return Err(path
            .field("closed")
            .error("a solid polygon is closed; an open line needs solid = false"));
    }
    if raw.solid && !is_simple(&points) {
        return Err(at.error("the outline crosses itself, so a solid polygon's inside is not defined"));
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
