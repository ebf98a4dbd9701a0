//! Where a point of the world is in the picture.

use std::fmt::Write;

use baudbot_geometry::{Bounds, Circle, Direction, Point, Pose, math};

use super::xml::{Element, px};

/// A window on the world: y goes up there and down in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// What part of the world is shown.
    pub(super) world: Bounds,
    /// Pixels a metre.
    pub(super) scale: f64,
    /// Left edge, in pixels.
    pub(super) left: f64,
    /// Upper edge, in pixels.
    pub(super) top: f64,
}

/// A place in the picture, in pixels.
pub(crate) type Place = (f64, f64);

impl View {
    pub(super) fn width(&self) -> f64 {
        self.length(self.world.size().x)
    }

    pub(super) fn height(&self) -> f64 {
        self.length(self.world.size().y)
    }

    /// A length in pixels.
    pub(super) fn length(&self, metres: f64) -> f64 {
        metres * self.scale
    }

    /// A point in pixels.
    pub(super) fn at(&self, point: Point) -> Place {
        let x = self.left + (point.x - self.world.min.x) * self.scale;
        (x, self.top + (self.world.max.y - point.y) * self.scale)
    }

    /// Whether a part of a box is seen.
    pub(super) fn shows(&self, part: &Bounds) -> bool {
        let (min, max) = (self.world.min, self.world.max);
        part.min.x <= max.x && part.max.x >= min.x && part.min.y <= max.y && part.max.y >= min.y
    }

    /// A disc.
    pub(super) fn circle(&self, disc: &Circle) -> Element {
        let (x, y) = self.at(disc.center);
        let radius = self.length(disc.radius).max(0.5);
        Element::new("circle").number("cx", x).number("cy", y).number("r", radius)
    }

    /// A line through points, as the data of a path.
    pub(super) fn line(&self, points: impl IntoIterator<Item = Point>) -> String {
        path(points.into_iter().map(|point| self.at(point)))
    }

    /// A closed line through points, as the data of a path.
    pub(super) fn ring(&self, points: impl IntoIterator<Item = Point>) -> String {
        let mut data = self.line(points);
        data.push('Z');
        data
    }

    /// The whole window.
    pub(super) fn frame(&self) -> Element {
        rectangle((self.left, self.top), (self.width(), self.height()))
    }
}

/// A rectangle by its upper left corner and its size, in pixels.
pub(crate) fn rectangle((x, y): Place, (width, height): (f64, f64)) -> Element {
    let at = Element::new("rect").number("x", x).number("y", y);
    at.number("width", width).number("height", height)
}

/// A line through places, as the data of a path.
pub(crate) fn path(places: impl IntoIterator<Item = Place>) -> String {
    let mut data = String::new();
    for (i, (x, y)) in places.into_iter().enumerate() {
        let _ = write!(data, "{}{} {}", if i == 0 { 'M' } else { 'L' }, px(x), px(y));
    }
    data
}

/// An element that is a path.
pub(crate) fn drawn(data: &str) -> Element {
    Element::new("path").set("d", data)
}

/// Points on an arc about the pose's position, its angles counted from the heading.
pub(super) fn arc(pose: &Pose, radius_m: f64, from_rad: f64, to_rad: f64) -> impl Iterator<Item = Point> {
    // A chord of 5° is off a circle by a thousandth of its radius.
    let steps = ((to_rad - from_rad).abs() / 0.0873).ceil().clamp(1.0, 360.0);
    let (pose, turn) = (*pose, (to_rad - from_rad) / steps);
    (0..=steps as usize).map(move |i| {
        let direction = Direction::from_angle(pose.heading + from_rad + turn * i as f64);
        pose.position + direction.vector() * radius_m
    })
}

/// The head of an arrow that comes `from` somewhere and ends at `to`, as the data of a path.
pub(super) fn arrow_head(from: Place, to: Place, size: f64) -> String {
    let (x, y) = (to.0 - from.0, to.1 - from.1);
    let length = math::hypot(x, y);
    if length < 1e-6 {
        return String::new();
    }
    let (x, y) = (x / length * size, y / length * size);
    let side = |share: f64| (to.0 - x - share * y, to.1 - y + share * x);
    path([side(0.5), to, side(-0.5)]) + "Z"
}

/// Leaves out the points of a line without which it is nowhere off by more than `tolerance` pixels.
pub(crate) fn simplified(places: &[Place], tolerance: f64) -> Vec<Place> {
    let mut keep = vec![false; places.len()];
    let mut spans = vec![(0, places.len().saturating_sub(1))];
    for end in [keep.len().checked_sub(1), (!keep.is_empty()).then_some(0)].into_iter().flatten() {
        keep[end] = true;
    }
    while let Some((first, last)) = spans.pop() {
        let off = |i: usize| (i, distance(places[i], places[first], places[last]));
        let farthest = (first + 1..last).map(off).reduce(|a, b| if b.1 > a.1 { b } else { a });
        if let Some((i, off)) = farthest
            && off > tolerance
        {
            keep[i] = true;
            spans.extend([(first, i), (i, last)]);
        }
    }
    places.iter().zip(keep).filter(|(_, keep)| *keep).map(|(&place, _)| place).collect()
}

/// Of a place from a line's piece.
fn distance(p: Place, a: Place, b: Place) -> f64 {
    let (x, y) = (b.0 - a.0, b.1 - a.1);
    let squared = x * x + y * y;
    let along = if squared > 0.0 { ((p.0 - a.0) * x + (p.1 - a.1) * y) / squared } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    math::hypot(p.0 - a.0 - along * x, p.1 - a.1 - along * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn y_goes_up() {
        let world = Bounds { min: Point::new(-1.0, -2.0), max: Point::new(1.0, 2.0) };
        let view = View { world, scale: 10.0, left: 100.0, top: 50.0 };
        assert_eq!(view.at(Point::new(-1.0, 2.0)), (100.0, 50.0));
        assert_eq!(view.at(Point::new(1.0, -2.0)), (120.0, 90.0));
    }

    #[test]
    fn a_straight_line_needs_no_points_between() {
        let places: Vec<_> = (0..100).map(|i| (f64::from(i), f64::from(i.min(50)))).collect();
        assert_eq!(simplified(&places, 0.1), [(0.0, 0.0), (50.0, 50.0), (99.0, 50.0)]);
        assert_eq!(simplified(&[], 0.1), []);
        assert_eq!(simplified(&[(1.0, 1.0)], 0.1), [(1.0, 1.0)]);
    }
}
