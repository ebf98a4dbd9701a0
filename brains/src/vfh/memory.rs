//! Obstacles that were seen nearby, in the cells of a grid: the active window of VFH+.
//!
//! A cell is occupied from when something was seen in it until a ray goes through it, until it is forgotten, or until the
//! robot is far from it. So obstacles that leave the field of view stay for a while, and a person who walks through it leaves
//! no trail.

use std::collections::{BTreeMap, BTreeSet};

use baudbot_geometry::{Point, Pose, angle, math};

use crate::scan::Scan;

/// Cells in which something was seen, in the frame of the believed pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    cell_m: f64,
    window_m: f64,
    forget_ns: u64,
    /// The cells, by column and row.
    cells: BTreeMap<(i64, i64), Cell>,
    newest_ns: u64,
}

/// A cell in which something is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cell {
    /// The instant at which the obstacle came.
    since_ns: u64,
    /// The instant at which the obstacle was seen last.
    seen_ns: u64,
}

impl Memory {
    /// One of cells with sides of `cell_m`, as far as `window_m` around the robot, for so long.
    pub fn new(cell_m: f64, window_m: f64, forget_s: f64) -> Self {
        Self { cell_m, window_m, forget_ns: (forget_s * 1e9) as u64, cells: BTreeMap::new(), newest_ns: 0 }
    }

    /// Takes in a scan that was taken at this instant, from this pose.
    pub fn see(&mut self, scan: &Scan, world_from_robot: &Pose, at_ns: u64) {
        let world_from_laser = world_from_robot.compose(&scan.robot_from_laser);
        let laser_from_world = world_from_laser.inverse();
        self.newest_ns = self.newest_ns.max(at_ns);
        let hits = self.hits(scan, &world_from_laser, world_from_robot.position);
        for &hit in &hits {
            let new = Cell { since_ns: at_ns, seen_ns: at_ns };
            self.cells.entry(hit).or_insert(new).seen_ns = at_ns;
        }
        let (cell_m, window_m, forget_ns) = (self.cell_m, self.window_m, self.forget_ns);
        self.cells.retain(|&place, cell| {
            // One ray goes past an edge that another one meets.
            if hits.contains(&place) {
                return true;
            }
            let place = center(place, cell_m);
            let is_near = (place - world_from_robot.position).norm() <= window_m + cell_m;
            let is_fresh = at_ns.saturating_sub(cell.seen_ns) <= forget_ns;
            is_near && is_fresh && !is_seen_through(scan, laser_from_world.transform(place), cell_m)
        });
    }

    /// The cells in which rays end.
    fn hits(&self, scan: &Scan, world_from_laser: &Pose, here: Point) -> BTreeSet<(i64, i64)> {
        let seen = scan.distances_m.iter().enumerate().filter(|(_, m)| m.is_finite());
        let places = seen.map(|(i, distance_m)| {
            let (sin, cos) = math::sin_cos(scan.bearing_rad(i));
            world_from_laser.transform(Point::new(distance_m * cos, distance_m * sin))
        });
        let near = places.filter(|place| (place - here).norm() <= self.window_m);
        let number = |m: f64| math::floor(m / self.cell_m) as i64;
        near.map(|place| (number(place.x), number(place.y))).collect()
    }

    /// The centres of the cells in which something is, as far as it is known.
    pub fn obstacles(&self) -> impl Iterator<Item = Point> + '_ {
        self.cells.keys().map(|&cell| center(cell, self.cell_m))
    }

    /// The least speed of a walker that is distinguished from standing objects, in metres a second: two cells in half
    /// a second.
    pub fn slowest_m_s(cell_m: f64) -> f64 {
        2.0 * cell_m / (STOOD_NS as f64 * 1e-9)
    }

    /// The centres of the cells that may be of a walking person, and for which `counts` holds: nothing has been there
    /// or beside for half a second. What is seen for the first time may walk, too.
    pub fn walkers(&self, counts: impl Fn(Point) -> bool) -> impl Iterator<Item = Point> {
        let has_stood = |cell: &Cell| self.newest_ns.saturating_sub(cell.since_ns) >= STOOD_NS;
        let stands = move |(column, row): (i64, i64)| {
            (column - 1..=column + 1).any(|column| {
                self.cells.range((column, row - 1)..=(column, row + 1)).any(|(_, cell)| has_stood(cell))
            })
        };
        let near = self.cells.keys().map(|&cell| (cell, center(cell, self.cell_m)));
        near.filter(move |&(cell, place)| counts(place) && !stands(cell)).map(|(_, place)| place)
    }
}

/// The middle of a cell.
fn center((column, row): (i64, i64), cell_m: f64) -> Point {
    Point::new((column as f64 + 0.5) * cell_m, (row as f64 + 0.5) * cell_m)
}

/// An object that has been in its place for so long does not walk, in nanoseconds.
const STOOD_NS: u64 = 500_000_000;

/// Whether the ray towards a place, in the frame of the laser, goes on behind it.
fn is_seen_through(scan: &Scan, place: Point, cell_m: f64) -> bool {
    let bearing = angle::wrap(math::atan2(place.y, place.x)) + 0.5 * scan.opening_rad;
    let spacing = scan.spacing_rad();
    let ray = if spacing > 0.0 { math::round(bearing / spacing) } else { 0.0 };
    if bearing < 0.0 || bearing > scan.opening_rad {
        return false;
    }
    // A ray that met nothing is free up to the range; an unknown ray gives nothing.
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
    fn who_walks_is_told_from_what_stands() {
        let mut memory = Memory::new(0.1, 2.0, 5.0);
        let walkers = |memory: &Memory| memory.walkers(|_| true).count();
        for i in 0..10 {
            // A post stands to the left, and a person comes from ahead at 0.5 m/s.
            let ahead_m = 1.2 - 0.05 * f64::from(i);
            let noise_m = 0.02 * f64::from(i % 2);
            let scan = scan([FREE, FREE, ahead_m, FREE, 1.05 + noise_m]);
            memory.see(&scan, &Pose::new(1.0, 1.0, 0.0), 100_000_000 * i as u64);
            let expected = if i < 5 { 2..=4 } else { 1..=2 };
            assert!(expected.contains(&walkers(&memory)), "{i}: {}", walkers(&memory));
        }
        assert!(memory.walkers(|place| place.y > 1.1).next().is_none());
    }

    /// One ray passes the middle of a cell that its neighbour meets at the edge.
    #[test]
    fn what_one_ray_meets_and_another_passes_has_stood_there_all_the_time() {
        let mut memory = Memory::new(0.1, 2.0, 5.0);
        for i in 0..7 {
            memory.see(
                &scan([0.8, FREE, FREE, FREE, FREE]),
                &Pose::new(1.1545, 1.0729, 0.1),
                100_000_000 * i,
            );
            assert_eq!(
                (seen(&memory).len(), memory.walkers(|_| true).count()),
                (1, usize::from(i < 5)),
                "{i}"
            );
        }
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
