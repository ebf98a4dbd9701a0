//! The distances of a shape along several rays: the loops that vectors are made of.

use core::iter::repeat;
use core::ops::Range;

use crate::math;
use crate::pose::{Direction, Point, Vector};
use crate::ray::Ray;
use crate::segment::Segment;

/// A shape as seen from a point, in the axes of the world.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Relative {
    Segment(Vector, Vector),
    Circle(Vector, f64),
}

/// Rays side by side.
#[derive(Clone, Copy)]
pub(super) struct Rays<'a, O> {
    /// Where they start, from where shapes are seen.
    pub(super) origins: O,
    pub(super) cos: &'a [f64],
    pub(super) sin: &'a [f64],
}

/// Where rays start.
pub(super) trait Origins: Copy {
    /// Those of some of the rays.
    fn part(self, places: Range<usize>) -> Self;

    /// One after the other.
    fn each(self) -> impl Iterator<Item = Vector>;
}

/// All where shapes are seen from.
#[derive(Clone, Copy)]
pub(super) struct Here;

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
pub(super) struct Apart<'a> {
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
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
    pub(super) fn part(&self, places: Range<usize>) -> Self {
        Self {
            origins: self.origins.part(places.clone()),
            cos: &self.cos[places.clone()],
            sin: &self.sin[places],
        }
    }
}

/// Holds a shape against some rays.
#[inline(always)]
pub(super) fn meet<O: Origins>(shape: &Relative, rays: Rays<'_, O>, range: f64, distances: &mut [f64]) {
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

/// For so few rays vectors are no gain.
const FEW: usize = 8;
