//! The first shape on each ray of a fan: every shape is looked at once, for all the rays that it may cover.
//!
//! A ray by itself goes through the cells of an [`Index`](crate::Index) and tries what it finds there; the rays of a
//! fan would find the same shapes again and again. Here it is the other way round: of each shape near the fan the
//! interval of rays is computed that its two sides enclose, and along these the distances are found one after the
//! other, in loops without branches that a compiler can make vectors of. Rays far apart from a shape are never tried
//! with it.
//!
//! The distances are those of [`Ray::hit_segment`] and [`Ray::hit_circle`] to the last bit, and so are those of the
//! fan's nearest hits. Intervals are computed with angles that are only about right, and with a margin that is
//! larger than their error; a shape so near that a margin is no help is tried with every ray, by those functions
//! themselves.
//!
//! The rays of a [`Bundle`] each have an origin of their own. They are chosen from one pose among these, with margins
//! for what can be seen otherwise from the others.

mod about;
mod look;
mod meet;

use core::f64::consts::PI;
use core::ops::Range;

use arrayvec::ArrayVec;

use crate::carried::Bundle;
use crate::circle::Circle;
use crate::fan::Fan;
use crate::math;
use crate::pose::{Direction, Pose, Vector};
use crate::ray::Ray;
use crate::segment::Segment;
use crate::vectors::with_vectors;
use about::{Cone, about_atan2, wrapped};
use look::Look;
use meet::{Candidate, Meet, Relative};

/// The distances along some rays of a fan, while shapes are added one after the other.
pub struct Sweep<'a> {
    pose: Pose,
    direction: Option<Direction>,
    fan: &'a Fan,
    rays: Range<usize>,
    /// The rays themselves, if each has its own origin.
    bundle: Option<&'a Bundle<'a>>,
    /// No ray starts farther from the pose, in metres, nor is turned by more, in radians.
    stray_m: f64,
    bent_rad: f64,
    range: f64,
    distances: &'a mut [f64],
    waiting: ArrayVec<Candidate, MOST_WAITING>,
    cone: Option<Cone>,
}

impl<'a> Sweep<'a> {
    /// The rays of these places in the fan of a sensor at this pose, world from sensor. `distances` has a place for
    /// each of them: at last the distance of what it meets first, in metres, at most `range`, or infinity.
    ///
    /// # Panics
    ///
    /// If there are not as many distances as rays, or the fan has not all of the rays.
    #[must_use]
    pub fn new(pose: &Pose, fan: &'a Fan, rays: Range<usize>, range: f64, distances: &'a mut [f64]) -> Self {
        assert!(rays.len() == distances.len() && rays.end <= fan.len(), "a distance for each ray of the fan");
        distances.fill(f64::INFINITY);
        Self {
            pose: *pose,
            direction: None,
            fan,
            rays,
            bundle: None,
            stray_m: 0.0,
            bent_rad: 0.0,
            range,
            distances,
            waiting: ArrayVec::new(),
            cone: None,
        }
    }

    /// The sweep of a bundle.
    ///
    /// # Panics
    ///
    /// If there are not as many distances as rays.
    #[must_use]
    pub fn of_bundle(bundle: &'a Bundle<'a>, range: f64, distances: &'a mut [f64]) -> Self {
        let (stray_m, bent_rad) = (bundle.stray_m, bundle.bent_rad);
        let still = Self::new(&bundle.pose(), bundle.fan(), bundle.places(), range, distances);
        Self { bundle: Some(bundle), stray_m, bent_rad, ..still }
    }

    /// All that is in range is in this disc, or touches it.
    #[must_use]
    pub fn around(&self) -> Circle {
        Circle { center: self.pose.position, radius: self.range + self.stray_m }
    }

    /// Some more segments that may be in the way. Most are far from all rays, which is decided for several at once.
    pub fn segments(&mut self, segments: &[Segment]) {
        let cone = self.cone();
        let mut may_meet = [0; AT_ONCE];
        for segments in segments.chunks(AT_ONCE) {
            let may_meet = &mut may_meet[..segments.len()];
            let around = self.around();
            let size = self.pose.position.coords.abs().sum() + around.radius;
            with_vectors(Look {
                cone: &cone,
                around,
                slack: ROUNDING * size,
                stray: self.stray_m,
                segments,
                may_meet: &mut *may_meet,
            });
            for (segment, _) in segments.iter().zip(may_meet).filter(|(_, may_meet)| **may_meet != 0) {
                self.add_segment(segment, false);
            }
        }
    }

    /// One more segment that may be in the way. To give one twice does no harm.
    pub fn segment(&mut self, segment: &Segment) {
        self.add_segment(segment, true);
    }

    /// Takes a segment that may wait already, if it belongs to a shape that comes more than once.
    fn add_segment(&mut self, segment: &Segment, may_wait: bool) {
        let (a, b) = (segment.start - self.pose.position, segment.end - self.pose.position);
        if self.has_few_rays() {
            return self.try_few((a, b, 0.0), |ray| ray.hit_segment(segment));
        }
        let reach = self.pose.position.coords.abs().sum() + a.abs().sum() + b.abs().sum();
        let nearest = nearest_to_origin(a, b).norm_squared();
        let within = self.range + self.stray_m + ROUNDING * reach;
        let is_near = nearest <= within * within;
        if !is_near {
            return;
        }
        // Seen from a point on the segment or next to it, the angles of its ends are useless: their error is as large
        // as the interval that they enclose. So every ray is tried.
        let close = CLOSE * reach + self.stray_m;
        if nearest <= close * close {
            return self.each_ray(0..usize::MAX, |ray| ray.hit_segment(segment));
        }
        let shape =
            self.kept(Relative::Segment(a, b), Relative::Segment(segment.start.coords, segment.end.coords));
        if !(may_wait && self.waits(&shape)) {
            let spans = self.spans_of_segment(a, b, nearest);
            self.wait(shape, spans);
        }
    }

    /// One more disc that may be in the way. To give one twice does no harm.
    pub fn circle(&mut self, circle: &Circle) {
        let center = circle.center - self.pose.position;
        if self.has_few_rays() {
            return self.try_few((center, center, circle.radius), |ray| ray.hit_circle(circle));
        }
        let within =
            self.range + self.stray_m + circle.radius + ROUNDING * (center.abs().sum() + circle.radius);
        let is_near = center.norm_squared() <= within * within;
        if !is_near || self.is_beside(&center, &center, circle.radius) {
            return;
        }
        let around = circle.radius * (1.0 + CLOSE) + self.stray_m;
        if center.norm_squared() <= around * around {
            return self.each_ray(0..usize::MAX, |ray| ray.hit_circle(circle));
        }
        let radius = circle.radius;
        let shape =
            self.kept(Relative::Circle(center, radius), Relative::Circle(circle.center.coords, radius));
        if !self.waits(&shape) {
            let spans = self.spans_of_circle(center, radius);
            self.wait(shape, spans);
        }
    }

    /// One more shape that is inside of this disc, with the function `hit` for its distance on a ray.
    pub fn other(&mut self, around: &Circle, hit: impl Fn(&Ray) -> Option<f64>) {
        let center = around.center - self.pose.position;
        if self.has_few_rays() {
            return self.try_few((center, center, around.radius), hit);
        }
        let within =
            self.range + self.stray_m + around.radius + ROUNDING * (center.abs().sum() + around.radius);
        let is_near = center.norm_squared() <= within * within;
        if !is_near || self.is_beside(&center, &center, around.radius) {
            return;
        }
        let [first, second] = self.spans_of_circle(center, around.radius);
        self.each_ray(first, &hit);
        self.each_ray(second, &hit);
    }

    /// Holds the rays against all that has been added. Without this some of that may be left out.
    pub fn finish(&mut self) {
        self.meet();
    }

    /// A shape as it waits: as seen from the pose, or as it is in the world if each ray has its own origin.
    fn kept(&self, seen: Relative, in_world: Relative) -> Relative {
        if self.bundle.is_some() { in_world } else { seen }
    }

    fn waits(&self, shape: &Relative) -> bool {
        self.waiting.iter().any(|candidate| candidate.shape == *shape)
    }

    /// Shapes wait until there are some, and are then met together: the distances of each are found in a loop over its rays,
    /// which is set up once for all of them (`with_vectors` asks the processor what it can do).
    fn wait(&mut self, shape: Relative, spans: [Range<usize>; 2]) {
        if self.waiting.is_full() {
            self.meet();
        }
        if !(spans[0].is_empty() && spans[1].is_empty()) {
            self.waiting.push(Candidate { shape, spans });
        }
    }

    /// So few that it is no gain to find out which of them a shape may cover.
    fn has_few_rays(&self) -> bool {
        (1..=FEW_RAYS).contains(&self.rays.len())
    }

    /// Tries each ray with a shape between two points, with so much around them, unless it is beside all rays: that is
    /// decided much faster.
    fn try_few(&mut self, (a, b, around): (Vector, Vector, f64), hit: impl Fn(&Ray) -> Option<f64>) {
        if !self.is_beside(&a, &b, around) {
            self.each_ray(0..usize::MAX, hit);
        }
    }

    /// Whether what is between two points, with so much around them, is for sure beside all rays.
    fn is_beside(&mut self, a: &Vector, b: &Vector, around: f64) -> bool {
        self.cone().has_beside(a, b, around + self.stray_m)
    }

    fn cone(&mut self) -> Cone {
        let Self { pose, fan, rays, cone, bent_rad, .. } = self;
        *cone.get_or_insert_with(|| Cone::of(pose.heading, fan, rays, *bent_rad))
    }

    fn direction(&mut self) -> Direction {
        *self.direction.get_or_insert_with(|| self.pose.direction())
    }

    /// Tries these rays, by their places in the fan, one by one.
    fn each_ray(&mut self, rays: Range<usize>, hit: impl Fn(&Ray) -> Option<f64>) {
        let (origin, forward) = (self.pose.position, self.direction());
        for i in rays.start.max(self.rays.start)..rays.end.min(self.rays.end) {
            let place = i - self.rays.start;
            let ray = match self.bundle {
                Some(bundle) => bundle.ray(place),
                None => Ray { origin, direction: forward.rotate(self.fan.relative()[i]) },
            };
            let nearest = &mut self.distances[place];
            if let Some(distance) = hit(&ray)
                && distance <= self.range
                && distance < *nearest
            {
                *nearest = distance;
            }
        }
    }

    /// The rays, by their places in the fan, that may meet a segment between two points. The square of the distance of
    /// the point of it that is nearest is given.
    fn spans_of_segment(&mut self, a: Vector, b: Vector, nearest_squared: f64) -> [Range<usize>; 2] {
        let (a, b) = if a.perp(&b) >= 0.0 { (a, b) } else { (b, a) };
        let (from, to) = (self.angle(a), self.angle(b));
        // Seen from elsewhere, a point is elsewhere by at most an angle whose sine is the way over the distance.
        let around = if self.stray_m > 0.0 {
            let beside = math::sqrt((nearest_squared - self.stray_m * self.stray_m).max(0.0));
            about_atan2(self.stray_m, beside)
        } else {
            0.0
        };
        self.spans(from, to, around)
    }

    /// The rays that may meet a disc. Seen from elsewhere, it is in a larger one.
    fn spans_of_circle(&mut self, center: Vector, radius: f64) -> [Range<usize>; 2] {
        let radius = radius + self.stray_m;
        let beside = math::sqrt((center.norm_squared() - radius * radius).max(0.0));
        let (middle, half) = (self.angle(center), about_atan2(radius, beside));
        self.spans(middle - half, middle + half, 0.0)
    }

    /// About the angle of a vector from ahead.
    fn angle(&mut self, v: Vector) -> f64 {
        let v = self.direction().inverse().apply(v);
        about_atan2(v.y, v.x)
    }

    /// The rays between two angles, less than half a turn apart, and so much around.
    fn spans(&self, from: f64, to: f64, around: f64) -> [Range<usize>; 2] {
        let width = wrapped(to - from);
        let around = around + self.bent_rad;
        // The side of almost half a turn is uncertain. So it is for a segment seen from its end, but that is narrow.
        let is_told = width.abs() + 2.0 * around <= PI - 10.0 * MARGIN_RAD;
        if !is_told {
            return [self.rays.clone(), 0..0];
        }
        let margin = MARGIN_RAD + around;
        let (from, to) = if width >= 0.0 { (from, from + width) } else { (from + width, from) };
        self.fan.between(wrapped(from - margin), wrapped(to + margin))
    }

    fn meet(&mut self) {
        if self.waiting.is_empty() {
            return;
        }
        let forward = self.direction();
        let Self { fan, rays, bundle, range, .. } = self;
        let (fan, first, bundle, range) = (*fan, rays.start, *bundle, *range);
        let (candidates, distances) = (&self.waiting[..], &mut *self.distances);
        with_vectors(Meet { candidates, fan, first, forward, bundle, range, distances });
        self.waiting.clear();
    }
}

fn nearest_to_origin(a: Vector, b: Vector) -> Vector {
    let along = b - a;
    let (ahead, length_squared) = (-a.dot(&along), along.norm_squared());
    if ahead <= 0.0 {
        a
    } else if ahead >= length_squared {
        b
    } else {
        a + along * (ahead / length_squared)
    }
}

/// Rays are chosen with angles that are wrong by less than this.
const MARGIN_RAD: f64 = 1e-4;

/// A generous bound on the relative rounding errors here.
const ROUNDING: f64 = 1e-12;

/// A shape is close if its distance, as a part of its ends' and the origin's, is less than this: then rounding
/// matters to whether the origin is on it.
const CLOSE: f64 = 1e-9;

/// So few rays are tried one by one.
const FEW_RAYS: usize = 8;

/// The number of segments that are tried at once.
const AT_ONCE: usize = 64;

/// The number of shapes that are compared with the rays at once.
const MOST_WAITING: usize = 32;
