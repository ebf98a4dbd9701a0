//! Shapes and looks of several tables of a file.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_fields::number::{Coordinate, Length, Number};
use baudbot_fields::{FieldError, Path};
use baudbot_geometry::polygon::{Defect, defect, without_repeats};
use baudbot_geometry::{Circle, Point, Segment};
use baudbot_sim::arena::Look;

/// Most corners of one polygon: whether it crosses itself is found by comparing all pairs of sides.
const MAX_POINTS: usize = 4096;

type Result<T> = core::result::Result<T, FieldError>;

/// Points for a JSON Schema.
#[cfg(feature = "schema")]
pub(super) type Corners = Vec<[Number<Coordinate>; 2]>;

/// A disc.
pub(super) fn disc(x_m: Number<Coordinate>, y_m: Number<Coordinate>, radius_m: Number<Length>) -> Circle {
    Circle { center: point(x_m, y_m), radius: radius_m.get() }
}

/// A point.
pub(super) fn point(x_m: Number<Coordinate>, y_m: Number<Coordinate>) -> Point {
    Point::new(x_m.get(), y_m.get())
}

/// Points in order.
pub(super) fn points(path: &Path, raw: &[[f64; 2]]) -> Result<Vec<Point>> {
    if raw.len() > MAX_POINTS {
        return Err(
            path.error(format!("a polygon has at most {MAX_POINTS} points; this one has {}", raw.len()))
        );
    }
    let corner = |(i, &[x, y]): (usize, &[f64; 2])| {
        let at = path.index(i);
        Ok(Point::new(at.number::<Coordinate>("x", x)?, at.number::<Coordinate>("y", y)?))
    };
    raw.iter().enumerate().map(corner).collect()
}

/// Corners of a chain, closed or not, each once: files of others repeat them, above all the first at the end of a ring.
pub(super) fn corners(path: &Path, raw: &[[f64; 2]], closed: bool) -> Result<Vec<Point>> {
    Ok(without_repeats(&points(path, raw)?, closed))
}

/// Corners of a region with an inside.
pub(super) fn outline(path: &Path, raw: &[[f64; 2]]) -> Result<Vec<Point>> {
    let corners = corners(path, raw, true)?;
    match defect(&corners) {
        None => Ok(corners),
        Some(defect) => Err(path.error(no_inside(defect))),
    }
}

fn no_inside(defect: Defect) -> String {
    let at = |point: Point| format!("({}, {})", point.x, point.y);
    let side = |side: Segment| format!("{} to {}", at(side.start), at(side.end));
    match defect {
        Defect::TooFew(corners) => {
            format!("an outline has at least 3 corners in different places; this one has {corners}")
        }
        Defect::Flat => "all corners are on one line, so there is no inside".into(),
        Defect::FoldsBack(corner) => {
            format!("at {} the outline turns back along its own side: leave this corner out", at(corner))
        }
        Defect::Touches(place) => format!(
            "the outline touches itself at {}, so its inside is not one region: make two polygons of it",
            at(place)
        ),
        Defect::Crosses([a, b]) => format!(
            "the outline crosses itself: its side from {} crosses that from {}, so its inside is not defined",
            side(a),
            side(b)
        ),
    }
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

/// Height and colour; what has no height reaches up to every sensor.
pub(super) fn look(height_m: Option<Number<Length>>, color: Option<[u8; 3]>) -> Look {
    let height_m = height_m.map_or(f64::INFINITY, Number::get);
    Look { height_m, color: color.unwrap_or(Look::WALL.color), ..Look::WALL }
}

/// The same of something that may begin above the floor.
pub(super) fn raised(look: Look, path: &Path, lower_edge_m: Option<Number<Length>>) -> Result<Look> {
    let lower_edge_m = lower_edge_m.map_or(0.0, Number::get);
    if lower_edge_m > look.height_m {
        let problem = format!("must be at most `height_m`, {}, is {lower_edge_m}", look.height_m);
        return Err(path.field("lower_edge_m").error(problem));
    }
    Ok(Look { lower_edge_m, ..look })
}
