//! The places of new nodes: Wahde 2016, §6.1, Fig. 6.1. 6.1.
//!
//! A scan's rays that run farther than D + Δ lie in feasible angular intervals. One whose width γ is at least
//! `γ_min` gets a node in its middle, at the distance D. A wider one gets
//!
//! ```text
//! m = 1 + floor((γ - γ_min) / max(2 asin(d / 2D), γ_min))
//! ```
//!
//! nodes, of which the outermost are `γ_min` / 2 within its ends and the others evenly between them, so that no two
//! of them are nearer to each other than d.
//!
//! *Deviations.* The notes leave open how many nodes an interval gets, and where: the formula is ours. An interval
//! is as wide as the angle from its first ray to its last.

use baudbot_geometry::{Direction, Point, math};

use crate::mapping::PlacedScan;
use crate::scan::Scan;

/// The lengths and the angle of Fig. 6.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The distance from the robot at which nodes are placed, D, in metres.
    pub distance_m: f64,
    /// The least room behind a node, Δ, in metres.
    pub margin_m: f64,
    /// Width that a feasible interval must have, `γ_min`, in radians. The robot fits if 2 D sin(`γ_min` / 2) is wider
    /// than it.
    pub width_rad: f64,
    /// The least distance between nodes, d, in metres.
    pub separation_m: f64,
}

/// The angles, to a sensor's forward direction and in radians, between which all rays run far enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The right end.
    pub from_rad: f64,
    /// The left end, not below the right one.
    pub to_rad: f64,
}

/// The least `γ_min` with which a robot fits that takes passages of this width, at the distance D, in radians: that of a gap
/// there.
pub(super) fn width_rad(passage_m: f64, distance_m: f64) -> f64 {
    2.0 * math::atan2(0.5 * passage_m, distance_m)
}

/// The place in the world of an echo of the laser.
fn place(scan: &PlacedScan, bearing_rad: f64, distance_m: f64) -> Point {
    let world_from_laser = scan.world_from_laser();
    let direction = world_from_laser.direction().rotate(Direction::from_angle(bearing_rad));
    world_from_laser.position + direction.vector() * distance_m
}

impl Placement {
    /// The feasible angular intervals of a scan, from right to left, however narrow.
    #[must_use]
    pub fn intervals(&self, scan: &Scan) -> Vec<Interval> {
        let enough_m = self.distance_m + self.margin_m;
        let is_feasible = |i: &usize| scan.distances_m[*i] > enough_m;
        let rays: Vec<usize> = (0..scan.distances_m.len()).filter(is_feasible).collect();
        let runs = rays.chunk_by(|a, b| a + 1 == *b);
        runs.map(|run| Interval {
            from_rad: scan.bearing_rad(run[0]),
            to_rad: scan.bearing_rad(run[run.len() - 1]),
        })
        .collect()
    }

    /// The directions of nodes in an interval, to the sensor's forward direction, in radians.
    #[must_use]
    pub fn directions(&self, interval: &Interval) -> Vec<f64> {
        let spare_rad = interval.to_rad - interval.from_rad - self.width_rad;
        if spare_rad < 0.0 {
            return Vec::new();
        }
        let gaps = math::floor(spare_rad / self.spacing_rad());
        if gaps == 0.0 {
            return vec![0.5 * (interval.from_rad + interval.to_rad)];
        }
        let first_rad = interval.from_rad + 0.5 * self.width_rad;
        (0..=gaps as usize).map(|i| first_rad + i as f64 * spare_rad / gaps).collect()
    }

    /// The places in the world at which a scan allows nodes. Other nodes may be too near.
    #[must_use]
    pub fn places(&self, scan: &PlacedScan) -> Vec<Point> {
        let intervals = self.intervals(scan.scan());
        let bearings_rad = intervals.iter().flat_map(|interval| self.directions(interval));
        bearings_rad.map(|bearing_rad| place(scan, bearing_rad, self.distance_m)).collect()
    }

    /// Least angle between two nodes of an interval, in radians: max(2 asin(d / 2D), `γ_min`).
    fn spacing_rad(&self) -> f64 {
        let half_chord = 0.5 * self.separation_m / self.distance_m;
        let beside = math::sqrt((1.0 - half_chord * half_chord).max(0.0));
        (2.0 * math::atan2(half_chord, beside)).max(self.width_rad)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use baudbot_geometry::Pose;

    use super::*;

    const PLACEMENT: Placement =
        Placement { distance_m: 1.0, margin_m: 0.4, width_rad: 0.6, separation_m: 0.75 };

    /// Half a turn with a ray each degree, whose length is `distance_m` of its angle in degrees, from the right.
    fn scan(distance_m: impl Fn(usize) -> f64) -> PlacedScan {
        scan_of((0..=180).map(distance_m).collect())
    }

    fn scan_of(distances_m: Vec<f64>) -> PlacedScan {
        let robot_from_laser = Pose::new(0.0, 0.0, 0.0);
        let scan = Scan { robot_from_laser, opening_rad: PI, range_m: 4.0, distances_m };
        PlacedScan::new(Pose::new(2.0, 3.0, 0.5 * PI), scan)
    }

    /// The figure: two feasible intervals, of which one is wide enough for two nodes.
    fn figure() -> PlacedScan {
        scan(|degree| match degree {
            20..=60 => 2.0,
            90..=180 => f64::INFINITY,
            _ => 1.3,
        })
    }

    /// The two intervals of Fig. 6.1.
    #[test]
    fn the_figures_intervals_get_one_node_and_two() {
        let intervals = PLACEMENT.intervals(figure().scan());
        let degrees =
            |i: &Interval| [i.from_rad, i.to_rad].map(|angle: f64| angle.to_degrees().round() + 90.0);
        assert_eq!(intervals.iter().map(degrees).collect::<Vec<_>>(), [[20.0, 60.0], [90.0, 180.0]]);
        let nodes = intervals.iter().map(|interval| PLACEMENT.directions(interval).len());
        assert_eq!(nodes.collect::<Vec<_>>(), [1, 2]);
        let places = PLACEMENT.places(&figure());
        // The middle of the interval is 40 degrees from the right, and the robot's heading is along y.
        let angle = 40_f64.to_radians();
        assert!(
            (places[0] - Point::new(2.0 + angle.cos(), 3.0 + angle.sin())).norm() < 1e-9,
            "{}",
            places[0]
        );
    }

    #[test]
    fn an_interval_below_the_least_width_gets_none() {
        let width = |degrees: f64| Interval { from_rad: -1.0, to_rad: -1.0 + degrees.to_radians() };
        assert!(PLACEMENT.directions(&width(34.0)).is_empty());
        assert_eq!(PLACEMENT.directions(&width(35.0)).len(), 1, "0.6 rad are 34.4 degrees");
    }

    #[test]
    fn nodes_of_an_interval_are_never_nearer_to_each_other_than_allowed() {
        for d in [0.3, 0.6, 0.75, 1.0] {
            let placement = Placement { separation_m: d, ..PLACEMENT };
            for degrees in 0..360 {
                let interval = Interval { from_rad: 0.0, to_rad: f64::from(degrees).to_radians() };
                let directions = placement.directions(&interval);
                for pair in directions.windows(2) {
                    let chord = 2.0 * (0.5 * (pair[1] - pair[0])).sin();
                    assert!(chord >= d - 1e-12, "{chord} < {d} at {degrees} degrees");
                }
                let outer = directions.first().zip(directions.last());
                if let Some((first, last)) = outer {
                    assert!(*first >= 0.3 - 1e-12 && *last <= interval.to_rad - 0.3 + 1e-12);
                }
            }
        }
    }

    #[test]
    fn no_rays_and_no_room_place_nothing() {
        assert_eq!(PLACEMENT.places(&scan(|_| 1.4)), [], "1.4 is not beyond 1.4");
        assert_eq!(PLACEMENT.places(&scan_of(vec![])), []);
    }
}
