//! What is near one robot: collected once a tick for all sensors that do not look far, such as a ring of IR sensors.

use arrayvec::ArrayVec;
use baudbot_geometry::{Circle, Index, Point, Shape, Sweep};

use crate::robot::RobotSpec;
use crate::scene::Frozen;
use crate::sensor::Sensor;

/// How far around a robot its sensors with few rays look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reach {
    /// From the robot's centre, in metres.
    pub(crate) radius_m: f64,
    /// The layer of the arena that they see.
    pub(crate) layer: usize,
}

/// What is near one robot, in one layer.
#[derive(Debug)]
pub(crate) struct Vicinity {
    around: Circle,
    layer: usize,
    /// By their places in the layer's index.
    shapes: ArrayVec<Shape, MOST_SHAPES>,
    /// By their places among the frozen bodies.
    pub(crate) bodies: ArrayVec<u32, MOST_BODIES>,
}

impl Reach {
    /// That of a robot with these sensors; `None` if it would not pay.
    pub(crate) fn of(sensors: &[Sensor]) -> Option<Self> {
        let looks = sensors.iter().filter_map(|sensor| {
            let (mount, range_m) = (sensor.device.mount()?, sensor.device.range_m()?);
            let is_narrow = sensor.device.fan().is_some_and(|fan| fan.len() <= FEW_RAYS);
            let offset_m = mount.pose.position.coords.norm();
            is_narrow.then_some((mount.height.layer, offset_m + range_m))
        });
        let (layer, _) = looks.clone().next()?;
        let here = looks.filter(|(other, _)| *other == layer);
        let radius_m = here.clone().map(|(_, reach_m)| reach_m).fold(0.0, f64::max) * (1.0 + SLACK);
        (here.count() > 1).then_some(Self { radius_m, layer })
    }
}

impl Vicinity {
    /// What is near robot `own`; `None` if that is more than can be told in short.
    pub(crate) fn of(spec: &RobotSpec, own: usize, index: &Index, frozen: &Frozen) -> Option<Self> {
        let reach = spec.sensors.reach()?;
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
            if is_near && !shapes.contains(&shape) {
                overflows |= shapes.try_push(shape).is_err();
            }
        });
        frozen.crowd.near(&around, |i| {
            let disc = &frozen.bodies[i].disc;
            let (i, is_own) = (i as u32, i == own);
            if !is_own && widened(&around, disc.center).overlaps_circle(disc) && !bodies.contains(&i) {
                overflows |= bodies.try_push(i).is_err();
            }
        });
        (!overflows).then_some(Self { around, layer: reach.layer, shapes, bodies })
    }

    /// Whether all that is within this disc, in this layer, is among it.
    pub(crate) fn covers(&self, disc: &Circle, layer: usize) -> bool {
        let left = self.around.radius - disc.radius;
        layer == self.layer && left >= 0.0 && (disc.center - self.around.center).norm_squared() <= left * left
    }

    /// Whether there is nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.shapes.is_empty() && self.bodies.is_empty()
    }

    /// Adds all shapes of the layer's index.
    pub(crate) fn sweep(&self, index: &Index, sweep: &mut Sweep<'_>) {
        for shape in &self.shapes {
            match *shape {
                Shape::Segment(i) => sweep.segment(&index.segments()[i]),
                Shape::Circle(i) => sweep.circle(&index.circles()[i]),
            }
        }
    }
}

/// By more than rounding can make of coordinates of this size.
fn widened(disc: &Circle, near: Point) -> Circle {
    let size = disc.center.coords.abs().sum() + near.coords.abs().sum();
    Circle { radius: disc.radius + SLACK * size, ..*disc }
}

/// Sensors with more rays than this look for themselves.
const FEW_RAYS: usize = 16;

const MOST_SHAPES: usize = 24;

const MOST_BODIES: usize = 12;

const SLACK: f64 = 1e-9;
