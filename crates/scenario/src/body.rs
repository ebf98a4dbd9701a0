//! The shape of a body: its outline on the floor, and the parts of it that sensors of others see.

use alloc::format;
use alloc::vec::Vec;

use baudbot_fields::number::{Coordinate, Number};
use baudbot_fields::{FieldError, Path};
use baudbot_geometry::{Point, polygon};
use baudbot_sim::model::Part;
use baudbot_sim::surroundings::Region;

use super::{raw, shapes};

type Result<T> = core::result::Result<T, FieldError>;

/// The shape of a body.
pub(super) struct Body {
    /// Corners; none of a disc.
    pub(super) outline: Vec<Point>,
    /// The radius of the disc that it is, or fits in.
    pub(super) radius_m: f64,
    pub(super) parts: Vec<Part>,
}

impl Body {
    pub(super) fn new(path: &Path, raw: &raw::Body) -> Result<Self> {
        let (outline, radius_m) = outline(path, raw)?;
        Ok(Self { outline, radius_m, parts: parts(path, raw, radius_m)? })
    }
}

/// Corners of the body and the radius of the disc that it is, or fits in.
fn outline(path: &Path, raw: &raw::Body) -> Result<(Vec<Point>, f64)> {
    match (raw.radius_m, &raw.outline_m) {
        (Some(radius), None) => Ok((Vec::new(), radius.get())),
        (None, Some(corners)) => {
            let at = path.field("outline_m");
            let corners = shapes::outline(&at, corners)?;
            if !polygon::contains(&corners, Point::origin()) {
                return Err(at.error("the robot's centre, between its wheels at (0, 0), must lie inside"));
            }
            let radius_m = polygon::bounding_radius(&corners);
            Ok((corners, radius_m))
        }
        (None, None) => {
            Err(path.field("radius_m").error("is missing; a body is a disc or has an `outline_m`"))
        }
        (Some(_), Some(_)) => Err(path.field("radius_m").error("a body with an `outline_m` has no radius")),
    }
}

/// The parts of a body, which reach no farther out than sensors.
fn parts(path: &Path, raw: &raw::Body, radius_m: f64) -> Result<Vec<Part>> {
    if raw.parts.len() > MAX_PARTS {
        let problem = format!("there are {}, the limit is {MAX_PARTS}", raw.parts.len());
        return Err(path.field("parts").error(problem));
    }
    let parts = shapes::each(path, "parts", &raw.parts, |path, part| {
        let at = |number: Option<Number<Coordinate>>| number.unwrap_or_default();
        let outline = match (&part.outline_m, part.radius_m, part.x_m.or(part.y_m)) {
            (Some(corners), None, None) => {
                Region::Polygon(shapes::outline(&path.field("outline_m"), corners)?)
            }
            (None, Some(radius), _) => Region::Disc(shapes::disc(at(part.x_m), at(part.y_m), radius)),
            _ => return Err(path.error("needs either `outline_m`, or `radius_m` with `x_m` and `y_m`")),
        };
        let (reach_m, most_m) = (outline.reach_m(), 2.0 * radius_m);
        if reach_m > most_m {
            let problem = format!(
                "reaches {reach_m} m from the robot's centre, and may reach {most_m} m, twice the body's radius"
            );
            return Err(path.error(problem));
        }
        let look = shapes::look(part.height_m, part.color.or(raw.color));
        Ok(Part { outline, look: shapes::raised(look, path, part.lower_edge_m)? })
    })?;
    // Each tick has the corners of each robot's parts in the world.
    let corners: usize = raw.parts.iter().filter_map(|part| Some(part.outline_m.as_ref()?.len())).sum();
    if corners > MAX_CORNERS {
        let problem = format!("have {corners} corners together, the limit is {MAX_CORNERS}");
        return Err(path.field("parts").error(problem));
    }
    Ok(parts)
}

/// Most parts of one body.
const MAX_PARTS: usize = 64;

/// Most corners of all of them, as many as a body may have.
const MAX_CORNERS: usize = 4096;
