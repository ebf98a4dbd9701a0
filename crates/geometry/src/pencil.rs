//! A few rays from one point, each shape tried with all of them at once.
//!
//! The distances are those of [`Ray::hit_segment`] and [`Ray::hit_circle`] to the last bit: the loops here do the same operations,
//! for all rays and without branches, so that a compiler can make vectors of them. What is rare is left to those functions.

use core::array::from_fn;

use crate::circle::Circle;
use crate::math;
use crate::pose::{Direction, Point};
use crate::ray::Ray;
use crate::segment::Segment;

/// Up to [`RAYS`](Self::RAYS) rays, and how far each runs before it meets one of the shapes that were added.
#[derive(Clone, Copy, Debug)]
pub struct Pencil {
    origin: Point,
    /// Places that are left repeat the last ray.
    cos: [f64; Self::RAYS],
    sin: [f64; Self::RAYS],
    range: f64,
    distances: [f64; Self::RAYS],
}

impl Pencil {
    /// The most rays.
    pub const RAYS: usize = 4;

    /// The rays of a sensor at `origin` that looks `forward`, both in the world, in these directions relative to that; others
    /// than the first [`RAYS`](Self::RAYS) are left out. What is farther than `range`, in metres, is not met.
    ///
    /// # Panics
    ///
    /// If there are no rays.
    #[inline]
    #[must_use]
    pub fn new(origin: Point, forward: Direction, relative: &[Direction], range: f64) -> Self {
        let relative: [Direction; Self::RAYS] = from_fn(|i| relative[i.min(relative.len() - 1)]);
        let directions = relative.map(|relative| forward.rotate(relative));
        let (cos, sin) =
            (directions.map(|direction| direction.cos), directions.map(|direction| direction.sin));
        Self { origin, cos, sin, range, distances: [f64::INFINITY; Self::RAYS] }
    }

    /// The length of each ray, in metres, or infinity; places that are left repeat the last one.
    #[inline]
    #[must_use]
    pub fn distances(&self) -> &[f64; Self::RAYS] {
        &self.distances
    }

    /// One more segment that may be in the way.
    #[inline]
    pub fn segment(&mut self, segment: &Segment) {
        let (a, b) = (segment.start - self.origin, segment.end - self.origin);
        let (mut is_behind, mut is_unknown) = (false, false);
        for ((nearest, cos), sin) in self.distances.iter_mut().zip(self.cos).zip(self.sin) {
            let (ax, ay) = (cos * a.x + sin * a.y, cos * a.y - sin * a.x);
            let (bx, by) = (cos * b.x + sin * b.y, cos * b.y - sin * b.x);
            let a_is_nearer = ay.abs() <= by.abs();
            let (near_x, near_y) = if a_is_nearer { (ax, ay) } else { (bx, by) };
            let (far_x, far_y) = if a_is_nearer { (bx, by) } else { (ax, ay) };
            let distance = near_x + (far_x - near_x) * (near_y / (near_y - far_y)) + 0.0;
            let misses = ((ay > 0.0) & (by > 0.0)) | ((ay < 0.0) & (by < 0.0));
            let hits = !misses & (distance >= 0.0) & (distance <= self.range) & (distance < *nearest);
            *nearest = if hits { distance } else { *nearest };
            is_behind |= !misses & (distance < 0.0);
            is_unknown |= !misses & distance.is_nan();
        }
        if is_unknown || (is_behind && is_close(self.origin, segment)) {
            self.other(|ray| ray.hit_segment(segment));
        }
    }

    /// One more disc that may be in the way.
    #[inline]
    pub fn circle(&mut self, circle: &Circle) {
        if circle.contains(self.origin) {
            return self.other(|ray| ray.hit_circle(circle));
        }
        let (center, radius) = (circle.center - self.origin, circle.radius);
        for ((nearest, cos), sin) in self.distances.iter_mut().zip(self.cos).zip(self.sin) {
            let ahead = cos * center.x + sin * center.y;
            let aside = (cos * center.y - sin * center.x).abs();
            let half_chord = math::sqrt((radius - aside) * (radius + aside));
            let distance = ahead - half_chord;
            let distance = if distance > 0.0 { distance } else { 0.0 };
            let hits = (ahead >= 0.0) & (aside <= radius) & (distance <= self.range) & (distance < *nearest);
            *nearest = if hits { distance } else { *nearest };
        }
    }

    /// One more shape, with the function `hit` for its distance on a ray.
    pub fn other(&mut self, hit: impl Fn(&Ray) -> Option<f64>) {
        for ((nearest, cos), sin) in self.distances.iter_mut().zip(self.cos).zip(self.sin) {
            if let Some(distance) = hit(&Ray { origin: self.origin, direction: Direction { cos, sin } })
                && distance <= self.range
                && distance < *nearest
            {
                *nearest = distance;
            }
        }
    }
}

/// Whether the point may be on the segment, up to rounding.
fn is_close(point: Point, segment: &Segment) -> bool {
    let reach = [point, segment.start, segment.end].iter().map(|point| point.coords.abs().sum()).sum::<f64>();
    let close = CLOSE * reach;
    // Not (>), so that a NaN is close.
    let is_apart = segment.distance_squared(point) > close * close;
    !is_apart
}

/// Far above the rounding errors of [`Ray::hit_segment`], as a part of coordinates.
const CLOSE: f64 = 1e-9;
