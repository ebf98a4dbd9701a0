//! The distance that a ray runs before it meets a shape: Wahde, Eqs. (3.3) to (3.8).
//!
//! *Deviations.* The numbers are those of the equations, but they are found in another way.
//!
//! - The ends of the segment are first expressed in the frame of the ray: x ahead along it, y to its left.
//!   The ray's line meets the segment if the two y differ in sign, or if one is zero. Each end's sign is
//!   computed from that end and the ray only. Two walls that share a corner therefore share its sign, and
//!   no ray slips between them; with `u` of Eq. (3.7) computed for each wall, rounding can put it just
//!   outside of [0, 1] for both.
//! - The distance, `t` of Eq. (3.6) times the range, is then interpolated between the two x. The division
//!   is by a sum of numbers of equal sign, so no digits are lost in it, and nearly parallel lines need no
//!   special care.
//! - Lines that coincide, which the equations leave open, are met at the nearer end, or at once if the ray
//!   starts between the ends.
//! - A ray has no range of its own; the caller compares the distance with the sensor's.

use serde::{Deserialize, Serialize};

use crate::circle::Circle;
use crate::math;
use crate::pose::{Direction, Point};
use crate::segment::Segment;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ray {
    /// The start, in metres.
    pub origin: Point,
    /// The unit vector along the ray.
    pub direction: Direction,
}

impl Ray {
    /// The distance, in metres, from the origin to the segment along the ray; `None` if they do not meet.
    ///
    /// It is 0 if the origin lies on the segment, wherever the ray points. "On" means up to rounding: from a
    /// place a few roundings behind the wall the crossing would be computed as behind the origin too, and a
    /// robot that leans on a wall would look through it. (3.6)–(3.8) in another way (see above).
    #[inline]
    #[must_use]
    pub fn hit_segment(&self, segment: &Segment) -> Option<f64> {
        let start = self.ray_from_world(segment.start);
        let end = self.ray_from_world(segment.end);
        if (start.y > 0.0 && end.y > 0.0) || (start.y < 0.0 && end.y < 0.0) {
            return None;
        }
        let distance =
            if start.y == 0.0 && end.y == 0.0 { along(start.x, end.x) } else { across(start, end) };
        if distance >= 0.0 {
            return Some(distance + 0.0); // so that a negative zero becomes a positive one
        }
        let reach = self.origin.coords.abs().sum() + start.coords.abs().sum() + end.coords.abs().sum();
        let rounding = ROUNDING * reach;
        let segment_in_ray = Segment { start, end };
        let on_segment = segment_in_ray.distance_squared(Point::origin()) <= rounding * rounding;
        on_segment.then_some(0.0)
    }

    /// The distance, in metres, from the origin to the solid disc along the ray; `None` if they do not meet.
    ///
    /// It is 0 if the origin is strictly inside. A ray that starts on the rim meets the disc, at 0, unless
    /// it points away. A ray that only touches the rim meets it.
    #[inline]
    #[must_use]
    pub fn hit_circle(&self, circle: &Circle) -> Option<f64> {
        if circle.contains(self.origin) {
            return Some(0.0);
        }
        let center = self.ray_from_world(circle.center);
        let aside = center.y.abs();
        // Not (x < 0), so that a NaN ends here.
        let meets = center.x >= 0.0 && aside <= circle.radius;
        if !meets {
            return None;
        }
        let half_chord = math::sqrt((circle.radius - aside) * (circle.radius + aside));
        let distance = center.x - half_chord;
        // The origin is not inside, so only rounding can have made this negative.
        Some(if distance > 0.0 { distance } else { 0.0 })
    }

    /// The point at a distance, in metres, along the ray. Eq. (3.3).
    #[must_use]
    pub fn at(&self, distance: f64) -> Point {
        self.origin + self.direction.vector() * distance
    }

    /// The point as seen along the ray: x metres ahead of the origin, and y metres to the left.
    #[inline]
    fn ray_from_world(&self, point: Point) -> Point {
        Point::from(self.direction.inverse().apply(point - self.origin))
    }
}

/// The distance to a segment on the ray's own line, given how far ahead its ends are.
fn along(start: f64, end: f64) -> f64 {
    let (near, far) = if start <= end { (start, end) } else { (end, start) };
    if near < 0.0 && far >= 0.0 {
        0.0
    } else if near >= 0.0 {
        near
    } else {
        far
    }
}

/// The point in which a segment with an end on either side crosses the ray's line.
///
/// Interpolated from the end that is nearer to the line: if the line runs through a corner, the result is
/// then how far ahead the corner is, with the same bits for all segments that share it.
fn across(start: Point, end: Point) -> f64 {
    let (near, far) = if start.y.abs() <= end.y.abs() { (start, end) } else { (end, start) };
    near.x + (far.x - near.x) * (near.y / (near.y - far.y))
}

/// The relative error of a point in the ray's frame is at most three roundings a coordinate; this leaves
/// room for as many again, and for the roundings that put the origin where it is.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use super::*;

    fn ray(x: f64, y: f64, angle_rad: f64) -> Ray {
        Ray { origin: Point::new(x, y), direction: Direction::from_angle(angle_rad) }
    }

    fn segment(x0: f64, y0: f64, x1: f64, y1: f64) -> Segment {
        Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) }
    }

    /// Eqs. (3.3), (3.6), (3.7) and (3.8), as they are printed.
    fn by_the_book(ray: &Ray, segment: &Segment, range: f64) -> Option<f64> {
        let (a1, b1) = (ray.origin, ray.at(range));
        let (a2, b2) = (segment.start, segment.end);
        let divisor = (b2.y - a2.y) * (b1.x - a1.x) - (b2.x - a2.x) * (b1.y - a1.y);
        let t = ((b2.x - a2.x) * (a1.y - a2.y) - (b2.y - a2.y) * (a1.x - a2.x)) / divisor;
        let u = ((b1.x - a1.x) * (a1.y - a2.y) - (b1.y - a1.y) * (a1.x - a2.x)) / divisor;
        let both = (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u);
        both.then(|| (t * (b1 - a1)).norm())
    }

    /// (3.3), (3.6)–(3.8), as printed, beside the routine for one ray.
    #[test]
    fn agrees_with_the_equations() {
        let wall = segment(1.3, -0.7, 0.9, 1.1);
        let mut hits = 0;
        for i in 0..100 {
            let ray = ray(0.1, 0.2, f64::from(i) * 0.0628);
            let (ours, book) = (ray.hit_segment(&wall), by_the_book(&ray, &wall, 4.0));
            assert_eq!(ours.is_some(), book.is_some());
            if let (Some(ours), Some(book)) = (ours, book) {
                assert!((ours - book).abs() < 1e-13);
                hits += 1;
            }
        }
        assert!(hits > 10);
    }

    #[test]
    fn walls_ahead_behind_and_aside() {
        assert_eq!(ray(0.0, 0.0, 0.0).hit_segment(&segment(2.0, -1.0, 2.0, 1.0)), Some(2.0));
        assert_eq!(ray(0.0, 0.0, 0.0).hit_segment(&segment(-2.0, -1.0, -2.0, 1.0)), None);
        assert_eq!(ray(0.0, 0.0, 0.0).hit_segment(&segment(0.0, 1.0, 9.0, 1.0)), None, "parallel");
        assert_eq!(ray(0.0, 0.0, 0.0).hit_segment(&segment(2.0, 0.0, 2.0, 1.0)), Some(2.0), "an end");
        assert_eq!(ray(0.0, 0.0, 0.0).hit_segment(&segment(0.0, -1.0, 0.0, 1.0)), Some(0.0), "on it");
    }

    #[test]
    fn coincident_walls() {
        let wall = segment(5.0, 0.0, 3.0, 0.0);
        assert_eq!(ray(1.0, 0.0, 0.0).hit_segment(&wall), Some(2.0));
        assert_eq!(ray(4.0, 0.0, 0.0).hit_segment(&wall), Some(0.0));
        assert_eq!(ray(5.0, 0.0, 0.0).hit_segment(&wall), Some(0.0));
        assert_eq!(ray(6.0, 0.0, 0.0).hit_segment(&wall), None);
        assert_eq!(ray(1.0, 0.0, 0.0).hit_segment(&segment(3.0, 0.0, 3.0, 0.0)), Some(2.0), "a point");
    }

    #[test]
    fn a_rounding_behind_the_wall_is_on_it() {
        let wall = segment(0.0, 1.0, 1.0, 0.0);
        let outward = ray(0.3, 0.7 + 1e-16, FRAC_PI_4);
        assert_eq!(outward.hit_segment(&wall), Some(0.0));
        assert_eq!(ray(0.3, 0.7 + 1e-9, FRAC_PI_4).hit_segment(&wall), None);
    }

    /// The roundings of a place are as large as its coordinates make them, however short the wall is.
    #[test]
    fn far_from_the_middle_of_the_arena_a_place_on_a_wall_is_on_it_too() {
        let wall =
            segment(-0.22425640153116194, -4.243607391135637, -0.10756736122549913, -4.245228882838492);
        let outward = Direction { cos: -0.7346350252042648, sin: -0.6784625116711529 };
        for part in 0..1000 {
            let origin = wall.start + (wall.end - wall.start) * (f64::from(part) / 1000.0);
            let distance = Ray { origin, direction: outward }.hit_segment(&wall);
            assert!(distance.is_some_and(|distance| distance < 1e-14), "{part} {distance:?}");
        }
    }

    #[test]
    fn walls_that_share_a_corner_share_its_distance() {
        let corner = Point::new(0.7, 0.31);
        let direction = Direction::from_angle(math::atan2(corner.y, corner.x));
        let through = Ray { origin: Point::origin(), direction };
        let upper = through.hit_segment(&Segment { start: corner, end: Point::new(0.2, 0.9) });
        let lower = through.hit_segment(&Segment { start: Point::new(0.9, -0.4), end: corner });
        assert!(upper.or(lower).is_some());
    }

    #[test]
    fn discs() {
        let disc = Circle { center: Point::new(3.0, 0.0), radius: 1.0 };
        assert_eq!(ray(0.0, 0.0, 0.0).hit_circle(&disc), Some(2.0));
        assert_eq!(ray(0.0, 0.0, PI).hit_circle(&disc), None);
        assert_eq!(ray(0.0, 1.0, 0.0).hit_circle(&disc), Some(3.0), "touching");
        assert_eq!(ray(0.0, 1.1, 0.0).hit_circle(&disc), None);
        assert_eq!(ray(2.5, 0.0, FRAC_PI_2).hit_circle(&disc), Some(0.0), "inside");
        assert_eq!(ray(2.0, 0.0, 0.0).hit_circle(&disc), Some(0.0), "on the rim, inwards");
        assert_eq!(ray(2.0, 0.0, PI).hit_circle(&disc), None, "on the rim, outwards");
    }

    #[test]
    fn nonsense_meets_nothing() {
        let nowhere = ray(f64::NAN, 0.0, 0.0);
        assert_eq!(nowhere.hit_segment(&segment(2.0, -1.0, 2.0, 1.0)), None);
        assert_eq!(nowhere.hit_circle(&Circle { center: Point::new(3.0, 0.0), radius: 1.0 }), None);
    }
}
