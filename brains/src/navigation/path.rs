//! Straight pieces one after the other.

use baudbot_geometry::{Point, Segment, angle, math};

/// A path, on which a place is known by its distance from the beginning along the path, in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    points: Vec<Point>,
    /// The distance of each point from the first, in metres.
    along_m: Vec<f64>,
}

impl Path {
    /// The path from point to point. Points that are the same as the one before are left out.
    pub fn new(mut points: Vec<Point>) -> Self {
        points.dedup();
        let mut along_m: Vec<f64> = Vec::with_capacity(points.len());
        for (i, point) in points.iter().enumerate() {
            let before = i.checked_sub(1).map(|i| along_m[i] + (point - points[i]).norm());
            along_m.push(before.unwrap_or(0.0));
        }
        Self { points, along_m }
    }

    /// The bends, and both ends.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The length, in metres.
    pub fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    /// The place so far along; beyond an end that end, `None` if the path has no point.
    pub fn at(&self, along_m: f64) -> Option<Point> {
        let after = self.along_m.partition_point(|m| *m <= along_m);
        let before = after.saturating_sub(1);
        let from = *self.points.get(before)?;
        let Some(to) = self.points.get(after) else { return Some(from) };
        let part = (along_m - self.along_m[before]) / (self.along_m[after] - self.along_m[before]);
        Some(from + (to - from) * part.max(0.0))
    }

    /// The nearest place to a point, from `from_m` to `until_m`: its distance along the path, and from the point. Of
    /// equally near ones the first.
    pub fn nearest(&self, point: Point, from_m: f64, until_m: f64) -> (f64, f64) {
        let mut best = (from_m, f64::INFINITY);
        for (i, ends) in self.points.windows(2).enumerate() {
            let (least_m, most_m) = (self.along_m[i].max(from_m), self.along_m[i + 1].min(until_m));
            if least_m > most_m {
                continue;
            }
            let foot = Segment { start: ends[0], end: ends[1] }.nearest_point(point);
            let along_m = (self.along_m[i] + (foot - ends[0]).norm()).clamp(least_m, most_m);
            let away_m = self.at(along_m).map_or(f64::INFINITY, |place| (point - place).norm());
            if away_m < best.1 {
                best = (along_m, away_m);
            }
        }
        if best.1.is_infinite() {
            best.1 = self.at(from_m).map_or(f64::INFINITY, |place| (point - place).norm());
        }
        best
    }

    /// The rest of it from there on.
    pub fn rest(&self, from_m: f64) -> impl Iterator<Item = Point> + '_ {
        let after = self.along_m.partition_point(|m| *m <= from_m);
        self.at(from_m).into_iter().chain(self.points.iter().skip(after).copied())
    }

    /// The same in parts, each of which ends where the path turns by more than so many radians.
    pub fn wheels(&self, turn_rad: f64) -> Vec<Self> {
        let heading = |from: Point, to: Point| math::atan2(to.y - from.y, to.x - from.x);
        let mut wheels = Vec::new();
        let mut leg: Vec<Point> = self.points.iter().take(2).copied().collect();
        for ends in self.points.windows(3) {
            let turn = angle::difference(heading(ends[1], ends[2]), heading(ends[0], ends[1]));
            if turn.abs() > turn_rad {
                wheels.push(Self::new(std::mem::replace(&mut leg, vec![ends[1]])));
            }
            leg.push(ends[2]);
        }
        wheels.push(Self::new(leg));
        wheels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path() -> Path {
        Path::new([(0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0, 1.0), (3.0, 2.0)].map(Point::from_xy).to_vec())
    }

    trait FromXy {
        fn from_xy(xy: (f64, f64)) -> Self;
    }

    impl FromXy for Point {
        fn from_xy((x, y): (f64, f64)) -> Self {
            Self::new(x, y)
        }
    }

    #[test]
    fn places_are_known_by_their_distance_along_it() {
        let path = path();
        assert!((path.length_m() - (3.0 + 2.0_f64.sqrt())).abs() < 1e-12);
        for (along_m, place) in
            [(-1.0, (0.0, 0.0)), (0.5, (0.5, 0.0)), (2.25, (2.0, 0.25)), (9.0, (3.0, 2.0))]
        {
            assert_eq!(path.at(along_m), Some(Point::from_xy(place)), "{along_m}");
        }
        assert_eq!(Path::new(Vec::new()).at(0.0), None);
        let rest: Vec<_> = path.rest(2.25).collect();
        assert_eq!(rest, [(2.0, 0.25), (2.0, 1.0), (3.0, 2.0)].map(Point::from_xy));
    }

    #[test]
    fn the_nearest_place_is_sought_within_bounds() {
        let path = path();
        assert_eq!(path.nearest(Point::new(1.0, 0.5), 0.0, 9.0), (1.0, 0.5));
        assert_eq!(path.nearest(Point::new(1.0, 0.5), 1.5, 9.0).0, 1.5);
        assert_eq!(path.nearest(Point::new(3.0, 2.0), 0.0, 1.0).0, 1.0);
        assert_eq!(path.nearest(Point::new(2.0, 3.0), 9.0, 10.0).0, 9.0);
    }

    #[test]
    fn legs_end_at_sharp_bends() {
        let wheels = path().wheels(1.0);
        assert_eq!(wheels.iter().map(|leg| leg.points().len()).collect::<Vec<_>>(), [2, 3]);
        assert_eq!(wheels[0].points()[1], wheels[1].points()[0]);
        assert_eq!(path().wheels(2.0), [path()]);
        assert_eq!(path().wheels(0.1).len(), 3);
    }
}
