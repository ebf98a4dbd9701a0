//! The scene that sensors look at: the arena and all robots, their poses frozen at the start of the tick.

use baudbot_geometry::{Circle, Point, Ray};

use crate::arena::Arena;

/// The frozen scene as one robot sees it.
pub(crate) struct Scene<'a> {
    pub(crate) arena: &'a Arena,
    /// The bodies of all robots.
    pub(crate) bodies: &'a [Circle],
    /// The robot that looks: its own body hides nothing from it.
    pub(crate) own: usize,
}

impl<'a> Scene<'a> {
    /// A look from `from` as far as `range_m`.
    pub(crate) fn look(&'a self, from: Point, range_m: f64) -> Look<'a> {
        let reach = |body: &Circle| {
            let far = range_m + body.radius;
            (body.center - from).norm_squared() <= far * far
        };
        // One robot in sight is common, a crowd is not: remember the span of those that can be hit.
        let mut others = self.bodies.iter().enumerate().filter(|(i, body)| *i != self.own && reach(body));
        let first = others.next().map(|(i, _)| i);
        let last = others.next_back().map(|(i, _)| i).or(first);
        let span = first.zip(last).map_or(0..0, |(first, last)| first..last + 1);
        Look { scene: self, range_m, span }
    }
}

/// A look from one point.
pub(crate) struct Look<'a> {
    scene: &'a Scene<'a>,
    range_m: f64,
    /// Robots outside this span are out of reach.
    span: core::ops::Range<usize>,
}

impl Look<'_> {
    /// Distance to the nearest thing along `ray`, if within range.
    pub(crate) fn cast(&self, ray: &Ray) -> Option<f64> {
        let mut nearest = self.scene.arena.index().cast(ray, self.range_m).map(|hit| hit.distance);
        for i in self.span.clone().filter(|&i| i != self.scene.own) {
            if let Some(d) = ray.hit_circle(&self.scene.bodies[i])
                && d <= self.range_m
                && nearest.is_none_or(|best| d < best)
            {
                nearest = Some(d);
            }
        }
        nearest
    }
}
