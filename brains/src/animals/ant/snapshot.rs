//! Matching a snapshot of the landmarks about the nest.
//!
//! The notes say that the ant matches what it sees to what it remembers, and not how. This is the average landmark
//! vector (Lambrinos, Möller, Labhart, Pfeifer and Wehner 2000), the simplest way that needs to tell no landmark
//! from another: the mean of the unit vectors to all of them, along the axes of the compass. Its difference from
//! the remembered one points about homewards: an ant that has gone to the right sees all landmarks further to the left.

use baudbot_geometry::{Direction, Vector};

/// A view in the memory of an ant: the mean of the unit vectors to all landmarks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    average: Vector,
}

impl Snapshot {
    /// The view of an animal that looks along `heading_rad` by the compass, and sees landmarks at these bearings, in
    /// radians to the left of that. Without landmarks it is zero.
    pub fn take(heading_rad: f64, landmarks_rad: &[f64]) -> Self {
        let unit = |bearing_rad: &f64| Direction::from_angle(heading_rad + bearing_rad).vector();
        let sum: Vector = landmarks_rad.iter().map(unit).sum();
        Self { average: sum / landmarks_rad.len().max(1) as f64 }
    }

    /// A vector about along the way from the place of this view to that of the other one. Its length is the difference
    /// of the views, and not the length of the way.
    pub fn displacement_to(&self, other: &Self) -> Vector {
        self.average - other.average
    }

    /// The difference between two views, from 0 to 2.
    pub fn mismatch(&self, other: &Self) -> f64 {
        self.displacement_to(other).norm()
    }
}

#[cfg(test)]
mod tests {
    use baudbot_geometry::{Point, math};

    use super::*;

    const LANDMARKS: [(f64, f64); 4] = [(1.5, 0.2), (-0.4, 1.3), (-1.2, -0.9), (0.8, -1.6)];

    /// The bearings of landmarks by the compass, as seen from a place.
    fn bearings(from: Point, landmarks: &[(f64, f64)]) -> Vec<f64> {
        landmarks.iter().map(|&(x, y)| math::atan2(y - from.y, x - from.x)).collect()
    }

    /// The end of the way of an ant that follows the difference from the view at the origin.
    fn end(start: Point, landmarks: &[(f64, f64)]) -> Point {
        let home = Snapshot::take(0.0, &bearings(Point::origin(), &LANDMARKS));
        let mut place = start;
        for _ in 0..2000 {
            let seen = Snapshot::take(0.0, &bearings(place, landmarks));
            if seen.mismatch(&home) > 1e-3 {
                place += seen.displacement_to(&home).normalize() * 0.005;
            }
        }
        place
    }

    #[test]
    fn it_leads_home_from_wherever_it_was_displaced_to() {
        for i in 0..49 {
            let start = Point::new(0.3 * f64::from(i % 7) - 0.9, 0.3 * f64::from(i / 7) - 0.9);
            let end = end(start, &LANDMARKS);
            assert!(end.coords.norm() < 0.02, "from {start} to {end}");
        }
    }

    #[test]
    fn who_moves_the_landmarks_moves_where_it_searches() {
        let moved = LANDMARKS.map(|(x, y)| (x + 0.5, y - 0.3));
        let end = end(Point::new(-0.4, 0.4), &moved);
        assert!((end - Point::new(0.5, -0.3)).norm() < 0.02, "{end}");
    }

    #[test]
    fn turning_on_the_spot_changes_no_view() {
        let straight = Snapshot::take(0.0, &bearings(Point::origin(), &LANDMARKS));
        let turned: Vec<_> =
            bearings(Point::origin(), &LANDMARKS).iter().map(|bearing| bearing - 1.1).collect();
        assert!(Snapshot::take(1.1, &turned).mismatch(&straight) < 1e-15);
        assert_eq!(Snapshot::take(0.3, &[]).mismatch(&Snapshot::take(0.0, &[])), 0.0);
    }
}
