//! A laser's scan, and where it was taken.

use baudbot_geometry::{Direction, Point, Pose, Segment, angle, math};

use crate::scan::Scan;

/// A scan, and the pose at which it is believed to have been taken.
///
/// All rays count as taken at once: [`Scanner`](crate::scanner::Scanner) sees to that.
#[derive(Clone, Debug)]
pub struct PlacedScan {
    world_from_robot: Pose,
    scan: Scan,
    /// The ends of rays, and whether they met something there.
    ends: Vec<(Point, bool)>,
}

impl PartialEq for PlacedScan {
    /// Rays of which nothing is known are no numbers, which differ from themselves; so the ends of the others are compared.
    fn eq(&self, other: &Self) -> bool {
        (self.world_from_robot, &self.ends) == (other.world_from_robot, &other.ends)
    }
}

/// A scan's view of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// Nothing that was seen is in the way.
    Clear,
    /// Something is in the way.
    Blocked,
    /// The path leads out of the sensor's opening angle, or farther than its range.
    Unseen,
}

impl PlacedScan {
    /// A scan that was taken at this pose of the robot.
    #[must_use]
    pub fn new(world_from_robot: Pose, scan: Scan) -> Self {
        let world_from_laser = world_from_robot.compose(&scan.robot_from_laser);
        let forward = world_from_laser.direction();
        let known = scan.distances_m.iter().enumerate().filter(|(_, distance_m)| !distance_m.is_nan());
        let ends = known.map(|(i, distance_m)| {
            let direction = forward.rotate(Direction::from_angle(scan.bearing_rad(i)));
            let end = world_from_laser.position + direction.vector() * distance_m.min(scan.range_m);
            (end, *distance_m <= scan.range_m)
        });
        let ends = ends.collect();
        Self { world_from_robot, scan, ends }
    }

    /// The robot's pose when the scan was taken.
    #[must_use]
    pub fn world_from_robot(&self) -> Pose {
        self.world_from_robot
    }

    /// The scan from there.
    #[must_use]
    pub fn scan(&self) -> &Scan {
        &self.scan
    }

    /// The laser's pose when the scan was taken.
    #[must_use]
    pub fn world_from_laser(&self) -> Pose {
        self.world_from_robot.compose(&self.scan.robot_from_laser)
    }

    /// The end of each ray in the world, and whether it met something there. A ray that met nothing ends at the
    /// range; one of which nothing is known has no end.
    pub fn ends(&self) -> impl Iterator<Item = (Point, bool)> {
        self.ends.iter().copied()
    }

    /// Whether it was taken from about here: within so many metres, and 0.1 rad.
    #[must_use]
    pub fn is_from(&self, world_from_robot: &Pose, within_m: f64) -> bool {
        let turned = angle::difference(self.world_from_robot.heading, world_from_robot.heading);
        let moved = (self.world_from_robot.position - world_from_robot.position).norm();
        moved <= within_m && turned.abs() <= HERE_RAD
    }

    /// Whether a disc of radius `half_width_m` can go from where the robot was straight to the point `to`, as far as
    /// the scan shows. What is behind the robot is in no way.
    #[must_use]
    pub fn view(&self, to: Point, half_width_m: f64) -> View {
        let path = Segment { start: self.world_from_robot.position, end: to };
        let along = path.end - path.start;
        let in_way = |point: Point| {
            (point - path.start).dot(&along) > 0.0
                && path.distance_squared(point) < half_width_m * half_width_m
        };
        if self.ends().any(|(end, met)| met && in_way(end)) {
            return View::Blocked;
        }
        let world_from_laser = self.world_from_laser();
        let to_target = to - world_from_laser.position;
        let bearing = angle::difference(math::atan2(to_target.y, to_target.x), world_from_laser.heading);
        let half_rad = 0.5 * self.scan.opening_rad - SIDE_RAD;
        let seen = bearing.abs() <= half_rad && to_target.norm() <= self.scan.range_m;
        if seen { View::Clear } else { View::Unseen }
    }
}

/// A scan counts as taken here if the robot has turned less than this, in radians.
const HERE_RAD: f64 = 0.1;

/// So far within the opening angle a path must lead, in radians, that what is beside it is seen too.
const SIDE_RAD: f64 = 0.2;

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    /// Five rays over half a turn, from (1, 2), looking up.
    fn scan(distances_m: [f64; 5]) -> PlacedScan {
        PlacedScan::new(
            Pose::new(1.0, 2.0, FRAC_PI_2),
            Scan {
                robot_from_laser: Pose::new(0.0, 0.0, 0.0),
                opening_rad: PI,
                range_m: 4.0,
                distances_m: distances_m.to_vec(),
            },
        )
    }

    #[test]
    fn a_scan_is_the_same_as_itself_also_where_rays_are_not_known() {
        let of = |distances_m| scan(distances_m);
        assert_eq!(of([f64::NAN, 1.0, 2.0, 3.0, 4.0]), of([f64::NAN, 1.0, 2.0, 3.0, 4.0]));
        assert_ne!(of([f64::NAN, 1.0, 2.0, 3.0, 4.0]), of([1.0, f64::NAN, 2.0, 3.0, 4.0]));
        assert_ne!(of([1.0; 5]), of([1.0, 1.0, 1.0, 1.0, 1.5]));
    }

    #[test]
    fn rays_run_from_right_to_left_and_end_where_they_met_something() {
        let ends: Vec<_> = scan([0.5, f64::INFINITY, 3.0, f64::INFINITY, 1.0]).ends().collect();
        let expected = [(1.5, 2.0, true), (1.0 + 8_f64.sqrt(), 2.0 + 8_f64.sqrt(), false), (1.0, 5.0, true)];
        for ((end, met), (x, y, expected)) in ends.iter().zip(expected) {
            assert!((end - Point::new(x, y)).norm() < 1e-12, "{end} is not ({x}, {y})");
            assert_eq!(*met, expected);
        }
        assert!(!ends[3].1, "beyond the range is nothing");
    }

    #[test]
    fn a_way_is_clear_blocked_or_unseen() {
        let scan = scan([0.5, f64::INFINITY, 2.0, f64::INFINITY, 0.5]);
        assert_eq!(scan.view(Point::new(1.0, 3.5), 0.25), View::Clear);
        assert_eq!(scan.view(Point::new(1.0, 3.8), 0.25), View::Blocked, "too near to what is behind it");
        assert_eq!(scan.view(Point::new(1.0, 3.5), 0.6), View::Blocked, "too wide between the sides");
        assert_eq!(scan.view(Point::new(1.0, 1.0), 0.25), View::Unseen, "behind");
    }

    #[test]
    fn a_scan_is_from_here_until_the_robot_has_gone_on() {
        let scan = scan([1.0; 5]);
        assert!(scan.is_from(&Pose::new(1.04, 2.0, FRAC_PI_2 - 0.09), 0.05));
        assert!(!scan.is_from(&Pose::new(1.06, 2.0, FRAC_PI_2), 0.05));
        assert!(!scan.is_from(&Pose::new(1.0, 2.0, FRAC_PI_2 + 0.11), 0.05));
    }
}
