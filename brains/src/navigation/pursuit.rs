//! Pure pursuit: which point of a path to drive at. Coulter 1992 (CMU-RI-TR-92-01).
//!
//! It is the point that is one look-ahead distance farther along than the place of the path that is nearest. The helm drives
//! at it on a circle: [`Helm::pursue`](crate::steering::Helm::pursue).
//!
//! *Deviation*: that circle cuts corners, by up to a third of the look-ahead distance. Therefore the point comes nearer until
//! a body may go there in a straight line, down to a quarter of the distance; near a corner the circle is tighter then, and
//! the robot slower.

use baudbot_geometry::Point;

use super::path::Path;

/// A path that is being followed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pursuit {
    path: Path,
    look_ahead_m: f64,
    along_m: f64,
}

impl Pursuit {
    /// A `Pursuit` at the beginning of a path, with a look-ahead distance in metres.
    pub fn new(path: Path, look_ahead_m: f64) -> Self {
        Self { path, look_ahead_m, along_m: 0.0 }
    }

    /// Takes in where the robot is, and returns how far that is from the path, in metres. It goes on along the path, and never
    /// back.
    pub fn advance(&mut self, here: Point) -> f64 {
        let until_m = self.along_m + 2.0 * self.look_ahead_m;
        let (along_m, aside_m) = self.path.nearest(here, self.along_m, until_m);
        self.along_m = along_m;
        aside_m
    }

    /// The length of the path that is left, in metres.
    pub fn left_m(&self) -> f64 {
        self.path.length_m() - self.along_m
    }

    /// The rest of the path.
    pub fn rest(&self) -> impl Iterator<Item = Point> + '_ {
        self.path.rest(self.along_m)
    }

    /// The point to drive at, the farthest one that is clear; `None` if the path has no point.
    pub fn target(&self, is_clear: impl Fn(Point) -> bool) -> Option<Point> {
        let ahead = |part: f64| self.path.at(self.along_m + part * self.look_ahead_m);
        let parts = (2..=STEPS).rev().map(|i| f64::from(i) / f64::from(STEPS));
        parts.filter_map(ahead).find(|&point| is_clear(point)).or_else(|| ahead(2.0 / f64::from(STEPS)))
    }
}

/// The look-ahead distance is shortened in this many steps.
const STEPS: u32 = 8;

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Pursuit {
        let points = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)].map(|(x, y)| Point::new(x, y));
        Pursuit::new(Path::new(points.to_vec()), 0.8)
    }

    #[test]
    fn it_drives_at_the_point_that_is_a_look_ahead_farther_along() {
        let mut pursuit = corner();
        assert_eq!(pursuit.advance(Point::new(1.0, 0.25)), 0.25);
        assert_eq!(pursuit.target(|_| true), Some(Point::new(1.8, 0.0)));
        assert_eq!(pursuit.left_m(), 3.0);
        assert_eq!(pursuit.advance(Point::new(0.5, 0.0)), 0.5, "never back");
        pursuit.advance(Point::new(2.0, 1.0));
        pursuit.advance(Point::new(2.0, 1.9));
        assert_eq!(pursuit.target(|_| true), Some(Point::new(2.0, 2.0)), "no farther than the end");
        assert_eq!(pursuit.rest().count(), 2);
    }

    #[test]
    fn before_a_corner_that_must_not_be_cut_it_looks_less_far_ahead() {
        let mut pursuit = corner();
        pursuit.advance(Point::new(1.5, 0.0));
        let target = pursuit.target(|point| point.y == 0.0).unwrap();
        assert!((target.x - 2.0).abs() < 1e-9 && target.y == 0.0, "{target}");
        let target = pursuit.target(|_| false).unwrap();
        assert!((target.x - 1.7).abs() < 1e-9, "a quarter: {target}");
    }
}
