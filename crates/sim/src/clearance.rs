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
        let (arena, body) = (&self.scenario().arena, self.body(robot));
        self.clearance_beside(robot, &body, || body.gap_to_arena(arena))
    }

    /// The same, where it is asked for again and again.
    pub(crate) fn clearance_beside_m(&self, robot: usize, nearest: &mut Option<Nearest>) -> f64 {
        let (arena, body) = (&self.scenario().arena, self.body(robot));
        self.clearance_beside(robot, &body, || match &body {
            Body::Disc(disc) => (Nearest::distance_m(nearest, arena, disc.center) - disc.radius).max(0.0),
            Body::Polygon(_) => body.gap_to_arena(arena),
        })
    }

    fn body(&self, robot: usize) -> Body {
        let view = self.robot(robot);
        view.spec().form().at(&view.motion().pose)
    }

    fn clearance_beside(&self, robot: usize, body: &Body, gap_to_arena: impl FnOnce() -> f64) -> f64 {
        if self.robot(robot).collided() {
            return 0.0;
        }
        let mut least = gap_to_arena();
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

/// The two shapes of an arena that are nearest to a place, such as the edges at a corner. They are nearest to places around that, too, to
/// which the distance is then had without a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    shapes: [Option<Shape>; 2],
    place: Point,
    /// The distance to the nearest, and what that of every other shape is not below, in metres.
    distances_m: [f64; 2],
}

impl Nearest {
    /// The distance from a place to the nearest shape, in metres, or 0 in a solid one, by what is known of the last place.
    fn distance_m(last: &mut Option<Self>, arena: &Arena, place: Point) -> f64 {
        let distance_m = |shape| match shape {
            Shape::Segment(i) => arena.index().segments()[i].distance(place),
            Shape::Circle(i) => arena.index().circles()[i].distance(place),
        };
        if let Some(Self { shapes, place: former, distances_m: [of_nearest_m, of_others_m] }) = last {
            // By more than what rounding makes of it. Who has gone less than up to the nearest shape is in none that it was not in.
            let way_m = math::sqrt((place - *former).norm_squared()) * (1.0 + SLACK) + SLACK;
            let nearest_m =
                shapes.iter().flatten().map(|&shape| distance_m(shape)).fold(f64::INFINITY, f64::min);
            if way_m < *of_nearest_m && nearest_m + way_m < *of_others_m {
                return nearest_m;
            }
        }
        let Some((_, from_m)) = arena.index().nearest_point(place) else { return f64::INFINITY };
        if arena.solid_at(place).is_some() {
            *last = None;
            return 0.0;
        }
        let around = Circle { center: place, radius: from_m + AROUND_M };
        let (mut shapes, mut nearest_m, mut of_others_m) = ([None; 2], [f64::INFINITY; 2], around.radius);
        arena.index().near(&around, |shape| {
            let mut next = (distance_m(shape), shape);
            for (shape, known_m) in shapes.iter_mut().zip(&mut nearest_m) {
                if *shape == Some(next.1) {
                    return;
                }
                if next.0 < *known_m {
                    let (nearer_m, former) = (next.0, shape.replace(next.1));
                    let Some(former) = former else { return *known_m = nearer_m };
                    next = (core::mem::replace(known_m, nearer_m), former);
                }
            }
            of_others_m = of_others_m.min(next.0);
        });
        *last = Some(Self { shapes, place, distances_m: [from_m, of_others_m] });
        from_m
    }
}

/// More than what rounding makes of a way, as a share and in metres.
const SLACK: f64 = 1e-9;

/// What is so much farther than the nearest shape is looked at for the next place, in metres.
const AROUND_M: f64 = 0.2;

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
