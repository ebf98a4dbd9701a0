//! The distances of a shape along several rays: the loops that vectors are made of.

use crate::math;
use crate::pose::{Direction, Point, Vector};
use crate::ray::Ray;
use crate::segment::Segment;

/// A shape as seen from the fan's origin, in the axes of the world.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Relative {
    Segment(Vector, Vector),
    Circle(Vector, f64),
}

/// Holds a shape against some rays.
#[inline(always)]
pub(super) fn meet(shape: &Relative, directions: (&[f64], &[f64]), range: f64, distances: &mut [f64]) {
    match *shape {
        // Vectors do not pay: most rays miss, which is soon found out.
        Relative::Segment(a, b) if distances.len() <= FEW => {
            meet_one_by_one(a, b, directions, range, distances);
        }
        Relative::Segment(a, b) => meet_segment(a, b, directions, range, distances),
        Relative::Circle(center, radius) => meet_circle(center, radius, directions, range, distances),
    }
}

/// [`Ray::hit_segment`], operation for operation, of a segment that the origin is not close to.
#[inline(always)]
fn meet_segment(a: Vector, b: Vector, (cos, sin): (&[f64], &[f64]), range: f64, distances: &mut [f64]) {
    let mut coincide = false;
    for ((nearest, cos), sin) in distances.iter_mut().zip(cos).zip(sin) {
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
        meet_one_by_one(a, b, (cos, sin), range, distances);
    }
}

/// [`Ray::hit_segment`] itself: for rays that run along the segment, and for a few.
fn meet_one_by_one(a: Vector, b: Vector, (cos, sin): (&[f64], &[f64]), range: f64, distances: &mut [f64]) {
    let segment = Segment { start: Point::from(a), end: Point::from(b) };
    for ((nearest, &cos), &sin) in distances.iter_mut().zip(cos).zip(sin) {
        let ray = Ray { origin: Point::origin(), direction: Direction { cos, sin } };
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
fn meet_circle(center: Vector, radius: f64, (cos, sin): (&[f64], &[f64]), range: f64, distances: &mut [f64]) {
    for ((nearest, cos), sin) in distances.iter_mut().zip(cos).zip(sin) {
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
