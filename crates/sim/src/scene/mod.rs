//! The scene that sensors look at: the arena and all that moves in it, frozen at the start of the tick.

mod blocks;
mod figure;
mod neighbors;
mod sector;

use alloc::vec::Vec;
use core::cell::OnceCell;
use core::ops::Range;

use baudbot_geometry::{
    Bundle, Circle, Crowd, Direction, Fan, Index, Point, Pose, Ray, Sweep, Vector, polygon,
};
use serde::{Deserialize, Serialize};

use crate::arena::{Arena, Height, Look};
use crate::surroundings::{Lit, Surroundings};
use crate::time::SimTime;
use crate::trail::Trails;
pub(crate) use blocks::{Blocks, Pixel};
use neighbors::Neighbors;
pub(crate) use neighbors::Reach;
use sector::Strokes;
pub(crate) use sector::{InSector, Sector};

/// A body in the scene: a robot, or a thing that moves.
#[derive(Clone, Debug)]
pub(crate) struct Figure {
    /// The disc that it is, or that its outline fits in.
    pub(crate) disc: Circle,
    /// The corners in the world; none if it is the disc.
    pub(crate) outline: Vec<Point>,
    pub(crate) look: Look,
}

/// All that is frozen. The robots come first among the bodies, in their order, and the parts of robots last.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frozen {
    pub(crate) bodies: Vec<Figure>,
    /// The place of the first part among the bodies.
    pub(crate) first_part: usize,
    /// The robot of each part.
    pub(crate) carriers: Vec<usize>,
    /// The bodies' discs, by their places among them.
    pub(crate) crowd: Crowd,
    pub(crate) lights: Vec<Lit>,
    pub(crate) sounds: Vec<Sound>,
    /// The sonar pulses of the last tick.
    pub(crate) pings: Vec<Ping>,
}

/// A pulse of a sonar that others can receive.
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
    /// The loudness at a metre.
    pub(crate) level: f64,
    /// The frequency, in hertz, if it is a tone.
    pub(crate) frequency_hz: Option<f64>,
}

/// The frozen scene as one robot sees it.
pub(crate) struct Scene<'a> {
    pub(crate) arena: &'a Arena,
    pub(crate) surroundings: &'a Surroundings,
    pub(crate) frozen: &'a Frozen,
    /// What robots have added to fields.
    pub(crate) trails: &'a Trails,
    /// The robot that looks: its own body hides nothing from it.
    pub(crate) own: usize,
    /// The radius around it within which the shapes for its sensors are collected, if that pays.
    reach: Option<Reach>,
    /// The shapes near the robot, computed at the first use; `None` if there are too many.
    neighbors: OnceCell<Option<Neighbors>>,
    strokes: OnceCell<Option<Strokes>>,
    facing: OnceCell<Direction>,
}

impl<'a> Scene<'a> {
    /// The scene for robot `own`, whose sensors reach so far.
    pub(crate) fn new(
        (arena, surroundings): (&'a Arena, &'a Surroundings),
        (frozen, trails): (&'a Frozen, &'a Trails),
        own: usize,
        reach: Option<Reach>,
    ) -> Self {
        let (neighbors, strokes, facing) = (OnceCell::new(), OnceCell::new(), OnceCell::new());
        Self { arena, surroundings, frozen, trails, own, reach, neighbors, strokes, facing }
    }

    /// The robot's heading, at `pose`, as a direction. It has the same pose all the time that the scene is frozen.
    pub(crate) fn facing(&self, pose: &Pose) -> Direction {
        *self.facing.get_or_init(|| pose.direction())
    }

    /// The shapes near the robot, if this disc has all that matter.
    fn neighbors(&self, disc: &Circle, layer: usize) -> Option<&Neighbors> {
        let reach = self.reach.filter(|reach| reach.layer == layer && reach.radius_m >= disc.radius)?;
        self.all_neighbors(reach).filter(|neighbors| neighbors.covers(disc, layer))
    }

    fn all_neighbors(&self, reach: Reach) -> Option<&Neighbors> {
        let collect = || Neighbors::of(reach, self.own, self.arena.seen(reach.layer), self.frozen);
        self.neighbors.get_or_init(collect).as_ref()
    }

    /// A look from `from`, at a height whose layer of the arena is `layer`, as far as `range_m`.
    pub(crate) fn look(&self, from: Point, height: Height, range_m: f64) -> Viewpoint<'_> {
        self.look_with_eye(from, from, height, range_m)
    }

    /// The same of an eye that is at `eye` in the frozen scene, and has moved on to `from` since.
    pub(crate) fn look_with_eye(
        &self,
        eye: Point,
        from: Point,
        height: Height,
        range_m: f64,
    ) -> Viewpoint<'_> {
        let covered = self.covering(eye, height);
        Viewpoint { covered, ..self.look_around(from, height, range_m) }
    }

    /// A look of an eye that sticks out of nothing.
    pub(crate) fn look_around(&self, from: Point, height: Height, range_m: f64) -> Viewpoint<'_> {
        let around = Circle { center: from, radius: range_m };
        Viewpoint {
            index: self.arena.seen(height.layer),
            scene: self,
            height,
            around,
            covered: None,
            rise: None,
        }
    }

    /// Whether a place on the looking robot, in its own frame, is within its body, if that is a disc.
    #[inline]
    pub(crate) fn is_in_own_disc(&self, place: Vector) -> bool {
        let body = &self.frozen.bodies[self.own];
        body.outline.is_empty() && reaches(body.disc.radius, place)
    }

    /// The thing that an eye which sticks out of its body has been pushed into or through: between it and the body's
    /// middle.
    fn covering(&self, eye: Point, height: Height) -> Option<What> {
        let body = &self.frozen.bodies[self.own];
        let (middle, radius) = (body.disc.center, body.disc.radius);
        let out = eye - middle;
        let is_within = if body.outline.is_empty() {
            reaches(radius, out)
        } else {
            polygon::contains(&body.outline, eye)
        };
        if is_within {
            return None;
        }
        let far = out.norm();
        let around = Circle { center: middle, radius: far };
        let near = self.neighbors(&around, height.layer);
        // Mostly nothing is as near as the eye, and then there is nothing to search for.
        if near.is_some_and(|near| near.leave_free(&around, self.arena.seen(height.layer), self.frozen)) {
            return None;
        }
        let direction = Direction { cos: out.x / far, sin: out.y / far };
        let ray = Ray { origin: middle, direction };
        self.look_around(middle, height, far - TOUCHING_M).see(&ray).map(|hit| hit.what)
    }
}

/// A look from one point.
pub(crate) struct Viewpoint<'a> {
    scene: &'a Scene<'a>,
    index: &'a Index,
    height: Height,
    /// A shape outside of this disc is out of reach.
    around: Circle,
    /// The thing that the eye is in, or behind: all that it sees is that, at no distance.
    covered: Option<What>,
    /// The metres by which rays rise for each metre on the floor; level rays have none. Such rays meet the floor, too.
    rise: Option<f64>,
}

/// The thing that a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayHit {
    pub(crate) distance_m: f64,
    pub(crate) what: What,
}

/// The owner of the surface that a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum What {
    Fixed(baudbot_geometry::Shape),
    /// The place of the figure among the bodies.
    Figure(usize),
}

impl Viewpoint<'_> {
    /// Distance to the nearest thing along `ray`, if within range.
    pub(crate) fn cast(&self, ray: &Ray) -> Option<f64> {
        self.see(ray).map(|hit| hit.distance_m)
    }

    /// The nearest thing along `ray`, if within range (§3.2.3).
    pub(crate) fn see(&self, ray: &Ray) -> Option<RayHit> {
        if let Some(what) = self.covered {
            return Some(RayHit { distance_m: 0.0, what });
        }
        let range_m = self.around.radius;
        let hit = self.index.cast(ray, range_m);
        let fixed = hit.map(|hit| RayHit { distance_m: hit.distance, what: What::Fixed(hit.shape) });
        let mut body: Option<(f64, usize)> = None;
        self.bodies(&self.around, |i, figure| {
            if let Some(distance_m) = figure.hit(ray)
                && distance_m <= range_m
                && body.is_none_or(|best| (distance_m, i) < best)
            {
                body = Some((distance_m, i));
            }
        });
        match (fixed, body) {
            (Some(fixed), Some((distance_m, _))) if fixed.distance_m <= distance_m => Some(fixed),
            (_, Some((distance_m, i))) => Some(RayHit { distance_m, what: What::Figure(i) }),
            (fixed, None) => fixed,
        }
    }

    /// Visits the bodies that may be in this disc, in no order; one may come twice.
    fn bodies(&self, around: &Circle, mut visit: impl FnMut(usize, &Figure)) {
        let Frozen { bodies, crowd, .. } = self.scene.frozen;
        crowd.near(around, |i| {
            if !self.scene.frozen.is_of(i, self.scene.own) && self.sees(&bodies[i]) {
                visit(i, &bodies[i]);
            }
        });
    }

    /// The same of rays that rise by this angle: their range is along them.
    pub(crate) fn raised(mut self, elevation_rad: f64) -> Self {
        let (sin, cos) = baudbot_geometry::math::sin_cos(elevation_rad);
        self.rise = Some(sin / cos);
        self.around.radius *= cos;
        self
    }

    /// Whether the body reaches up to the eye.
    fn sees(&self, figure: &Figure) -> bool {
        figure.reaches(self.height)
    }

    /// The length of each of these rays of a fan from a sensor at `pose`, where this eye is: infinite if it meets
    /// nothing within range.
    pub(crate) fn sweep(&self, pose: &Pose, fan: &Fan, rays: Range<usize>, distances_m: &mut [f64]) {
        if self.covered.is_some() {
            return distances_m.fill(0.0);
        }
        match self.rise {
            None => self.fill(Sweep::new(pose, fan, rays, self.around.radius, distances_m)),
            Some(rise) => {
                let facing = pose.direction();
                let rays = fan.rays(pose.position, facing).skip(rays.start).take(rays.len());
                self.blocks().each(rays, rise, distances_m);
            }
        }
    }

    /// The length of each ray of a bundle, whose rays start where eyes as this one are.
    pub(crate) fn sweep_bundle(&self, bundle: &Bundle<'_>, distances_m: &mut [f64]) {
        if self.covered.is_some() {
            return distances_m.fill(0.0);
        }
        match self.rise {
            None => self.fill(Sweep::of_bundle(bundle, self.around.radius, distances_m)),
            Some(rise) => {
                let rays = (0..distances_m.len()).map(|i| bundle.ray(i));
                self.blocks_within(bundle.stray_m()).each(rays, rise, distances_m);
            }
        }
    }

    fn fill(&self, mut sweep: Sweep<'_>) {
        let around = sweep.around();
        let add = |sweep: &mut Sweep<'_>, figure: &Figure| {
            if figure.outline.is_empty() {
                sweep.circle(&figure.disc);
            } else {
                sweep.other(&figure.disc, |ray| figure.hit(ray));
            }
        };
        match self.scene.neighbors(&around, self.height.layer) {
            Some(neighbors) => {
                neighbors.sweep(self.index, &mut sweep);
                let bodies = neighbors.bodies.iter().map(|&i| &self.scene.frozen.bodies[i as usize]);
                bodies.filter(|figure| self.sees(figure)).for_each(|figure| add(&mut sweep, figure));
            }
            None => {
                self.index.sweep(&mut sweep);
                self.bodies(&around, |_, figure| add(&mut sweep, figure));
            }
        }
        sweep.finish();
    }

    /// Visits all rays of a fan in their order, each with how far it runs.
    pub(crate) fn each(&self, pose: &Pose, fan: &Fan, mut visit: impl FnMut(usize, f64)) {
        let neighbors = self.scene.neighbors(&self.around, self.height.layer);
        if neighbors.is_some_and(Neighbors::is_empty) && self.covered.is_none() && self.rise.is_none() {
            return (0..fan.len()).for_each(|i| visit(i, f64::INFINITY));
        }
        let mut distances_m = [0.0; 16];
        let mut first = 0;
        while first < fan.len() {
            let rays = first..(first + distances_m.len()).min(fan.len());
            first = rays.end;
            let distances_m = &mut distances_m[..rays.len()];
            self.sweep(pose, fan, rays.clone(), distances_m);
            rays.zip(distances_m).for_each(|(i, distance_m)| visit(i, *distance_m));
        }
    }

    /// The length of the fan's ray that comes back first, if any does.
    pub(crate) fn nearest(&self, pose: &Pose, fan: &Fan) -> Option<f64> {
        let mut nearest = f64::INFINITY;
        self.each(pose, fan, |_, distance_m| nearest = nearest.min(distance_m));
        nearest.is_finite().then_some(nearest)
    }

    /// The colour and height of what the ray hit.
    pub(crate) fn look_of(&self, hit: &RayHit) -> Look {
        match hit.what {
            What::Fixed(shape) => self.scene.arena.look_of(self.height.layer, shape),
            What::Figure(i) => self.scene.frozen.bodies[i].look,
        }
    }

    /// The radius of what the ray hit, in metres, if it is round.
    pub(crate) fn radius_of(&self, hit: &RayHit) -> Option<f64> {
        match hit.what {
            What::Fixed(baudbot_geometry::Shape::Segment(_)) => None,
            What::Fixed(baudbot_geometry::Shape::Circle(i)) => Some(self.index.circles()[i].radius),
            What::Figure(i) => {
                let figure = &self.scene.frozen.bodies[i];
                figure.outline.is_empty().then_some(figure.disc.radius)
            }
        }
    }

    /// The angle between the ray and the surface's normal where they meet, in [0, π/2].
    pub(crate) fn incidence_rad(&self, ray: &Ray, hit: &RayHit) -> f64 {
        let at = ray.at(hit.distance_m);
        let normal = match hit.what {
            What::Fixed(baudbot_geometry::Shape::Segment(i)) => figure::normal_of(&self.index.segments()[i]),
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

/// Whether a disc of this radius reaches so far from its middle.
fn reaches(radius_m: f64, out: Vector) -> bool {
    out.norm_squared() <= (radius_m + TOUCHING_M) * (radius_m + TOUCHING_M)
}

/// An eye this close to its body's rim, or to a wall, is on it: it is not in it, or behind.
const TOUCHING_M: f64 = 1e-9;
