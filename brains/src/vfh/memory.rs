//! What was seen nearby, in the cells of a grid: the active window of VFH+.
//!
//! A cell is occupied from when something was seen in it until a ray goes through it, until it is forgotten, or until the
//! robot is far from it. So what leaves the field of view stays for a while, and who walks through it leaves no trail.

use std::collections::BTreeMap;

use baudbot_geometry::{Point, Pose, angle, math};

use crate::scan::Scan;

/// Cells in which something was seen, in the frame of the believed pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    cell_m: f64,
    window_m: f64,
    forget_ns: u64,
    /// By column and row; with the instant at which something was seen last.
    cells: BTreeMap<(i64, i64), u64>,
}

impl Memory {
    /// One of cells with sides of `cell_m`, as far as `window_m` around the robot, for so long.
    pub fn new(cell_m: f64, window_m: f64, forget_s: f64) -> Self {
        Self { cell_m, window_m, forget_ns: (forget_s * 1e9) as u64, cells: BTreeMap::new() }
    }

    /// Takes in a scan that was taken at this instant, from this pose.
    pub fn see(&mut self, scan: &Scan, world_from_robot: &Pose, at_ns: u64) {
        let world_from_laser = world_from_robot.compose(&scan.robot_from_laser);
        let laser_from_world = world_from_laser.inverse();
        let half_m = 0.5 * self.cell_m;
        let center = |(column, row): (i64, i64)| {
            Point::new(column as f64 * 2.0 * half_m + half_m, row as f64 * 2.0 * half_m + half_m)
        };
        let (window_m, forget_ns) = (self.window_m, self.forget_ns);
        self.cells.retain(|&cell, seen_ns| {
            let place = center(cell);
            let is_near = (place - world_from_robot.position).norm() <= window_m + 2.0 * half_m;
            let is_fresh = at_ns.saturating_sub(*seen_ns) <= forget_ns;
            is_near && is_fresh && !is_seen_through(scan, laser_from_world.transform(place), 2.0 * half_m)
        });
        for (i, &distance_m) in scan.distances_m.iter().enumerate().filter(|(_, m)| m.is_finite()) {
            let (sin, cos) = math::sin_cos(scan.bearing_rad(i));
            let place = world_from_laser.transform(Point::new(distance_m * cos, distance_m * sin));
            if (place - world_from_robot.position).norm() <= window_m {
                let number = |m: f64| math::floor(m / self.cell_m) as i64;
                self.cells.insert((number(place.x), number(place.y)), at_ns);
            }
        }
    }

    /// The centres of the cells in which something is, as far as it is known.
    pub fn obstacles(&self) -> impl Iterator<Item = Point> + '_ {
        let place = |number: i64| (number as f64 + 0.5) * self.cell_m;
        self.cells.keys().map(move |&(column, row)| Point::new(place(column), place(row)))
    }
}

/// Whether the ray towards a place, in the frame of the laser, goes on behind it.
fn is_seen_through(scan: &Scan, place: Point, cell_m: f64) -> bool {
    let bearing = angle::wrap(math::atan2(place.y, place.x)) + 0.5 * scan.opening_rad;
    let spacing = scan.spacing_rad();
    let ray = if spacing > 0.0 { math::round(bearing / spacing) } else { 0.0 };
    if bearing < 0.0 || bearing > scan.opening_rad {
        return false;
    }
    // Of a ray that met nothing the range is known to be free; of one that is not known nothing is.
    let free_m = scan.distances_m.get(ray as usize).map_or(f64::NAN, |m| m.min(scan.range_m));
    let known_m =
        if scan.distances_m.get(ray as usize).is_some_and(|m| m.is_nan()) { f64::NAN } else { free_m };
    place.coords.norm() + cell_m < known_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five rays across 0.4 rad.
    fn scan(distances_m: [f64; 5]) -> Scan {
        let robot_from_laser = Pose::new(0.1, 0.0, 0.0);
        Scan { robot_from_laser, opening_rad: 0.4, range_m: 4.0, distances_m: distances_m.to_vec() }
    }

    const FREE: f64 = f64::INFINITY;

    fn seen(memory: &Memory) -> Vec<Point> {
        memory.obstacles().collect()
    }

    #[test]
    fn what_was_seen_is_there_until_it_is_seen_through() {
        let mut memory = Memory::new(0.1, 2.0, 5.0);
        let here = Pose::new(1.0, 1.0, 0.0);
        memory.see(&scan([FREE, FREE, 0.95, FREE, FREE]), &here, 0);
        let found = seen(&memory);
        assert!(found.len() == 1 && (found[0] - Point::new(2.05, 1.05)).norm() < 1e-9, "{found:?}");
        memory.see(&scan([FREE, FREE, 0.97, FREE, FREE]), &here, 1);
        assert_eq!(seen(&memory).len(), 1, "the same");
        memory.see(&scan([f64::NAN; 5]), &here, 2);
        assert_eq!(seen(&memory).len(), 1, "nothing is known");
        memory.see(&scan([FREE; 5]), &Pose::new(1.0, 1.0, 2.0), 3);
        assert_eq!(seen(&memory).len(), 1, "it looks elsewhere");
        memory.see(&scan([FREE; 5]), &here, 4);
        assert_eq!(seen(&memory).len(), 0, "it has gone");
    }

    #[test]
    fn what_is_old_or_far_away_is_forgotten() {
        let mut memory = Memory::new(0.1, 2.0, 5.0);
        let away = Pose::new(1.0, 1.0, 2.0);
        memory.see(&scan([FREE, FREE, 1.0, FREE, 3.0]), &Pose::new(1.0, 1.0, 0.0), 0);
        assert_eq!(seen(&memory).len(), 1, "3 m are out of the window");
        memory.see(&scan([FREE; 5]), &away, 4_900_000_000);
        assert_eq!(seen(&memory).len(), 1);
        memory.see(&scan([FREE; 5]), &away, 5_100_000_000);
        assert_eq!(seen(&memory).len(), 0);
        memory.see(&scan([FREE, FREE, 1.0, FREE, FREE]), &Pose::new(1.0, 1.0, 0.0), 6_000_000_000);
        memory.see(&scan([FREE; 5]), &Pose::new(-1.5, 1.0, 2.0), 6_100_000_000);
        assert_eq!(seen(&memory).len(), 0);
    }
}
