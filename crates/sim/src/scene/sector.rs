//! The shapes that a sensor with few rays may meet: in the axes of the body, in which the sensor does not move.
//!
//! A ring of sensors looks at the same few shapes, and most sensors at none of them. So what is near is brought to the body's
//! axes once, and is then held against each sensor's opening, with a margin far above all rounding. What may be met is left to
//! the rays themselves.

use arrayvec::ArrayVec;
use baudbot_geometry::{Direction, Fan, Pencil, Pose, Segment, Shape, Vector};

use super::Scene;
use super::neighbors::{Neighbors, SLACK};
use crate::arena::Height;

/// The part of the plane in which a sensor's rays run, in the axes of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sector {
    right: Side,
    left: Side,
    middle: Side,
    range_m: f64,
    /// The apex.
    apex: Vector,
    /// The distance of that from the body's centre along both axes.
    apex_m: f64,
}

/// A line through the apex: what is at one of its sides has `normal · point > offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    normal: Vector,
    offset: f64,
}

/// A shape in the axes of the body: all of it is within `around` of the line from `a` to `b`.
#[derive(Debug)]
struct Stroke {
    a: Vector,
    b: Vector,
    around: f64,
    what: Near,
}

/// The shapes near a robot, in the axes of its body.
#[derive(Debug)]
pub(super) struct Strokes(ArrayVec<Stroke, MOST_STROKES>);

/// A shape by its place in its layer's index, or a body by its place among those that are frozen.
#[derive(Clone, Copy, Debug)]
enum Near {
    Segment(u32),
    Circle(u32),
    Body(u32),
}

/// The shapes that the rays of a sector may meet.
#[derive(Clone, Copy)]
pub(crate) struct InSector<'a> {
    scene: &'a Scene<'a>,
    strokes: &'a Strokes,
    /// A bit for each stroke.
    met: u16,
}

impl Side {
    fn new(normal: Vector, apex: Vector) -> Self {
        Self { normal, offset: normal.dot(&apex) }
    }

    /// Whether both points are more than `margin` beyond the line.
    fn is_before(&self, stroke: &Stroke, margin: f64) -> bool {
        let offset = self.offset + margin;
        self.normal.dot(&stroke.a) > offset && self.normal.dot(&stroke.b) > offset
    }

    /// Whether both points are more than `margin` on this side of the line.
    fn is_behind(&self, stroke: &Stroke, margin: f64) -> bool {
        let offset = self.offset - margin;
        self.normal.dot(&stroke.a) < offset && self.normal.dot(&stroke.b) < offset
    }
}

impl Sector {
    /// A `Sector` of a sensor that sits and looks so, robot from sensor; `None` if it looks almost everywhere.
    pub(crate) fn new(mount: &Pose, fan: &Fan, range_m: f64) -> Option<Self> {
        let (forward, relative) = (mount.direction(), fan.relative());
        let (right, left) = (relative[0], relative[relative.len() - 1]);
        let apex = mount.position.coords;
        let beside = |direction: Direction| Vector::new(-direction.sin, direction.cos);
        (fan.opening_rad() < MOST_RAD).then(|| Self {
            right: Side::new(beside(forward.rotate(right)), apex),
            left: Side::new(beside(forward.rotate(left)), apex),
            middle: Side::new(forward.vector(), apex),
            range_m,
            apex,
            apex_m: apex.abs().sum(),
        })
    }

    /// Whether no ray meets it within range.
    fn misses(&self, stroke: &Stroke) -> bool {
        let margin = stroke.around + SLACK * self.apex_m;
        self.right.is_behind(stroke, margin)
            || self.left.is_before(stroke, margin)
            || self.middle.is_behind(stroke, margin)
            || self.middle.is_before(stroke, self.range_m + margin)
    }
}

impl Scene<'_> {
    /// The shapes that the rays of this sector may meet, on a robot at `pose` that has it among those that
    /// [`reach`](super::Reach) is of; `None` if too much is near, or if the eye, at this height, is covered.
    #[inline]
    pub(crate) fn in_sector(&self, sector: &Sector, height: Height, pose: &Pose) -> Option<InSector<'_>> {
        if !self.is_in_own_disc(sector.apex) {
            let eye = pose.position + self.facing(pose).apply(sector.apex);
            if self.covering(eye, height).is_some() {
                return None;
            }
        }
        let strokes = self.strokes.get_or_init(|| {
            let (reach, facing) = (self.reach?, self.facing(pose));
            self.all_neighbors(reach).and_then(|neighbors| Strokes::of(neighbors, self, pose, facing))
        });
        let strokes = strokes.as_ref()?;
        let mut met = 0;
        for (i, stroke) in strokes.0.iter().enumerate() {
            met |= u16::from(!sector.misses(stroke)) << i;
        }
        Some(InSector { scene: self, strokes, met })
    }
}

impl InSector<'_> {
    /// Whether nothing is in the way.
    pub(crate) fn is_clear(&self) -> bool {
        self.met == 0
    }

    /// Holds all of it against the rays of an eye at this height.
    pub(crate) fn meet(&self, pencil: &mut Pencil, height: Height) {
        let index = self.scene.arena.seen(height.layer);
        let mut left = self.met;
        while left != 0 {
            let what = self.strokes.0[left.trailing_zeros() as usize].what;
            left &= left - 1;
            match what {
                Near::Segment(i) => pencil.segment(&index.segments()[i as usize]),
                Near::Circle(i) => pencil.circle(&index.circles()[i as usize]),
                Near::Body(i) => {
                    let figure = &self.scene.frozen.bodies[i as usize];
                    match (figure.reaches(height), figure.outline.is_empty()) {
                        (false, _) => {}
                        (true, true) => pencil.circle(&figure.disc),
                        (true, false) => pencil.other(|ray| figure.hit(ray)),
                    }
                }
            }
        }
    }
}

impl Strokes {
    fn of(neighbors: &Neighbors, scene: &Scene<'_>, pose: &Pose, facing: Direction) -> Option<Self> {
        if neighbors.len() > MOST_STROKES {
            return None;
        }
        let (origin, behind) = (pose.position, facing.inverse());
        let far = origin.coords.abs().sum();
        let stroke = |Segment { start, end }: Segment, radius: f64, what: Near| {
            let (a, b) = (behind.apply(start - origin), behind.apply(end - origin));
            // Of the rounding of the corners' coordinates, of their turning, and of the apex' distance from them.
            let size =
                far + start.coords.abs().sum() + end.coords.abs().sum() + a.abs().sum() + b.abs().sum();
            Stroke { a, b, around: radius + SLACK * size, what }
        };
        let index = scene.arena.seen(neighbors.layer);
        let shapes = neighbors.shapes(index).map(|shape| match shape {
            Shape::Segment(i) => stroke(index.segments()[i], 0.0, Near::Segment(i as u32)),
            Shape::Circle(i) => {
                let circle = &index.circles()[i];
                stroke(
                    Segment { start: circle.center, end: circle.center },
                    circle.radius,
                    Near::Circle(i as u32),
                )
            }
        });
        let bodies = neighbors.bodies.iter().map(|&i| {
            let disc = &scene.frozen.crowd.discs()[i as usize];
            stroke(Segment { start: disc.center, end: disc.center }, disc.radius, Near::Body(i))
        });
        Some(Self(shapes.chain(bodies).collect()))
    }
}

/// With more than this near, most sensors meet something. There are as many bits in [`InSector`].
const MOST_STROKES: usize = 12;

/// Half a turn, less than which the rays are on one side of each of the outer two.
const MOST_RAD: f64 = 3.0;
