//! The scan of a laser range finder. [`localization`](crate::localization) matches scans; scans with poses make
//! [maps](crate::mapping).
//!
//! *Deviations.* The notes set a distance to −1 if nothing was within range (§6.3.1). On the wire it is so; here it is
//! infinite, so that it is farther than any other. NaN is the distance of a ray of which nothing is known.

use baudbot_brain::{Reading, Sensor, SensorKind};
use baudbot_geometry::Pose;

/// The distances along equally spaced rays, from right to left.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// The laser's pose on its robot.
    pub robot_from_laser: Pose,
    /// Angle from the first ray to the last, in radians.
    pub opening_rad: f64,
    /// The laser's range, in metres.
    pub range_m: f64,
    /// In metres: positive, infinite if nothing was within range, NaN if that is not known.
    pub distances_m: Vec<f64>,
}

impl Scan {
    /// A reading of a `laser` with level rays that does not sit on a turret; `None` of anything else, or if its data sheet does not
    /// state how wide it opens.
    #[must_use]
    pub fn of(sensor: &Sensor, reading: &Reading) -> Option<Self> {
        let (range_m, mount, opening_rad) = (sensor.range_m?, sensor.mount?, sensor.opening_rad?);
        if sensor.kind != SensorKind::Laser
            || !mount.is_fixed_and_level()
            || reading.values.len() != sensor.values()
        {
            return None;
        }
        let mut distances_m: Vec<_> = reading.values.iter().map(|&value| distance(value, range_m)).collect();
        if sensor.sweep.is_some_and(|sweep| sweep.clockwise) {
            distances_m.reverse();
        }
        let robot_from_laser = Pose::new(mount.x_m, mount.y_m, mount.heading_rad);
        let scan = Self { robot_from_laser, opening_rad, range_m, distances_m };
        (!scan.distances_m.is_empty()).then_some(scan)
    }

    /// The angle from one ray to the next, in radians; 0 of a single ray. Eq. (3.11).
    #[must_use]
    pub fn spacing_rad(&self) -> f64 {
        self.opening_rad / (self.distances_m.len().max(2) - 1) as f64
    }

    /// The angle of ray `i` to the laser's forward direction, in radians; Wahde 2016, Eq. (3.14). One ray alone looks
    /// ahead.
    #[must_use]
    pub fn bearing_rad(&self, i: usize) -> f64 {
        let is_alone = self.distances_m.len() < 2;
        if is_alone { 0.0 } else { i as f64 * self.spacing_rad() - 0.5 * self.opening_rad }
    }

    /// About so many of its rays, every so many, from the middle of the scan: matching takes less time with fewer,
    /// and is seldom worse. All of them if there are not that many.
    #[must_use]
    pub fn thinned(&self, rays: usize) -> Self {
        let every = (self.distances_m.len() / rays.max(1)).max(1);
        let last = self.distances_m.len().saturating_sub(1);
        let (gaps, spare) = (last / every, last % every);
        let distances_m: Vec<_> =
            self.distances_m.iter().skip(spare / 2).step_by(every).take(gaps + 1).copied().collect();
        // An odd number of rays to spare moves the middle by half a ray to the right.
        let aside = if spare % 2 == 1 { -0.5 * self.spacing_rad() } else { 0.0 };
        let mut robot_from_laser = self.robot_from_laser;
        robot_from_laser.heading += aside;
        let opening_rad = self.spacing_rad() * (gaps * every) as f64;
        Self { robot_from_laser, opening_rad, range_m: self.range_m, distances_m }
    }
}

/// The meaning of a value on the wire. 0, which would be inside of the laser, is no distance to divide by.
fn distance(value: f64, range_m: f64) -> f64 {
    if value.is_nan() {
        f64::NAN
    } else if 0.0 < value && value <= range_m {
        value
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use baudbot_brain::Sweep;

    use super::*;
    use crate::test_body::{body, turn};

    /// A scan of a laser that opens by 3 rad.
    fn scan_of(values: &[f64], clockwise: bool) -> Option<Scan> {
        let mut body = body(&[("urg", "laser", 0.25)]);
        body.sensors[0].range_m = Some(4.0);
        body.sensors[0].opening_rad = Some(3.0);
        body.sensors[0].sweep = Some(Sweep { duration_ns: 100_000_000, clockwise });
        body.sensors[0].components[0].count = 4;
        let turn = turn(&body, 0, &[Some(values)]);
        Scan::of(&body.sensors[0], turn.reading("urg").unwrap())
    }

    #[test]
    fn minus_one_is_nothing_within_range() {
        let scan = scan_of(&[1.0, -1.0, 4.0, 0.0], false).unwrap();
        assert_eq!(scan.distances_m, [1.0, f64::INFINITY, 4.0, f64::INFINITY]);
        assert_eq!((scan.range_m, scan.robot_from_laser.heading), (4.0, 0.25));
        assert_eq!(scan.spacing_rad(), 1.0);
        assert!(scan_of(&[1.0, f64::NAN, 1.0, 1.0], false).unwrap().distances_m[1].is_nan());
    }

    #[test]
    fn a_clockwise_sweep_is_turned_around() {
        let scan = scan_of(&[1.0, 2.0, 3.0, -1.0], true).unwrap();
        assert_eq!(scan.distances_m, [f64::INFINITY, 3.0, 2.0, 1.0]);
        assert_eq!(scan.opening_rad, 3.0);
    }

    #[test]
    fn only_whole_readings_of_lasers_are_scans() {
        assert_eq!(scan_of(&[1.0, 2.0], false), None);
        let body = body(&[("sonar", "sonar", 0.0)]);
        let turn = turn(&body, 0, &[Some(&[1.0])]);
        assert_eq!(Scan::of(&body.sensors[0], turn.reading("sonar").unwrap()), None);
    }

    #[test]
    fn thinned_rays_keep_their_directions() {
        for rays in 1..40_u32 {
            // Each distance is its own direction, so that it can be recognised.
            let directions: Vec<_> =
                (0..rays).map(|i| 10.0 + 0.1 * f64::from(i) - 0.05 * f64::from(rays - 1)).collect();
            let scan = Scan {
                robot_from_laser: Pose::new(0.0, 0.0, 10.0),
                opening_rad: 0.1 * f64::from(rays - 1),
                range_m: 99.0,
                distances_m: directions,
            };
            for wanted in [1, 2, 3, 7, 100] {
                let thin = scan.thinned(wanted);
                let least = wanted.min(scan.distances_m.len());
                assert!(
                    thin.distances_m.len() >= least && thin.distances_m.len() < 2 * least + 1,
                    "{rays} {wanted}"
                );
                for (i, found) in thin.distances_m.iter().enumerate() {
                    let kappa = i as f64 * thin.spacing_rad() - 0.5 * thin.opening_rad;
                    let direction = thin.robot_from_laser.heading + kappa;
                    assert!(
                        (found - direction).abs() < 1e-12,
                        "{rays} {wanted} {i}: {found} is not {direction}"
                    );
                }
            }
        }
    }
}
