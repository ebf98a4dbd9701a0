//! The clearance of a body: its distance from everything that it could run into.

use baudbot_geometry::{Circle, Point, Segment, Shape, math, polygon};

use crate::arena::Arena;
use crate::movable::Body;
use crate::world::World;

impl World {
    /// The clearance of the robot of this index, in metres: the distance of its body from the nearest shape, thing or other
    /// robot, and infinite if there is none. It is 0 for bodies that touch, and for a robot that ran into something in the last
    /// tick, as that left it where it was before. It is the truth: for observers, never for a brain.
    ///
    /// # Panics
    /// If there is no such robot.
    pub fn clearance_m(&self, robot: usize) -> f64 {
        let view = self.robot(robot);
        if view.collided() {
            return 0.0;
        }
        let body = view.spec().form().at(&view.motion().pose);
        let mut least = body.gap_to_arena(&self.scenario().arena);
        let others = self.robots().enumerate().filter(|(i, _)| *i != robot);
        for (_, other) in others {
            let (form, pose) = (other.spec().form(), &other.motion().pose);
            // A disc around a body is no nearer than the body.
            if body.gap_to_disc(&Circle { center: pose.position, radius: form.reach_m() }) < least {
                least = least.min(body.gap(&form.at(pose)));
            }
        }
        for thing in self.bodies_of_things() {
            least = least.min(body.gap(&thing));
        }
        least
    }

    fn bodies_of_things(&self) -> impl Iterator<Item = Body> {
        let (scenario, state) = (self.scenario(), self.state());
        let movers = scenario.movers.iter().zip(&state.movers);
        let movables = scenario.movables.iter().zip(&state.movables);
        let movers = movers.map(|(mover, state)| mover.form().at(&state.pose));
        movers.chain(movables.map(|(movable, state)| movable.shape.form().at(&state.pose)))
    }
}

impl Body {
    /// The distance, in metres, between the two; 0 if they overlap or touch.
    pub(crate) fn gap(&self, other: &Self) -> f64 {
        match (self, other) {
            (body, Self::Disc(disc)) | (Self::Disc(disc), body) => body.gap_to_disc(disc),
            (Self::Polygon(a), Self::Polygon(b)) => {
                let is_inside = |inner: &[Point], outer: &[Point]| {
                    inner.first().is_some_and(|&point| polygon::contains(outer, point))
                };
                if is_inside(a, b) || is_inside(b, a) {
                    return 0.0;
                }
                let gaps = polygon::edges(b).map(|edge| gap_to_segment(a, &edge));
                gaps.fold(f64::INFINITY, f64::min)
            }
        }
    }

    fn gap_to_disc(&self, disc: &Circle) -> f64 {
        match self {
            Self::Disc(own) => {
                let between = math::sqrt((own.center - disc.center).norm_squared());
                (between - own.radius - disc.radius).max(0.0)
            }
            Self::Polygon(points) if polygon::contains(points, disc.center) => 0.0,
            Self::Polygon(points) => {
                let edges = polygon::edges(points).map(|edge| edge.distance_squared(disc.center));
                (math::sqrt(edges.fold(f64::INFINITY, f64::min)) - disc.radius).max(0.0)
            }
        }
    }

    fn gap_to_arena(&self, arena: &Arena) -> f64 {
        let (index, middle) = (arena.index(), self.middle());
        let Some((_, from_middle)) = index.nearest_point(middle) else { return f64::INFINITY };
        match self {
            _ if arena.solid_at(middle).is_some() => 0.0,
            Self::Disc(disc) => (from_middle - disc.radius).max(0.0),
            Self::Polygon(points) => {
                // The nearest shape to the body is no farther from its middle than the nearest to that, and twice its reach.
                let reach = points.iter().map(|point| (point - middle).norm_squared()).fold(0.0, f64::max);
                let radius = from_middle + 2.0 * math::sqrt(reach);
                let mut least = f64::INFINITY;
                index.near(&Circle { center: middle, radius }, |shape| {
                    least = least.min(match shape {
                        Shape::Segment(i) => gap_to_segment(points, &index.segments()[i]),
                        Shape::Circle(i) => self.gap_to_disc(&index.circles()[i]),
                    });
                });
                least
            }
        }
    }

    /// A point in the middle: of a polygon, that of its corners.
    fn middle(&self) -> Point {
        match self {
            Self::Disc(disc) => disc.center,
            Self::Polygon(points) => {
                let sum = points.iter().fold(Point::origin(), |sum, point| sum + point.coords);
                sum / points.len().max(1) as f64
            }
        }
    }
}

fn gap_to_segment(points: &[Point], segment: &Segment) -> f64 {
    if polygon::contains(points, segment.start) {
        return 0.0;
    }
    polygon::edges(points).map(|edge| edge.gap(segment)).fold(f64::INFINITY, f64::min)
}
