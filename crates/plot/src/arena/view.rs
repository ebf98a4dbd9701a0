//! Windows: from points of the world to places in the picture.

use baudbot_geometry::{Bounds, Circle, Direction, Point, Pose};

use crate::svg::{Element, Place, path, rectangle};

/// A window on the world: y goes up there and down in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// The part of the world that is shown.
    pub(super) world: Bounds,
    /// Pixels per metre.
    pub(super) scale: f64,
    /// Left edge, in pixels.
    pub(super) left: f64,
    /// Upper edge, in pixels.
    pub(super) top: f64,
}

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

/// Points on an arc about the pose's position, its angles counted from the heading.
pub(super) fn arc(
    pose: &Pose,
    radius_m: f64,
    from_rad: f64,
    to_rad: f64,
) -> impl Iterator<Item = Point> + use<> {
    // A chord of 5° is off a circle by a thousandth of its radius.
    let steps = ((to_rad - from_rad).abs() / 0.0873).ceil().clamp(1.0, 360.0);
    let (pose, turn) = (*pose, (to_rad - from_rad) / steps);
    (0..=steps as usize).map(move |i| {
        let direction = Direction::from_angle(pose.heading + from_rad + turn * i as f64);
        pose.position + direction.vector() * radius_m
    })
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
}
