//! The footprint of a thing on the floor, and the height at which it is drawn.

use baudbot_proto::v1;
use baudbot_sim::Pose;
use foxglove::messages::{Color, Point3, SceneEntity};

use super::parts::point;
use super::shape::{Corners, circle, column, corners, plate, prism};

/// A flat shape in a frame that goes without saying.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Footprint {
    Corners(Corners),
    Disc { center: [f64; 2], radius_m: f64 },
}

impl Footprint {
    /// None if there is nothing that could be drawn.
    pub(super) fn new(points: &[v1::Point], center: Option<&v1::Point>, radius_m: f64) -> Option<Self> {
        if !points.is_empty() {
            return Some(Self::Corners(corners(points))).filter(|shape| shape.rim().len() >= 3);
        }
        let center = center.map_or([0.0; 2], |center| [center.x_m, center.y_m]);
        let sound = center.iter().all(|value| value.is_finite()) && radius_m.is_finite() && radius_m > 0.0;
        sound.then_some(Self::Disc { center, radius_m })
    }

    pub(super) fn of_outline(outline: &v1::Outline) -> Option<Self> {
        Self::new(&outline.points, outline.center.as_ref(), outline.radius_m)
    }

    /// A robot's, in its own frame.
    pub(super) fn of_robot(robot: &v1::ObservedRobot) -> Option<Self> {
        Self::new(&robot.outline, None, robot.radius_m)
    }

    /// Corners along its rim.
    pub(super) fn rim(&self) -> Corners {
        match self {
            Self::Corners(corners) => corners.clone(),
            Self::Disc { center: [x, y], radius_m } => {
                circle(*radius_m).iter().map(|[dx, dy]| [x + dx, y + dy]).collect()
            }
        }
    }

    /// The rim, with the shape's frame somewhere else.
    pub(super) fn rim_at(&self, pose: &Pose, z_m: f64) -> Vec<Point3> {
        let (sin, cos) = pose.heading.sin_cos();
        let place = |[x, y]: [f64; 2]| {
            point(pose.position.x + cos * x - sin * y, pose.position.y + sin * x + cos * y, z_m)
        };
        self.rim().into_iter().map(place).collect()
    }

    /// The shape's middle, for a label.
    pub(super) fn middle(&self) -> [f64; 2] {
        match self {
            Self::Corners(corners) => {
                let count = corners.len().max(1) as f64;
                [0, 1].map(|axis| corners.iter().map(|corner| corner[axis] / count).sum())
            }
            Self::Disc { center, .. } => *center,
        }
    }

    /// A body over it, from one height to another.
    pub(super) fn build(&self, entity: &mut SceneEntity, span_m: [f64; 2], color: Color) {
        match self {
            Self::Corners(corners) => entity.triangles.push(prism(corners, span_m, color)),
            Self::Disc { center, radius_m } => {
                entity.cylinders.push(column(*center, *radius_m, span_m[0], span_m[1], color));
            }
        }
    }

    /// Paint on the floor.
    pub(super) fn paint(&self, entity: &mut SceneEntity, z_m: f64, color: Color) {
        entity.triangles.push(plate(&self.rim(), z_m, color));
    }
}

/// The heights at which things are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Heights {
    /// The height for things that are higher than any sensor.
    tall_m: f64,
}

impl Heights {
    /// The heights of a world. Things without a height stand out from those with one and from robots, but not so far
    /// that they hide all else.
    pub(super) fn new(described: &v1::DescribeWorldResponse) -> Self {
        let looks = described.polygons.iter().map(|polygon| &polygon.look);
        let looks = looks.chain(described.circles.iter().map(|disc| &disc.look));
        let looks = looks.chain(described.things.iter().map(|thing| &thing.look));
        let parts = described.robots.iter().flat_map(|robot| &robot.parts);
        let looks = looks.chain(parts.map(|part| &part.look));
        let low =
            looks.filter_map(|look| sound(look.as_ref()?.height_m?)).filter(|&height_m| height_m <= 2.0);
        let robots = described.robots.iter().filter_map(|robot| sound(robot.radius_m));
        let wanted = low.map(|height_m| 1.25 * height_m).chain(robots.map(|radius_m| 4.0 * radius_m));
        Self { tall_m: wanted.reduce(f64::max).unwrap_or(0.5).clamp(0.001, 2.5) }
    }

    /// The heights of a wall or a thing: of its lower edge, and of its top.
    pub(super) fn of(&self, look: Option<&v1::Look>) -> [f64; 2] {
        let top_m = look.and_then(|look| sound(look.height_m?));
        let top_m = top_m.map_or(self.tall_m, |height_m| height_m.min(self.tall_m));
        let bottom_m = look.and_then(|look| sound(look.lower_edge_m)).unwrap_or(0.0);
        [bottom_m.min(top_m), top_m]
    }

    /// The height of a robot's body.
    pub(super) fn of_robot(&self, robot: &v1::ObservedRobot) -> f64 {
        let own_m = robot.look.as_ref().and_then(|look| sound(look.height_m?));
        own_m.or_else(|| sound(robot.radius_m)).map_or(self.tall_m, |height_m| height_m.min(self.tall_m))
    }

    /// Above all that is drawn.
    pub(super) fn above(&self) -> f64 {
        1.02 * self.tall_m
    }
}

/// A length that something can have.
fn sound(length_m: f64) -> Option<f64> {
    (length_m.is_finite() && length_m > 0.0).then_some(length_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_footprint_is_drawn_or_is_none() {
        let at = |x_m, y_m| v1::Point { x_m, y_m };
        assert_eq!(Footprint::new(&[at(0.0, 0.0), at(1.0, 0.0)], None, 0.0), None);
        assert_eq!(Footprint::new(&[], None, f64::NAN), None);
        assert_eq!(Footprint::new(&[], None, 0.0), None);
        let disc = Footprint::new(&[], Some(&at(1.0, 2.0)), 0.5).unwrap();
        assert_eq!(disc.middle(), [1.0, 2.0]);
        assert_eq!(disc.rim()[0], [1.5, 2.0]);
    }

    #[test]
    fn walls_stand_out_from_robots_and_from_what_is_low() {
        let look = |height_m| Some(v1::Look { height_m, ..v1::Look::default() });
        let robot = v1::ObservedRobot { radius_m: 0.1, look: look(None), ..v1::ObservedRobot::default() };
        let stool = v1::Disc { look: look(Some(0.8)), ..v1::Disc::default() };
        let tower = v1::Disc { look: look(Some(100.0)), ..v1::Disc::default() };
        let described = v1::DescribeWorldResponse {
            circles: vec![stool, tower],
            robots: vec![robot.clone()],
            ..v1::DescribeWorldResponse::default()
        };
        let heights = Heights::new(&described);
        assert_eq!(heights.of(None), [0.0, 1.0]);
        assert_eq!(heights.of(described.circles[0].look.as_ref()), [0.0, 0.8]);
        assert_eq!(heights.of(described.circles[1].look.as_ref()), [0.0, 1.0]);
        let table = v1::Look { lower_edge_m: 0.7, ..look(Some(0.8)).unwrap() };
        assert_eq!(heights.of(Some(&table)), [0.7, 0.8]);
        assert_eq!(heights.of_robot(&robot), 0.1);
        assert_eq!(Heights::new(&v1::DescribeWorldResponse::default()).of(None), [0.0, 0.5]);
    }
}
