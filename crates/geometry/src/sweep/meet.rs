//! The distances of a shape along several rays: the loops that vectors are made of.

use core::iter::repeat;
use core::ops::Range;

use crate::carried::Bundle;
use crate::fan::Fan;
use crate::math;
use crate::pose::{Direction, Point, Vector};
use crate::ray::Ray;
use crate::segment::Segment;
use crate::vectors::Work;

/// A shape as seen from a point, in the axes of the world.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Relative {
    Segment(Vector, Vector),
    Circle(Vector, f64),
}

/// A shape within range that is yet to be tried with the rays.
#[derive(Clone)]
pub(super) struct Candidate {
    pub(super) shape: Relative,
    /// The rays that may meet it.
    pub(super) spans: [Range<usize>; 2],
}

/// Holds many rays, of which the first is at this place in the fan, against all that waits.
pub(super) struct Meet<'a> {
    pub(super) candidates: &'a [Candidate],
    pub(super) fan: &'a Fan,
    pub(super) first: usize,
    /// The direction of the fan's middle.
    pub(super) forward: Direction,
    /// The rays themselves, if each has its own origin.
    pub(super) bundle: Option<&'a Bundle<'a>>,
    pub(super) range: f64,
    pub(super) distances: &'a mut [f64],
}

impl Work for Meet<'_> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        let Some(bundle) = self.bundle else { return self.in_parts::<MANY_RAYS>() };
        let [x, y, cos, sin] = bundle.columns();
        let rays = Rays { origins: Apart { x, y }, cos, sin };
        meet_all(self.candidates, rays, self.range, self.first, self.distances);
    }
}

impl Meet<'_> {
    /// Takes so many rays at a time, whose directions are then at hand for all shapes.
    #[inline(always)]
    fn in_parts<const N: usize>(self) {
        let (mut cos, mut sin) = ([1.0; N], [0.0; N]);
        let mut first = self.first;
        for distances in self.distances.chunks_mut(N) {
            let part = first..first + distances.len();
            let relative = &self.fan.relative()[part.clone()];
            for ((cos, sin), relative) in cos.iter_mut().zip(&mut sin).zip(relative) {
                Direction { cos: *cos, sin: *sin } = self.forward.rotate(*relative);
            }
            let rays = Rays { origins: Here, cos: &cos, sin: &sin };
            meet_all(self.candidates, rays, self.range, part.start, distances);
            first = part.end;
        }
    }
}

/// Holds rays, of which the first is at this place in the fan, against all candidates.
#[inline(always)]
fn meet_all<O: Origins>(
    candidates: &[Candidate],
    rays: Rays<'_, O>,
    range: f64,
    first: usize,
    distances: &mut [f64],
) {
    let end = first + distances.len();
    for candidate in candidates {
        for span in &candidate.spans {
            let places = span.start.max(first)..span.end.min(end);
            if !places.is_empty() {
                let places = places.start - first..places.end - first;
                meet(&candidate.shape, rays.part(places.clone()), range, &mut distances[places]);
            }
        }
    }
}

/// Rays side by side.
#[derive(Clone, Copy)]
struct Rays<'a, O> {
    /// The starts of the rays, from which shapes are seen.
    origins: O,
    cos: &'a [f64],
    sin: &'a [f64],
}

/// The starts of a fan's rays.
trait Origins: Copy {
    /// The origins of some of the rays.
    fn part(self, places: Range<usize>) -> Self;

    /// One after the other.
    fn each(self) -> impl Iterator<Item = Vector>;
}

/// All where shapes are seen from.
#[derive(Clone, Copy)]
struct Here;

impl Origins for Here {
    #[inline(always)]
    fn part(self, _: Range<usize>) -> Self {
        self
    }

    #[inline(always)]
    fn each(self) -> impl Iterator<Item = Vector> {
        repeat(Vector::new(0.0, 0.0))
    }
}

/// Each at a place of its own.
#[derive(Clone, Copy)]
struct Apart<'a> {
    x: &'a [f64],
    y: &'a [f64],
}

impl Origins for Apart<'_> {
    #[inline(always)]
    fn part(self, places: Range<usize>) -> Self {
        Self { x: &self.x[places.clone()], y: &self.y[places] }
    }

    #[inline(always)]
    fn each(self) -> impl Iterator<Item = Vector> {
        self.x.iter().zip(self.y).map(|(&x, &y)| Vector::new(x, y))
    }
}

impl<O: Origins> Rays<'_, O> {
    #[inline(always)]
    fn part(&self, places: Range<usize>) -> Self {
        Self {
            origins: self.origins.part(places.clone()),
            cos: &self.cos[places.clone()],
            sin: &self.sin[places],
        }
    }
}

/// Holds a shape against some rays.
#[inline(always)]
fn meet<O: Origins>(shape: &Relative, rays: Rays<'_, O>, range: f64, distances: &mut [f64]) {
    match *shape {
        // Vectors do not pay: most rays miss, which is soon found out.
        Relative::Segment(a, b) if distances.len() <= FEW => {
            meet_one_by_one(a, b, rays, range, distances);
        }
        Relative::Segment(a, b) => meet_segment(a, b, rays, range, distances),
        Relative::Circle(center, radius) => meet_circle(center, radius, rays, range, distances),
    }
}

/// [`Ray::hit_segment`], operation for operation, of a segment that the origin is not close to.
#[inline(always)]
fn meet_segment<O: Origins>(a: Vector, b: Vector, rays: Rays<'_, O>, range: f64, distances: &mut [f64]) {
    let mut coincide = false;
    for (((nearest, cos), sin), origin) in
        distances.iter_mut().zip(rays.cos).zip(rays.sin).zip(rays.origins.each())
    {
        let (a, b) = (a - origin, b - origin);
        let (ax, ay) = (cos * a.x + sin * a.y, cos * a.y - sin * a.x);
        let (bx, by) = (cos * b.x + sin * b.y, cos * b.y - sin * b.x);
        let a_is_nearer = ay.abs() <= by.abs();
        let (near_x, near_y) = if a_is_nearer { (ax, ay) } else { (bx, by) };
        let (far_x, far_y) = if a_is_nearer { (bx, by) } else { (ax, ay) };
        let distance = near_x + (far_x - near_x) * (near_y / (near_y - far_y)) + 0.0;
        let misses = ((ay > 0.0) & (by > 0.0)) | ((ay < 0.0) & (by < 0.0));
        let hits = !misses & (distance >= 0.0) & (distance <= range) & (distance < *nearest);
        *nearest = if hits { distance } else { *nearest };
        coincide |= (ay == 0.0) & (by == 0.0);
    }
    if coincide {
        meet_one_by_one(a, b, rays, range, distances);
    }
}

/// [`Ray::hit_segment`] itself: for rays that run along the segment, and for a few.
fn meet_one_by_one<O: Origins>(a: Vector, b: Vector, rays: Rays<'_, O>, range: f64, distances: &mut [f64]) {
    let segment = Segment { start: Point::from(a), end: Point::from(b) };
    for (((nearest, &cos), &sin), origin) in
        distances.iter_mut().zip(rays.cos).zip(rays.sin).zip(rays.origins.each())
    {
        let ray = Ray { origin: Point::from(origin), direction: Direction { cos, sin } };
        if let Some(distance) = ray.hit_segment(&segment)
            && distance <= range
            && distance < *nearest
        {
            *nearest = distance;
        }
    }
}

/// [`Ray::hit_circle`], operation for operation, of a circle that the origin is outside of.
#[inline(always)]
fn meet_circle<O: Origins>(
    center: Vector,
    radius: f64,
    rays: Rays<'_, O>,
    range: f64,
    distances: &mut [f64],
) {
    for (((nearest, cos), sin), origin) in
        distances.iter_mut().zip(rays.cos).zip(rays.sin).zip(rays.origins.each())
    {
        let center = center - origin;
        let ahead = cos * center.x + sin * center.y;
        let aside = (cos * center.y - sin * center.x).abs();
        let half_chord = math::sqrt((radius - aside) * (radius + aside));
        let distance = ahead - half_chord;
        let distance = if distance > 0.0 { distance } else { 0.0 };
        let hits = (ahead >= 0.0) & (aside <= radius) & (distance <= range) & (distance < *nearest);
        *nearest = if hits { distance } else { *nearest };
    }
}

/// The number of rays up to which vectors are no gain.
const FEW: usize = 8;

/// The number of rays whose directions are computed at once.
const MANY_RAYS: usize = 128;
