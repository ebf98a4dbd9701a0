//! A scan that was taken while the robot moved, as if it had been taken at one instant.
//!
//! A laser turns: between its first ray and its last the robot goes on. At 0.3 m/s and 0.8 rad/s a sweep of 100 ms is
//! off by up to 3 cm and 0.08 rad. The notes stop the robot (Wahde 2016, §6.3.1, point i); here each ray's end is put
//! where it was seen from, by the odometry, and viewed from where the robot was at the one instant.
//!
//! Seen from there the ends are no longer at the angles of the fan. Between two neighbours on one surface the distance at
//! an angle of the fan is found by interpolation of 1/distance, which is nearly straight along a wall; between
//! neighbours on two surfaces it is that of the nearer angle. At the side that the robot has turned away from some rays
//! are lost: nothing is known of them.

use std::ops::Range;

use baudbot_geometry::{Direction, Pose, angle, math};

use crate::scan::Scan;

/// The times of the rays of a scan, evenly one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sweep {
    /// The instant of the first ray, the rightmost, in nanoseconds.
    pub right_ns: u64,
    /// The instant of the last ray, the leftmost, in nanoseconds; before the first one's if the laser sweeps clockwise.
    pub left_ns: u64,
}

impl Sweep {
    /// The instant of a ray, as a part of the way from the first to the last.
    pub(super) fn at_ns(&self, part: f64) -> u64 {
        let span = self.left_ns.abs_diff(self.right_ns);
        let gone = math::round(span as f64 * part) as u64;
        if self.left_ns >= self.right_ns { self.right_ns + gone } else { self.right_ns - gone }
    }
}

/// The end of a ray, as seen from the one place.
#[derive(Clone, Copy)]
struct End {
    bearing: f64,
    distance: f64,
}

/// The scan as if it had been taken at `at_ns`, by the poses at earlier instants, world from robot; for these
/// [`Track::pose_at`](crate::odometry::Track::pose_at) is made. `None` if one of these is not known.
#[must_use]
pub fn deskew(
    scan: &Scan,
    sweep: Sweep,
    at_ns: u64,
    mut pose_at: impl FnMut(u64) -> Option<Pose>,
) -> Option<Scan> {
    let laser_from_world = pose_at(at_ns)?.compose(&scan.robot_from_laser).inverse();
    let facing = laser_from_world.direction();
    let last = scan.distances_m.len().saturating_sub(1);
    let spacing = scan.spacing_rad();
    let mut ends = Vec::with_capacity(scan.distances_m.len());
    for (i, distance) in scan.distances_m.iter().enumerate() {
        let world_from_robot = pose_at(sweep.at_ns(i as f64 / last.max(1) as f64))?;
        let world_from_laser = world_from_robot.compose(&scan.robot_from_laser);
        let then = laser_from_world.compose_facing(facing, &world_from_laser);
        ends.push(end(&then, scan.bearing_rad(i), *distance, scan.range_m));
    }
    let mut distances_m = vec![f64::NAN; scan.distances_m.len()];
    if let [only] = ends.as_slice() {
        distances_m[0] = only.distance;
    }
    for pair in ends.windows(2) {
        // The places in the fan between the two, and hardly beside them.
        let place = |end: &End| (end.bearing + 0.5 * scan.opening_rad) / spacing;
        for i in between(place(&pair[0]) - SLACK, place(&pair[1]) + SLACK, last) {
            let distance = at_bearing(pair[0], pair[1], scan.bearing_rad(i));
            distances_m[i] = if distance > scan.range_m { f64::INFINITY } else { distance };
        }
    }
    Some(Scan { distances_m, ..scan.clone() })
}

/// The end of the ray as it is seen if the laser then had this pose in its frame of the one instant. A ray that saw
/// nothing is one that ends at the range, but has no distance.
fn end(one_from_then: &Pose, kappa: f64, distance: f64, range_m: f64) -> End {
    let length = if distance.is_finite() { distance } else { range_m };
    let along = one_from_then.direction().rotate(Direction::from_angle(kappa));
    let place = one_from_then.position.coords + along.vector() * length;
    let bearing = kappa + angle::difference(math::atan2(place.y, place.x), kappa);
    let seen = math::hypot(place.x, place.y);
    End { bearing, distance: if distance.is_finite() { seen } else { distance } }
}

/// The distance at a bearing between those of two ends, or hardly beside them.
fn at_bearing(a: End, b: End, bearing: f64) -> f64 {
    let part = ((bearing - a.bearing) / (b.bearing - a.bearing)).clamp(0.0, 1.0);
    let is_one_surface = (a.distance - b.distance).abs() < JUMP * a.distance.min(b.distance);
    if is_one_surface {
        return 1.0 / ((1.0 - part) / a.distance + part / b.distance);
    }
    if part < 0.5 { a.distance } else { b.distance }
}

/// The whole numbers between two numbers, from 0 to `last`; none if they are in the wrong order.
fn between(from: f64, to: f64, last: usize) -> Range<usize> {
    // The conversions take what is below 0 to 0.
    math::ceil(from) as usize..((math::floor(to) + 1.0) as usize).min(last + 1)
}

/// Neighbours whose distances differ by more than this part are on two surfaces.
const JUMP: f64 = 0.1;

/// The number of rays beside the ends within which an end still counts.
const SLACK: f64 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Chance;
    use crate::estimate::Estimate;
    use crate::localization::laser::matching_error;
    use crate::localization::refine::{Parameters, refine};
    use crate::localization::test_arena::{error, free_pose, office, quantile, swept, urg};
    use crate::odometry::{self, Odometry};

    const SWEEP: Sweep = Sweep { right_ns: 1_000_000_000, left_ns: 1_100_000_000 };

    /// A robot at 0.3 m/s and 0.8 rad/s, that was at this pose in the middle of the sweep.
    fn moving(middle: Pose) -> impl Fn(u64) -> Option<Pose> {
        move |at_ns| {
            let seconds = (at_ns as f64 - 1.05e9) * 1e-9;
            let (way, turn) = (0.3 * seconds, 0.8 * seconds);
            Some(middle.compose(&Pose::new(way * (0.5 * turn).cos(), way * (0.5 * turn).sin(), turn)))
        }
    }

    #[test]
    fn a_robot_at_rest_has_nothing_to_mend() {
        let (map, laser, pose) = (office(), urg(171), Pose::new(6.0, 5.0, 0.4));
        let scan = laser.scan(&map, &pose);
        let found = deskew(&scan, SWEEP, 7, |_| Some(pose)).unwrap();
        for (i, (found, expected)) in found.distances_m.iter().zip(&scan.distances_m).enumerate() {
            assert!(found == expected || (found - expected).abs() < 1e-9, "{i}: {found} {expected}");
        }
    }

    #[test]
    fn a_moving_robots_scan_becomes_that_of_one_instant() {
        let (map, laser, mut chance) = (office(), urg(171), Chance::new(1, "deskew"));
        let (mut raw, mut mended) = (vec![], vec![]);
        for _ in 0..30 {
            let middle = free_pose(&map, &mut chance);
            let scan = swept(&laser, &map, SWEEP, moving(middle));
            let start = moving(middle)(SWEEP.right_ns).unwrap();
            let expected = laser.scan(&map, &start);
            raw.push(matching_error(&scan.distances_m, &expected.distances_m));
            let scan = deskew(&scan, SWEEP, SWEEP.right_ns, moving(middle)).unwrap();
            mended.push(matching_error(&scan.distances_m, &expected.distances_m));
            let known = scan.distances_m.iter().filter(|distance| !distance.is_nan()).count();
            assert!(known >= 165, "{known}");
        }
        let [raw, mended] = [raw, mended].map(|errors| quantile(&errors, 0.5));
        assert!(raw > 0.03 && mended < 0.15 * raw, "{raw} {mended}");
    }

    #[test]
    fn what_is_matched_while_moving_is_where_the_robot_was() {
        let (map, laser, mut chance) = (office(), urg(171), Chance::new(2, "deskew"));
        let (mut raw, mut mended) = (vec![], vec![]);
        for _ in 0..20 {
            let middle = free_pose(&map, &mut chance);
            let scan = swept(&laser, &map, SWEEP, moving(middle));
            let truth = moving(middle)(SWEEP.left_ns).unwrap();
            let guess = Estimate::within(truth, 0.1, 0.1);
            let mut find = |scan: &Scan| {
                let found = refine(&map, scan, &guess, &Parameters::default(), &mut chance);
                error(&found.estimate.world_from_robot, &truth)
            };
            raw.push(find(&scan));
            mended.push(find(&deskew(&scan, SWEEP, SWEEP.left_ns, moving(middle)).unwrap()));
        }
        let median = |errors: &[(f64, f64)]| {
            let (m, rad): (Vec<_>, Vec<_>) = errors.iter().copied().unzip();
            (quantile(&m, 0.5), quantile(&rad, 0.5))
        };
        let (raw, mended) = (median(&raw), median(&mended));
        assert!(raw.0 > 0.01 && raw.1 > 0.02, "{raw:?}");
        assert!(mended.0 < 0.002 && mended.1 < 0.001, "{mended:?}");
    }

    #[test]
    fn a_clockwise_sweep_goes_the_other_way() {
        let (map, laser, middle) = (office(), urg(171), Pose::new(6.0, 5.0, 0.4));
        let clockwise = Sweep { right_ns: SWEEP.left_ns, left_ns: SWEEP.right_ns };
        let scan = swept(&laser, &map, clockwise, moving(middle));
        let expected = laser.scan(&map, &middle).distances_m;
        let error = |sweep| {
            let found = deskew(&scan, sweep, 1_050_000_000, moving(middle)).unwrap();
            matching_error(&found.distances_m, &expected)
        };
        assert!(error(clockwise) < 0.2 * error(SWEEP), "{} {}", error(clockwise), error(SWEEP));
    }

    #[test]
    fn the_odometry_says_where_the_robot_was_at_each_ray() {
        let (map, laser, middle) = (office(), urg(171), Pose::new(6.0, 5.0, 0.4));
        let scan = swept(&laser, &map, SWEEP, moving(middle));
        let parameters = odometry::Parameters {
            half_track_m: 0.17,
            m_per_count: [1e-4; 2],
            modulus: None,
            variance_m2_per_m: 1e-4,
            past_ns: 10_000_000_000,
            calibration: odometry::Calibration::NONE,
        };
        let start = moving(middle)(900_000_000).unwrap();
        let mut odometry = Odometry::new(parameters, 900_000_000, Estimate::exact(start));
        for i in 0..=15_u32 {
            let seconds = 0.02 * f64::from(i);
            let counts = [-1.0, 1.0].map(|side| (1e4 * seconds * (0.3 + side * 0.17 * 0.8)).floor());
            odometry.encoders(900_000_000 + 20_000_000 * u64::from(i), counts);
        }
        let pose_at = |at_ns| odometry.at(at_ns).map(|estimate| estimate.world_from_robot);
        let found = deskew(&scan, SWEEP, 1_050_000_000, pose_at).unwrap();
        let expected = laser.scan(&map, &middle).distances_m;
        let off = |scan: &Scan| {
            let deviations = scan
                .distances_m
                .iter()
                .zip(&expected)
                .map(|(found, expected)| (found / expected - 1.0).abs());
            deviations.filter(|deviation| *deviation > 0.002).count()
        };
        // A ray beside the edge of a door may still see what is behind it.
        assert!(off(&found) <= 2 && off(&scan) > 60, "{} {}", off(&found), off(&scan));
        assert_eq!(deskew(&scan, SWEEP, 800_000_000, pose_at), None, "before all that is known");
    }

    #[test]
    fn nothing_and_unknown_stay_so() {
        let mut scan = urg(11).scan(&office(), &Pose::new(6.0, 5.0, 0.4));
        scan.distances_m.fill(1.0);
        (scan.distances_m[3], scan.distances_m[8]) = (f64::INFINITY, f64::NAN);
        let found = deskew(&scan, SWEEP, 0, |_| Some(Pose::new(1.0, 2.0, 3.0))).unwrap();
        assert_eq!(found.distances_m[3], f64::INFINITY);
        assert!(found.distances_m[8].is_nan() && (found.distances_m[7] - 1.0).abs() < 1e-9);
        scan.distances_m.truncate(1);
        let found = deskew(&scan, SWEEP, 0, |_| Some(Pose::new(1.0, 2.0, 3.0))).unwrap();
        assert!((found.distances_m[0] - 1.0).abs() < 1e-12);
    }
}
