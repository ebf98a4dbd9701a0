//! The scene that sensors look at: the arena and all that moves in it, frozen at the start of the tick.

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Index, Point, Ray, Segment, Vector, polygon};
use serde::{Deserialize, Serialize};

use crate::arena::{Arena, Look};
use crate::surroundings::{Lit, Surroundings};
use crate::time::SimTime;

/// A body in the scene: a robot, or a thing that moves.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    /// The disc that it is, or that its outline fits in.
    pub(crate) disc: Circle,
    /// Its corners in the world; none if it is the disc.
    pub(crate) outline: Vec<Point>,
    pub(crate) look: Look,
}

/// All that is frozen. The robots come first among the bodies, in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frozen {
    pub(crate) bodies: Vec<Figure>,
    pub(crate) lights: Vec<Lit>,
    pub(crate) sounds: Vec<Sound>,
    /// The sonar pulses of the last tick.
    pub(crate) pings: Vec<Ping>,
}

/// A pulse of a sonar that others can hear.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Ping {
    /// The robot that sent it.
    pub(crate) robot: usize,
    pub(crate) from: Point,
    pub(crate) at: SimTime,
}

/// A sound that a robot makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sound {
    pub(crate) robot: usize,
    pub(crate) from: Point,
    /// How loud it is at a metre.
    pub(crate) level: f64,
}

/// The frozen scene as one robot sees it.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) arena: &'a Arena,
    pub(crate) surroundings: &'a Surroundings,
    pub(crate) frozen: &'a Frozen,
    /// The robot that looks: its own body hides nothing from it.
    pub(crate) own: usize,
}

impl<'a> Scene<'a> {
    /// A look from `from`, at a height whose layer of the arena is `layer`, as far as `range_m`.
    pub(crate) fn look(&self, from: Point, height: Height, range_m: f64) -> Eye<'a> {
        let bodies = &self.frozen.bodies;
        let reach = |body: &Figure| {
            let far = range_m + body.disc.radius;
            (body.disc.center - from).norm_squared() <= far * far
                && body.look.height_m >= height.above_floor_m
        };
        // One body in sight is common, a crowd is not: remember the span of those that can be hit.
        let mut others = bodies.iter().enumerate().filter(|(i, body)| *i != self.own && reach(body));
        let first = others.next().map(|(i, _)| i);
        let last = others.next_back().map(|(i, _)| i).or(first);
        let span = first.zip(last).map_or(0..0, |(first, last)| first..last + 1);
        Eye { index: self.arena.seen(height.layer), scene: *self, height, range_m, span }
    }
}

/// How high a sensor sits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Height {
    /// In metres.
    pub above_floor_m: f64,
    /// The layer of the arena with what reaches up to there.
    pub(crate) layer: usize,
}

/// A look from one point.
pub(crate) struct Eye<'a> {
    scene: Scene<'a>,
    index: &'a Index,
    height: Height,
    range_m: f64,
    /// Bodies outside this span are out of reach.
    span: core::ops::Range<usize>,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sight {
    pub(crate) distance_m: f64,
    pub(crate) what: What,
}

/// Whose surface a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum What {
    Fixed(baudbot_geometry::Shape),
    /// By its place among the bodies.
    Figure(usize),
}

impl Eye<'_> {
    /// Distance to the nearest thing along `ray`, if within range.
    pub(crate) fn cast(&self, ray: &Ray) -> Option<f64> {
        self.see(ray).map(|sight| sight.distance_m)
    }

    /// The nearest thing along `ray`, if within range.
    pub(crate) fn see(&self, ray: &Ray) -> Option<Sight> {
        let hit = self.index.cast(ray, self.range_m);
        let mut nearest = hit.map(|hit| Sight { distance_m: hit.distance, what: What::Fixed(hit.shape) });
        for i in self.span.clone().filter(|&i| i != self.scene.own) {
            let body = &self.scene.frozen.bodies[i];
            if body.look.height_m >= self.height.above_floor_m
                && let Some(distance_m) = body.hit(ray)
                && distance_m <= self.range_m
                && nearest.is_none_or(|best| distance_m < best.distance_m)
            {
                nearest = Some(Sight { distance_m, what: What::Figure(i) });
            }
        }
        nearest
    }

    /// Its colour and height.
    pub(crate) fn look_of(&self, sight: &Sight) -> Look {
        match sight.what {
            What::Fixed(shape) => self.scene.arena.look_of(self.height.layer, shape),
            What::Figure(i) => self.scene.frozen.bodies[i].look,
        }
    }

    /// The angle between the ray and the surface's normal where they meet, in [0, π/2].
    pub(crate) fn incidence_rad(&self, ray: &Ray, sight: &Sight) -> f64 {
        let at = ray.at(sight.distance_m);
        let normal = match sight.what {
            What::Fixed(baudbot_geometry::Shape::Segment(i)) => normal_of(&self.index.segments()[i]),
            What::Fixed(baudbot_geometry::Shape::Circle(i)) => at - self.index.circles()[i].center,
            What::Figure(i) => self.scene.frozen.bodies[i].normal_at(at),
        };
        let length = normal.norm();
        if length == 0.0 {
            return 0.0;
        }
        let cosine = (normal.dot(&ray.direction.vector()) / length).abs().min(1.0);
        baudbot_geometry::math::atan2(baudbot_geometry::math::sqrt(1.0 - cosine * cosine), cosine)
    }
}

impl Figure {
    /// How far along `ray` it is, if the ray meets it.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<f64> {
        if self.outline.is_empty() {
            return ray.hit_circle(&self.disc);
        }
        ray.hit_circle(&self.disc)?;
        polygon::edges(&self.outline).filter_map(|edge| ray.hit_segment(&edge)).reduce(f64::min)
    }

    fn normal_at(&self, at: Point) -> Vector {
        let nearest = polygon::edges(&self.outline)
            .min_by(|a, b| a.distance_squared(at).total_cmp(&b.distance_squared(at)));
        nearest.map_or(at - self.disc.center, |edge| normal_of(&edge))
    }
}

fn normal_of(segment: &Segment) -> Vector {
    let along = segment.end - segment.start;
    Vector::new(-along.y, along.x)
}
