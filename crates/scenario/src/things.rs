//! Things that move by themselves and things that are pushed: what a file may say of them.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Point, Pose, Vector, polygon};

use super::names::Names;
use super::shapes::{look, outline, points};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::movable::{Form, Movable, MovableShape};
use baudbot_sim::mover::{AfterLast, Mover, Path as Way};

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawMover {
    /// Unique among all obstacles. `NAME/path` is its random stream. Range: see [names](#names).
    name: String,
    /// Radius of a disc. Default: this or `outline_m`. Range: 10^−6 to 10^6.
    radius_m: Option<f64>,
    /// Corners in its own frame; the outline must not cross itself. Type: list of `[x, y]`. Default: this or
    /// `radius_m`. Range: 3 to 4096 points; each −10^6 to 10^6; not with `wander`.
    outline_m: Option<Vec<[f64; 2]>>,
    /// Sensors that are mounted higher see over it. Default: unlimited. Range: 10^−6 to 10^6.
    height_m: Option<f64>,
    /// Its colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
    color: Option<[u8; 3]>,
    /// Start position; with `stops` the first of these. Range: −10^6 to 10^6.
    #[serde(default)]
    x_m: f64,
    /// Start position; with `stops` the first of these. Range: −10^6 to 10^6.
    #[serde(default)]
    y_m: f64,
    /// Heading at the start. Range: −10 to 10.
    #[serde(default)]
    heading_rad: f64,
    /// It goes from point to point, without turning. Default: this, `swing` or `wander`.
    stops: Option<RawStops>,
    /// It turns about the origin of its own frame and back, like a door on its hinge. Default: this, `stops` or
    /// `wander`.
    swing: Option<RawSwing>,
    /// It goes straight, in a direction that changes at random from time to time. Default: this, `stops` or
    /// `swing`.
    wander: Option<RawWander>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawStops {
    /// Its points; it starts at the first. Type: list of `[x, y]`. Range: 2 to 4096 points; each −10^6 to 10^6.
    points_m: Vec<[f64; 2]>,
    /// Speed. Range: above 0, at most 1000.
    speed_m_s: f64,
    /// How long it stays at each. Range: 0 to 10^6.
    #[serde(default)]
    pause_s: f64,
    /// After the last point: all the way back, straight to the first, or nothing more.
    #[serde(default)]
    then: RawThen,
}

#[derive(Clone, Copy, Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
enum RawThen {
    #[default]
    Return,
    Cycle,
    Stay,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawSwing {
    /// The other end of the swing; it starts at `heading_rad`. Range: −10 to 10.
    to_rad: f64,
    /// Turn rate. Range: above 0, at most 1000.
    rate_rad_s: f64,
    /// How long it stays at each end. Range: 0 to 10^6.
    #[serde(default)]
    pause_s: f64,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawWander {
    /// Speed. Range: above 0, at most 1000.
    speed_m_s: f64,
    /// It keeps a direction for a time between half of this and all of it, or until something is in the way.
    /// Range: 0 to 10^6.
    turn_s: f64,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawMovable {
    /// Unique among all obstacles. Range: see [names](#names).
    name: String,
    /// Radius of a ball. Default: this, `size_m` or `outline_m`. Range: 10^−6 to 10^6.
    radius_m: Option<f64>,
    /// Sides of a box along its own x and y. Type: `[length, width]`. Default: this, `radius_m` or `outline_m`.
    /// Range: each 10^−6 to 10^6.
    size_m: Option<[f64; 2]>,
    /// Corners in its own frame. Type: list of `[x, y]`. Default: this, `radius_m` or `size_m`. Range: 3 to
    /// 4096 points, convex; each −10^6 to 10^6.
    outline_m: Option<Vec<[f64; 2]>>,
    /// Start position of its frame's origin. Range: −10^6 to 10^6.
    x_m: f64,
    /// Start position of its frame's origin. Range: −10^6 to 10^6.
    y_m: f64,
    /// Heading at the start. Range: −10 to 10.
    #[serde(default)]
    heading_rad: f64,
    /// Mass, uniform over its area. Range: positive.
    mass_kg: f64,
    /// Coulomb friction coefficient with the floor; for a ball the rolling resistance. Range: not negative.
    friction: f64,
    /// Coefficient of restitution: speed of parting / speed of meeting. Range: 0 to 1.
    #[serde(default)]
    restitution: f64,
    /// Sensors that are mounted higher see over it. Default: unlimited. Range: 10^−6 to 10^6.
    height_m: Option<f64>,
    /// Its colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
    color: Option<[u8; 3]>,
}

type Result<T> = core::result::Result<T, FieldError>;

/// Something that moves by itself.
pub(super) fn mover(path: &Path, raw: &RawMover, names: &mut Names) -> Result<Mover> {
    let (radius_m, outline) = match (raw.radius_m, &raw.outline_m) {
        (Some(radius), None) => (path.length("radius_m", radius)?, Vec::new()),
        (None, Some(corners)) => {
            let outline = outline(&path.field("outline_m"), corners)?;
            (polygon::bounding_radius(&outline), outline)
        }
        _ => {
            return Err(
                path.error("needs either `radius_m` (a disc) or `outline_m` (corners in its own frame)")
            );
        }
    };
    let mut start = pose(path, raw.x_m, raw.y_m, raw.heading_rad)?;
    let way = match (&raw.stops, &raw.swing, &raw.wander) {
        (Some(raw), None, None) => {
            let (way, first) = stops(&path.field("stops"), raw)?;
            start.position = first;
            way
        }
        (None, Some(swing), None) => self::swing(&path.field("swing"), swing, start.heading)?,
        (None, None, Some(raw)) => {
            path.refuse("outline_m", !outline.is_empty(), "only a disc can wander")?;
            wander(&path.field("wander"), raw)?
        }
        _ => return Err(path.error("needs exactly one of `stops`, `swing` and `wander`")),
    };
    Ok(Mover {
        name: names.take(&path.field("name"), &raw.name)?,
        radius_m,
        outline,
        look: look(path, raw.height_m, raw.color)?,
        start,
        path: way,
    })
}

fn stops(path: &Path, raw: &RawStops) -> Result<(Way, Point)> {
    let at = path.field("points_m");
    let points = points(&at, &raw.points_m)?;
    let first = match points.first() {
        Some(&first) if points.len() >= 2 => first,
        _ => return Err(at.error(format!("needs at least 2 points, has {}", points.len()))),
    };
    let way = Way::Stops {
        points,
        speed_m_s: speed(path, "speed_m_s", raw.speed_m_s)?,
        pause_ns: path.s("pause_s", raw.pause_s, 0.0, MOST_S)?,
        after: match raw.then {
            RawThen::Stay => AfterLast::Stay,
            RawThen::Cycle => AfterLast::Cycle,
            RawThen::Return => AfterLast::Return,
        },
    };
    Ok((way, first))
}

/// A door's ends are not wrapped, so that it can swing through the back.
fn swing(path: &Path, raw: &RawSwing, from_rad: f64) -> Result<Way> {
    Ok(Way::Swing {
        ends_rad: [from_rad, path.within("to_rad", raw.to_rad, -10.0, 10.0)?],
        rate_rad_s: speed(path, "rate_rad_s", raw.rate_rad_s)?,
        pause_ns: path.s("pause_s", raw.pause_s, 0.0, MOST_S)?,
    })
}

/// Something that is pushed.
fn wander(path: &Path, raw: &RawWander) -> Result<Way> {
    Ok(Way::Wander {
        speed_m_s: speed(path, "speed_m_s", raw.speed_m_s)?,
        turn_ns: path.s("turn_s", raw.turn_s, 0.0, MOST_S)?.max(1),
    })
}

pub(super) fn movable(path: &Path, raw: &RawMovable, names: &mut Names) -> Result<Movable> {
    let mut start = pose(path, raw.x_m, raw.y_m, raw.heading_rad)?;
    let shape = match (raw.radius_m, raw.size_m, &raw.outline_m) {
        (Some(radius), None, None) => MovableShape::Ball { radius_m: path.length("radius_m", radius)? },
        (None, Some([length, width]), None) => {
            let at = path.field("size_m");
            let (x, y) = (0.5 * at.length("length", length)?, 0.5 * at.length("width", width)?);
            MovableShape::Box {
                outline: [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| Point::new(x, y)).into(),
            }
        }
        (None, None, Some(corners)) => convex(&path.field("outline_m"), corners, &mut start)?,
        _ => return Err(path.error("needs one of `radius_m` (a ball), `size_m` (a box) and `outline_m`")),
    };
    Ok(Movable {
        name: names.take(&path.field("name"), &raw.name)?,
        shape,
        mass_kg: path.positive("mass_kg", raw.mass_kg)?,
        friction: path.not_negative("friction", raw.friction)?,
        restitution: path.within("restitution", raw.restitution, 0.0, 1.0)?,
        look: look(path, raw.height_m, raw.color)?,
        start,
    })
}

/// Corners about their centroid, counter-clockwise; the start moves along with them.
fn convex(path: &Path, raw: &[[f64; 2]], start: &mut Pose) -> Result<MovableShape> {
    let mut corners = outline(path, raw)?;
    if is_clockwise(&corners) {
        corners.reverse();
    }
    if !polygon::is_convex(&corners) {
        return Err(path.error("a thing that is pushed must be convex"));
    }
    let centroid = polygon::centroid(&corners).ok_or_else(|| path.error("the outline has no area"))?;
    start.position = start.transform(centroid);
    let moved: Vec<_> = corners.iter().map(|corner| Point::from(corner - centroid)).collect();
    Ok(MovableShape::Box { outline: moved })
}

/// Whether the corners go around the outline clockwise: its area by Gauss's formula is then negative.
fn is_clockwise(corners: &[Point]) -> bool {
    let cross = |a: Vector, b: Vector| a.x * b.y - a.y * b.x;
    polygon::edges(corners).map(|edge| cross(edge.start.coords, edge.end.coords)).sum::<f64>() < 0.0
}

fn pose(path: &Path, x_m: f64, y_m: f64, heading_rad: f64) -> Result<Pose> {
    let (x, y) = (path.coordinate("x_m", x_m)?, path.coordinate("y_m", y_m)?);
    Ok(Pose::new(x, y, path.within("heading_rad", heading_rad, -10.0, 10.0)?))
}

/// Metres or radians a second, no more than a robot may start with.
fn speed(path: &Path, field: &str, value: f64) -> Result<f64> {
    path.positive(field, value)?;
    path.within(field, value, 0.0, 1e3)
}

/// Longest time that a thing stands or drives straight on, in seconds.
const MOST_S: f64 = 1e6;

/// Whether `form` at `pose` is free to stand there; names what is in the way.
pub(super) fn stands_in(
    (form, pose): (&Form<'_>, &Pose),
    arena: &baudbot_sim::arena::Arena,
    others: &[(String, baudbot_sim::movable::Body)],
) -> Option<String> {
    let body = form.at(pose);
    let shape = body.arena_thing(arena).map(|thing| arena.name_of(thing).into());
    shape.or_else(|| others.iter().find(|(_, other)| other.overlaps(&body)).map(|(name, _)| name.clone()))
}
