//! Walkers in front of the robot.
//!
//! An echo in a place that the map knows to be free, with nothing beside it, was not there a moment ago. What stays
//! there for three scans is in the map, and no walker any more.

use baudbot_geometry::{Point, Pose};

use crate::mapping::disc::Disc;
use crate::mapping::{Occupancy, PlacedScan};

/// The greatest speed at which a robot stops before a person who walks ahead of it can reach it, in metres a second;
/// infinite if there is none. The scan was taken so many seconds ago.
pub(super) fn safe_m_s(
    grid: &Occupancy,
    scan: &PlacedScan,
    here: &Pose,
    (radius_m, most_m_s): (f64, f64),
    age_s: f64,
) -> f64 {
    let walked_m = WALKER_M_S * (age_s + HALT_S);
    let reach_m = radius_m + walked_m + most_m_s * HALT_S;
    let ahead = here.direction().vector();
    let beside = Disc::new((BESIDE_M / grid.cell_m()).max(1.0));
    let is_near = |end: &Point| {
        let offset = end - here.position;
        offset.dot(&ahead) > 0.0 && offset.norm() < reach_m
    };
    let walks = |end: &Point| {
        let cell = grid.cell(*end);
        grid.log_odds(cell) <= SURE
            && grid.places(cell, &beside).flatten().all(|place| grid.is_free_at(place))
    };
    let ends = scan.ends().filter(|(_, met)| *met).map(|(end, _)| end);
    let safe_m_s = |end: Point| ((end - here.position).norm() - radius_m - walked_m) / HALT_S;
    ends.filter(is_near).filter(walks).map(safe_m_s).fold(f64::INFINITY, f64::min)
}

/// So fast people walk indoors, in metres a second.
const WALKER_M_S: f64 = 0.5;
/// The time from when something is seen until the robot has stopped for it, in seconds.
const HALT_S: f64 = 0.9;
/// So near to anything what is met may be that, by the laser's error and that of the pose, in metres.
const BESIDE_M: f64 = 0.05;
/// Log-odds of a cell of which it is sure that it was free: by three scans, and one that met something.
const SURE: f32 = -1.2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Scan;

    fn seen(distances_m: impl Fn(usize) -> f64) -> PlacedScan {
        let scan = Scan {
            robot_from_laser: Pose::new(0.0, 0.0, 0.0),
            opening_rad: 2.0,
            range_m: 4.0,
            distances_m: (0..201).map(distances_m).collect(),
        };
        PlacedScan::new(Pose::new(0.0, 0.0, 0.0), scan)
    }

    /// A wall ahead is known; then a person steps in between, and stays.
    #[test]
    fn who_comes_walks_and_what_stays_stands() {
        let mut grid = Occupancy::new(0.025);
        let here = Pose::new(0.0, 0.0, 0.0);
        let safe = |grid: &Occupancy, scan: &PlacedScan| safe_m_s(grid, scan, &here, (0.2, 0.3), 0.1);
        let wall = seen(|_| 1.0);
        for _ in 0..10 {
            grid.add(&wall);
            assert_eq!(safe(&grid, &wall), f64::INFINITY, "a wall");
        }
        let somebody = seen(|ray| if ray.abs_diff(100) < 10 { 0.75 } else { 1.0 });
        grid.add(&somebody);
        let first = safe(&grid, &somebody);
        assert!((first - (0.55 - 0.5) / 0.9).abs() < 0.01, "{first}");
        for _ in 0..5 {
            grid.add(&somebody);
        }
        assert_eq!(safe(&grid, &somebody), f64::INFINITY, "it stands");
    }
}
