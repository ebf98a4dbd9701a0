//! The shapes near one robot: collected once a tick for all sensors that do not look far, such as a ring of IR sensors.

use arrayvec::ArrayVec;
use baudbot_geometry::{Circle, Index, Point, Shape, Sweep};

use super::Frozen;

/// The range around a robot of its sensors with few rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reach {
    /// The distance from the robot's centre, in metres.
    pub(crate) radius_m: f64,
    /// The layer of the arena that they see.
    pub(crate) layer: usize,
}

/// The shapes near one robot, in one layer.
#[derive(Debug)]
pub(crate) struct Neighbors {
    around: Circle,
    pub(super) layer: usize,
    /// The shapes by their places in the layer's index: segments, then circles.
    shapes: ArrayVec<u32, MOST_SHAPES>,
    /// The places of the bodies among the frozen ones.
    pub(crate) bodies: ArrayVec<u32, MOST_BODIES>,
}

impl Reach {
    /// In this layer, as far as `farthest_m` and by what rounding can make of that.
    pub(crate) fn new(farthest_m: f64, layer: usize) -> Self {
        Self { radius_m: farthest_m * (1.0 + SLACK), layer }
    }
}

impl Neighbors {
    /// The shapes near robot `own`; `None` if there are too many.
    pub(super) fn of(reach: Reach, own: usize, index: &Index, frozen: &Frozen) -> Option<Self> {
        let around = Circle { center: frozen.bodies[own].disc.center, radius: reach.radius_m };
        let (mut shapes, mut bodies) = (ArrayVec::new(), ArrayVec::new());
        let mut overflows = false;
        index.near(&around, |shape| {
            let is_near = match shape {
                Shape::Segment(i) => {
                    let segment = &index.segments()[i];
                    widened(&around, segment.start).overlaps_segment(segment)
                }
                Shape::Circle(i) => {
                    let circle = &index.circles()[i];
                    widened(&around, circle.center).overlaps_circle(circle)
                }
            };
            if is_near {
                overflows |= !add(&mut shapes, number(index, shape));
            }
        });
        frozen.crowd.near(&around, |i| {
            let disc = &frozen.crowd.discs()[i];
            if i != own && widened(&around, disc.center).overlaps_circle(disc) && !frozen.is_of(i, own) {
                overflows |= !add(&mut bodies, i as u32);
            }
        });
        (!overflows).then_some(Self { around, layer: reach.layer, shapes, bodies })
    }

    /// Whether all that is within this disc, in this layer, is among it.
    pub(crate) fn covers(&self, disc: &Circle, layer: usize) -> bool {
        let left = self.around.radius - disc.radius;
        layer == self.layer && left >= 0.0 && (disc.center - self.around.center).norm_squared() <= left * left
    }

    /// The number of shapes.
    pub(super) fn len(&self) -> usize {
        self.shapes.len() + self.bodies.len()
    }

    /// The shapes of the layer's index.
    pub(super) fn shapes(&self, index: &Index) -> impl Iterator<Item = Shape> {
        let segments = index.segments().len();
        self.shapes.iter().map(move |&number| match (number as usize).checked_sub(segments) {
            None => Shape::Segment(number as usize),
            Some(circle) => Shape::Circle(circle),
        })
    }

    /// Whether none of it reaches into this disc.
    pub(super) fn leave_free(&self, disc: &Circle, index: &Index, frozen: &Frozen) -> bool {
        let is_in = |shape| match shape {
            Shape::Segment(i) => disc.overlaps_segment(&index.segments()[i]),
            Shape::Circle(i) => disc.overlaps_circle(&index.circles()[i]),
        };
        let discs = frozen.crowd.discs();
        !self.shapes(index).any(is_in)
            && !self.bodies.iter().any(|&i| disc.overlaps_circle(&discs[i as usize]))
    }

    /// Whether there is nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.shapes.is_empty() && self.bodies.is_empty()
    }

    /// Adds all shapes of the layer's index.
    pub(crate) fn sweep(&self, index: &Index, sweep: &mut Sweep<'_>) {
        for shape in self.shapes(index) {
            match shape {
                Shape::Segment(i) => sweep.segment(&index.segments()[i]),
                Shape::Circle(i) => sweep.circle(&index.circles()[i]),
            }
        }
    }
}

/// Notes the place, once; false if there is no room. Out of line: many are looked at, and few of them are near.
#[inline(never)]
fn add<const MOST: usize>(places: &mut ArrayVec<u32, MOST>, place: u32) -> bool {
    places.contains(&place) || places.try_push(place).is_ok()
}

/// Less than a place takes, as these are copied.
fn number(index: &Index, shape: Shape) -> u32 {
    match shape {
        Shape::Segment(i) => i as u32,
        Shape::Circle(i) => (index.segments().len() + i) as u32,
    }
}

/// The disc, wider by more than the rounding of coordinates of this size.
fn widened(disc: &Circle, near: Point) -> Circle {
    let size = disc.center.coords.abs().sum() + near.coords.abs().sum();
    Circle { radius: disc.radius + SLACK * size, ..*disc }
}

const MOST_SHAPES: usize = 24;

const MOST_BODIES: usize = 12;

pub(super) const SLACK: f64 = 1e-9;
