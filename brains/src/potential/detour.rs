//! The way round what a field locks at.

use baudbot_geometry::Point;

use super::behavior::distance;
use super::terrain::{Path, Terrain};

/// A path that is driven.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Detour {
    path: Path,
    /// The point of the path at which the robot is.
    reached: usize,
    look_ahead_m: f64,
}

impl Detour {
    /// A `Detour` at the start of a path, for a body of this radius.
    pub(super) fn new(path: Path, radius_m: f64) -> Self {
        Self { path, reached: 0, look_ahead_m: LOOK_AHEAD * radius_m }
    }

    /// All other ways are closed, as far as the map has them.
    pub(super) fn is_forced(&self) -> bool {
        self.path.is_forced
    }

    /// The point to drive at, a little farther along the path than the robot is.
    pub(super) fn next(&mut self, here: Point) -> Point {
        let points = &self.path.points;
        let near = |i: &usize| distance(points[*i], here);
        // The target may not skip to a later part of the path that passes near by.
        let window = self.reached..points.len().min(self.reached + WINDOW);
        self.reached = window.min_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(self.reached);
        let later = points[self.reached..].iter().find(|at| distance(**at, here) >= self.look_ahead_m);
        later.or_else(|| points.last()).copied().unwrap_or(here)
    }

    /// The rest of the path.
    pub(super) fn left(&self) -> &[Point] {
        &self.path.points[self.reached..]
    }

    /// The distance of the robot from its path, in metres.
    pub(super) fn strayed_m(&self, here: Point) -> f64 {
        self.left().first().map_or(f64::INFINITY, |at| distance(*at, here))
    }

    /// Another way instead, if that is much better by what is known now.
    pub(super) fn reconsider(&mut self, path: Path, terrain: &Terrain) {
        let mut old = terrain.price(self.left());
        if self.left().iter().any(|at| terrain.is_closed(*at)) {
            old *= 2.0;
        }
        if terrain.price(&path.points) < BETTER * old {
            *self = Self { path, reached: 0, look_ahead_m: self.look_ahead_m };
        }
    }
}

/// The distance on the way at which it aims, in radii of the body.
const LOOK_AHEAD: f64 = 0.75;
/// Points of the path among which the nearest is looked for.
const WINDOW: usize = 12;
/// A new path must cost less than this part of the old one.
const BETTER: f64 = 0.8;
