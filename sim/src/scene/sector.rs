//! What a sensor with few rays may meet at all: told in the axes of the body, in which the sensor does not move.
//!
//! A ring of sensors looks at the same few shapes, and most sensors at none of them. So what is near is brought to the body's
//! axes once, and is then held against each sensor's opening, with a margin far above all rounding. What may be met is left to
//! the rays themselves.

use arrayvec::ArrayVec;
use baudbot_geometry::{Direction, Fan, Pose, Segment, Shape, Vector};

use super::Scene;
use super::neighbors::{Neighbors, SLACK};

/// The part of the plane in which a sensor's rays run, in the axes of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sector {
    apex: Vector,
    right: Vector,
    left: Vector,
    middle: Vector,
    range_m: f64,
}

/// A shape in the axes of the body: all of it is within `around` of the line from `a` to `b`.
#[derive(Debug)]
struct Stroke {
    a: Vector,
    b: Vector,
    around: f64,
}

/// What is near a robot, in the axes of its body.
#[derive(Debug)]
pub(super) struct Strokes(ArrayVec<Stroke, MOST_STROKES>);

impl Sector {
    /// Of a sensor that sits and looks so, robot from sensor; `None` if it looks almost everywhere.
    pub(crate) fn new(mount: &Pose, fan: &Fan, range_m: f64) -> Option<Self> {
        let (forward, relative) = (mount.direction(), fan.relative());
        let (right, left) = (relative[0], relative[relative.len() - 1]);
        (fan.opening_rad() < MOST_RAD).then(|| Self {
            apex: mount.position.coords,
            right: forward.rotate(right).vector(),
            left: forward.rotate(left).vector(),
            middle: forward.vector(),
            range_m,
        })
    }

    /// Whether no ray meets it within range.
    fn misses(&self, stroke: &Stroke) -> bool {
        let (a, b) = (stroke.a - self.apex, stroke.b - self.apex);
        let margin = stroke.around + SLACK * (a.abs().sum() + b.abs().sum());
        let (ahead_a, ahead_b) = (self.middle.dot(&a), self.middle.dot(&b));
        let far = self.range_m + margin;
        (self.right.perp(&a) < -margin && self.right.perp(&b) < -margin)
            || (self.left.perp(&a) > margin && self.left.perp(&b) > margin)
            || (ahead_a < -margin && ahead_b < -margin)
            || (ahead_a > far && ahead_b > far)
    }
}

impl Scene<'_> {
    /// Whether nothing is in the way of the rays of this sector, on a robot at `pose` that has it among those that
    /// [`reach`](super::Reach) is of.
    pub(crate) fn is_clear(&self, sector: &Sector, pose: &Pose) -> bool {
        let strokes = self.strokes.get_or_init(|| {
            let (reach, facing) = (self.reach?, self.facing(pose));
            self.all_neighbors(reach).and_then(|neighbors| Strokes::of(neighbors, self, pose, facing))
        });
        strokes.as_ref().is_some_and(|strokes| strokes.0.iter().all(|stroke| sector.misses(stroke)))
    }
}

impl Strokes {
    fn of(neighbors: &Neighbors, scene: &Scene<'_>, pose: &Pose, facing: Direction) -> Option<Self> {
        if neighbors.shapes.len() + neighbors.bodies.len() > MOST_STROKES {
            return None;
        }
        let (origin, behind) = (pose.position, facing.inverse());
        let stroke = |Segment { start, end }: Segment, radius: f64| {
            let size = origin.coords.abs().sum() + start.coords.abs().sum() + end.coords.abs().sum();
            let (a, b) = (behind.apply(start - origin), behind.apply(end - origin));
            Stroke { a, b, around: radius + SLACK * size }
        };
        let index = scene.arena.seen(neighbors.layer);
        let shapes = neighbors.shapes.iter().map(|shape| match *shape {
            Shape::Segment(i) => stroke(index.segments()[i], 0.0),
            Shape::Circle(i) => {
                let circle = &index.circles()[i];
                stroke(Segment { start: circle.center, end: circle.center }, circle.radius)
            }
        });
        let bodies = neighbors.bodies.iter().map(|&i| {
            let disc = &scene.frozen.bodies[i as usize].disc;
            stroke(Segment { start: disc.center, end: disc.center }, disc.radius)
        });
        Some(Self(shapes.chain(bodies).collect()))
    }
}

/// With more than this near, most sensors meet something.
const MOST_STROKES: usize = 12;

/// Half a turn, less than which the rays are on one side of each of the outer two.
const MOST_RAD: f64 = 3.0;
