//! A body in the frozen scene, as rays meet it.

use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Ray, Segment, Vector, polygon};

use super::{Figure, Frozen, RayHit, What};
use crate::arena::{Height, Look};

impl Default for Figure {
    fn default() -> Self {
        let disc = Circle { center: Point::origin(), radius: 0.0 };
        Self { disc, outline: Vec::new(), look: Look::WALL }
    }
}

impl Frozen {
    /// Whether this body is the robot, or a part of it.
    #[inline]
    pub(crate) fn is_of(&self, body: usize, robot: usize) -> bool {
        body == robot || body >= self.first_part && self.is_part_of(body, robot)
    }

    /// Out of line, as few robots have parts.
    #[cold]
    #[inline(never)]
    fn is_part_of(&self, body: usize, robot: usize) -> bool {
        self.carriers.get(body - self.first_part) == Some(&robot)
    }

    /// Whether the ray met the robot.
    pub(crate) fn is_hit(&self, hit: &RayHit, robot: usize) -> bool {
        match hit.what {
            What::Fixed(_) => false,
            What::Figure(body) => self.is_of(body, robot),
        }
    }
}

impl Figure {
    /// Whether it reaches up to an eye at this height.
    pub(super) fn reaches(&self, height: Height) -> bool {
        self.look.is_at(height.above_floor_m)
    }

    /// The distance along `ray`, if the ray meets it.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<f64> {
        if self.outline.is_empty() {
            return ray.hit_circle(&self.disc);
        }
        ray.hit_circle(&self.disc)?;
        polygon::edges(&self.outline).filter_map(|edge| ray.hit_segment(&edge)).reduce(f64::min)
    }

    pub(super) fn normal_at(&self, at: Point) -> Vector {
        let nearest = polygon::edges(&self.outline)
            .min_by(|a, b| a.distance_squared(at).total_cmp(&b.distance_squared(at)));
        nearest.map_or(at - self.disc.center, |edge| normal_of(&edge))
    }
}

pub(super) fn normal_of(segment: &Segment) -> Vector {
    let along = segment.end - segment.start;
    Vector::new(-along.y, along.x)
}
