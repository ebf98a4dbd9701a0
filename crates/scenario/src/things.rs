//! Things that move by themselves and things that are pushed: what a file may say of them.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Point, Pose, Vector, polygon};

use super::names::Names;
#[cfg(feature = "schema")]
use super::shapes::Corners;
use super::shapes::{look, outline, points};
use baudbot_fields::number::{
    Between, Coordinate, Length, NotNegative, Number, Positive, Seconds, Share, UpTo,
};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::movable::{Form, Movable, MovableShape};
use baudbot_sim::mover::{AfterLast, Mover, Path as Way};

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawMover {
    /// Unique among all obstacles. `NAME/path` is its random stream. Range: see [names](#names).
    name: String,
    /// Radius of a disc. Default: this or `outline_m`.
    radius_m: Option<Number<Length>>,
    /// Corners in its own frame; the outline must not cross itself. Type: list of `[x, y]`. Default: this or
    /// `radius_m`. Range: 3 to 4096 points; each −10^6 to 10^6; not with `wander`.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Corners>", length(min = 3, max = 4096)))]
    outline_m: Option<Vec<[f64; 2]>>,
    /// Height. Sensors that are mounted higher see over it. Default: unlimited.
    height_m: Option<Number<Length>>,
    /// Colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
    color: Option<[u8; 3]>,
    /// Start position; with `stops` the first of these.
    #[serde(default)]
    x_m: Number<Coordinate>,
    /// Start position; with `stops` the first of these.
    #[serde(default)]
    y_m: Number<Coordinate>,
    /// Heading at the start.
    #[serde(default)]
    heading_rad: Number<Heading>,
    /// Motion from point to point, without turning. Default: this, `swing` or `wander`.
    stops: Option<RawStops>,
    /// Rotation about the origin of its own frame and back, like a door on its hinge. Default: this, `stops` or
    /// `wander`.
    swing: Option<RawSwing>,
    /// Straight motion, in a direction that changes at random from time to time. Default: this, `stops` or `swing`.
    wander: Option<RawWander>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawStops {
    /// Points of the path, which starts at the first. Type: list of `[x, y]`. Range: 2 to 4096 points; each −10^6 to
    /// 10^6.
    #[cfg_attr(feature = "schema", schemars(with = "Corners", length(min = 2, max = 4096)))]
    points_m: Vec<[f64; 2]>,
    /// Speed of the motion.
    speed_m_s: Number<UpTo<1000>>,
    /// Pause at each point.
    #[serde(default)]
    pause_s: Number<Seconds<Between<0, 1_000_000>>>,
    /// Motion after the last point: back along the path, straight to the first point, or none.
    #[serde(default)]
    then: AfterLast,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawSwing {
    /// Heading at the other end of the swing, which starts at `heading_rad`.
    to_rad: Number<Heading>,
    /// Turn rate.
    rate_rad_s: Number<UpTo<1000>>,
    /// Pause at each end.
    #[serde(default)]
    pause_s: Number<Seconds<Between<0, 1_000_000>>>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RawWander {
    /// Speed of the motion.
    speed_m_s: Number<UpTo<1000>>,
    /// Maximum time in one direction. The direction changes after half of this to all of it, or when something is in
    /// the way.
    turn_s: Number<Seconds<Between<0, 1_000_000>>>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawMovable {
    /// Unique among all obstacles. Range: see [names](#names).
    name: String,
    /// Radius of a ball. Default: this, `size_m` or `outline_m`.
    radius_m: Option<Number<Length>>,
    /// Sides of a box along its own x and y. Type: `[length, width]`. Default: this, `radius_m` or `outline_m`.
    /// Range: each 10^−6 to 10^6.
    size_m: Option<[Number<Length>; 2]>,
    /// Corners in its own frame. Type: list of `[x, y]`. Default: this, `radius_m` or `size_m`. Range: 3 to
    /// 4096 points, convex; each −10^6 to 10^6.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Corners>", length(min = 3, max = 4096)))]
    outline_m: Option<Vec<[f64; 2]>>,
    /// Start position of its frame's origin.
    x_m: Number<Coordinate>,
    /// Start position of its frame's origin.
    y_m: Number<Coordinate>,
    /// Heading at the start.
    #[serde(default)]
    heading_rad: Number<Heading>,
    /// Mass, uniform over its area.
    mass_kg: Number<Positive>,
    /// Coulomb friction coefficient with the floor; for a ball the rolling resistance.
    friction: Number<NotNegative>,
    /// Coefficient of restitution: separation speed divided by approach speed.
    #[serde(default)]
    restitution: Number<Share>,
    /// Height. Sensors that are mounted higher see over it. Default: unlimited.
    height_m: Option<Number<Length>>,
    /// Colour for cameras. Type: `[red, green, blue]`. Default: `[128, 128, 128]`. Range: each 0 to 255.
    color: Option<[u8; 3]>,
}

/// A direction at the start, in radians: a few turns either way.
type Heading = Between<-10, 10>;

type Result<T> = core::result::Result<T, FieldError>;

/// Something that moves by itself.
pub(super) fn mover(path: &Path, raw: &RawMover, names: &mut Names) -> Result<Mover> {
    let (radius_m, outline) = match (raw.radius_m, &raw.outline_m) {
        (Some(radius), None) => (radius.get(), Vec::new()),
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
    let mut start = Pose::new(raw.x_m.get(), raw.y_m.get(), raw.heading_rad.get());
    let way = match (&raw.stops, &raw.swing, &raw.wander) {
        (Some(raw), None, None) => {
            let (way, first) = stops(&path.field("stops"), raw)?;
            start.position = first;
            way
        }
        (None, Some(raw), None) => swing(raw, start.heading),
        (None, None, Some(raw)) => {
            path.refuse("outline_m", !outline.is_empty(), "only a disc can wander")?;
            wander(raw)
        }
        _ => return Err(path.error("needs exactly one of `stops`, `swing` and `wander`")),
    };
    Ok(Mover {
        name: names.take(&path.field("name"), &raw.name)?,
        radius_m,
        outline,
        look: look(raw.height_m, raw.color),
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
    let way =
        Way::Stops { points, speed_m_s: raw.speed_m_s.get(), pause_ns: raw.pause_s.get(), after: raw.then };
    Ok((way, first))
}

/// A door's ends are not wrapped, so that it can swing through the back.
fn swing(raw: &RawSwing, from_rad: f64) -> Way {
    Way::Swing {
        ends_rad: [from_rad, raw.to_rad.get()],
        rate_rad_s: raw.rate_rad_s.get(),
        pause_ns: raw.pause_s.get(),
    }
}

fn wander(raw: &RawWander) -> Way {
    Way::Wander { speed_m_s: raw.speed_m_s.get(), turn_ns: raw.turn_s.get().max(1) }
}

/// Something that is pushed.
pub(super) fn movable(path: &Path, raw: &RawMovable, names: &mut Names) -> Result<Movable> {
    let mut start = Pose::new(raw.x_m.get(), raw.y_m.get(), raw.heading_rad.get());
    let shape = match (raw.radius_m, raw.size_m, &raw.outline_m) {
        (Some(radius), None, None) => MovableShape::Ball { radius_m: radius.get() },
        (None, Some(sides), None) => {
            let [x, y] = sides.map(|side| 0.5 * side.get());
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
        mass_kg: raw.mass_kg.get(),
        friction: raw.friction.get(),
        restitution: raw.restitution.get(),
        look: look(raw.height_m, raw.color),
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
