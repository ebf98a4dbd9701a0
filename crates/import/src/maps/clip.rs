//! Clip paths: what is inside is kept, what is outside is not there, and what they cut is refused.

use baudbot_geometry::{Point, polygon};
use usvg::{ClipPath, Group, Transform};

use super::outlines::{self, Outline, Placement};
use super::problem::ShapeError;
use super::shape::ON_EDGE_M;

/// The part of a shape that a clip path leaves.
pub(crate) enum Clipped {
    Whole,
    Away,
}

/// The part that is left of a shape with these outlines.
pub(crate) fn clipped(
    outlines: &[Outline],
    clips: &[(&ClipPath, Transform)],
    placement: &Placement,
) -> Result<Clipped, ShapeError> {
    for (clip, place) in clips {
        let mut windows = Vec::new();
        windows_of(clip, *place, placement, &mut windows)?;
        for window in windows {
            let corners = outlines.iter().flat_map(|outline| &outline.points);
            let (inside, all) = corners.fold((0, 0), |(inside, all), &[x, y]| {
                (inside + usize::from(is_within(&window, Point::new(x, y))), all + 1)
            });
            let is_cut = outlines.iter().any(|outline| window.iter().any(|edge| crosses(outline, edge)));
            if is_cut || (inside != 0 && inside != all) {
                return Err(ShapeError::Cut);
            }
            if inside == 0 {
                return Ok(Clipped::Away);
            }
        }
    }
    Ok(Clipped::Whole)
}

/// A clip path as what can be seen through it: outlines, of which one has to have a point in it.
type Window = Vec<Vec<Point>>;

/// The windows of a clip path, of which each cuts by itself.
fn windows_of(
    clip: &ClipPath,
    place: Transform,
    placement: &Placement,
    windows: &mut Vec<Window>,
) -> Result<(), ShapeError> {
    if let Some(outer) = clip.clip_path() {
        windows_of(outer, place, placement, windows)?;
    }
    let mut window = Window::new();
    gather(clip.root(), place.pre_concat(clip.transform()), placement, &mut window)?;
    windows.push(window);
    Ok(())
}

fn gather(
    group: &Group,
    place: Transform,
    placement: &Placement,
    window: &mut Window,
) -> Result<(), ShapeError> {
    for node in group.children() {
        match node {
            usvg::Node::Group(group) => gather(group, place, placement, window)?,
            usvg::Node::Path(path) => {
                let outlines = outlines::of_path_at(path, place.pre_concat(path.abs_transform()), placement);
                let outlines = outlines.map_err(|problem| ShapeError::ClipPath(problem.into()))?;
                window.extend(outlines.iter().map(Outline::chain).filter(|chain| chain.len() > 2));
            }
            usvg::Node::Image(_) | usvg::Node::Text(_) => {}
        }
    }
    Ok(())
}

/// On the edge, to a rounding error, is within.
fn is_within(window: &Window, point: Point) -> bool {
    window.iter().any(|outline| {
        polygon::contains(outline, point)
            || polygon::edges(outline).any(|edge| edge.distance(point) < ON_EDGE_M)
    })
}

/// Whether a shape crosses the edge of a window between its corners.
fn crosses(outline: &Outline, window: &[Point]) -> bool {
    let chain = outline.chain();
    let closing = usize::from(outline.closed);
    let sides = chain.iter().zip(chain.iter().cycle().skip(1)).take(chain.len() - 1 + closing);
    sides.into_iter().any(|(&a, &b)| {
        polygon::edges(window).any(|edge| {
            let side = |from: Point, to: Point, point: Point| (to - from).perp(&(point - from));
            let (p, q) = (side(edge.start, edge.end, a), side(edge.start, edge.end, b));
            let (r, s) = (side(a, b, edge.start), side(a, b, edge.end));
            let least = ON_EDGE_M * (edge.end - edge.start).norm();
            let least_along = ON_EDGE_M * (b - a).norm();
            let parted = |one: f64, other: f64, least: f64| {
                (one > least && other < -least) || (one < -least && other > least)
            };
            parted(p, q, least) && parted(r, s, least_along)
        })
    })
}
