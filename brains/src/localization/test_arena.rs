//! Arenas and lasers that the tests of localization share.

use std::f64::consts::TAU;

use baudbot_geometry::{Circle, Point, Pose, Segment, Vector, polygon};

use super::deskew::Sweep;
use super::map::{Map, VirtualLaser};
use crate::Chance;
use crate::scan::Scan;

/// The sides of a rectangle between two corners.
pub(crate) fn rectangle([x0, y0, x1, y1]: [f64; 4]) -> Vec<Segment> {
    polygon::edges(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point::new(x, y))).collect()
}

/// An office of three rooms, two tables in them, 12 m by 9 m.
pub(crate) fn office() -> Map {
    let walls = [
        [4.5, 0.0, 4.5, 3.2],
        [4.5, 4.2, 4.5, 9.0],
        [8.0, 0.0, 8.0, 1.5],
        [8.0, 2.5, 8.0, 6.0],
        [8.0, 7.0, 8.0, 9.0],
        [4.5, 6.0, 5.8, 6.0],
        [6.8, 6.0, 8.0, 6.0],
    ];
    let wall = |[x0, y0, x1, y1]: [f64; 4]| Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) };
    let boxes = [[0.0, 0.0, 12.0, 9.0]].into_iter().chain(TABLES);
    let lines = walls.map(wall).into_iter().chain(boxes.flat_map(rectangle)).collect();
    Map::new(lines, vec![]).unwrap()
}

/// A box of 4.4 m with four square pillars.
pub(crate) fn pillars() -> Map {
    let pillar = |x: f64, y: f64| rectangle([x - 0.2, y - 0.2, x + 0.2, y + 0.2]);
    let corners = [(-0.75, -0.75), (0.75, -0.75), (0.75, 0.75), (-0.75, 0.75)];
    let lines = corners.into_iter().flat_map(|(x, y)| pillar(x, y));
    Map::new(rectangle([-2.2, -2.2, 2.2, 2.2]).into_iter().chain(lines).collect(), vec![]).unwrap()
}

/// A URG-04LX with so many of its rays.
pub(crate) fn urg(rays: usize) -> VirtualLaser {
    VirtualLaser::like(&Scan {
        robot_from_laser: Pose::new(0.0, 0.0, 0.0),
        opening_rad: 239.4_f64.to_radians(),
        range_m: 4.0,
        distances_m: vec![0.0; rays],
    })
}

/// A scan with a relative noise on each ray.
pub(crate) fn noisy_scan(
    laser: &VirtualLaser,
    map: &Map,
    pose: &Pose,
    noise: f64,
    chance: &mut Chance,
) -> Scan {
    let mut scan = laser.scan(map, pose);
    scan.distances_m.iter_mut().for_each(|distance| *distance *= 1.0 + noise * chance.normal());
    scan
}

/// The scan of a laser each of whose rays has a pose of its own, without noise.
pub(crate) fn swept(
    laser: &VirtualLaser,
    map: &Map,
    sweep: Sweep,
    pose_at: impl Fn(u64) -> Option<Pose>,
) -> Scan {
    let last = laser.rays() - 1;
    let seen_from = |i: usize| laser.scan(map, &pose_at(sweep.at_ns(i as f64 / last as f64)).unwrap());
    let mut scan = seen_from(0);
    (1..=last).for_each(|i| scan.distances_m[i] = seen_from(i).distances_m[i]);
    scan
}

/// A place in the map's bounds with 0.25 m of room around it, and any heading. Pillars
/// are too small to have room inside.
pub(crate) fn free_pose(map: &Map, chance: &mut Chance) -> Pose {
    let bounds = map.index().bounds().unwrap();
    loop {
        let [x, y] = [0, 1].map(|i| bounds.min[i] + chance.uniform() * bounds.size()[i]);
        let heading = TAU * chance.uniform();
        let body = Circle { center: Point::new(x, y), radius: 0.25 };
        let is_in_table = TABLES.iter().any(|[x0, y0, x1, y1]| *x0 < x && x < *x1 && *y0 < y && y < *y1);
        if !is_in_table && map.index().overlaps(&body).is_none() {
            return Pose::new(x, y, heading);
        }
    }
}

/// The distance of a pose from the true one: in metres, and in radians.
pub(crate) fn error(found: &Pose, truth: &Pose) -> (f64, f64) {
    let off: Vector = found.position - truth.position;
    (off.norm(), baudbot_geometry::angle::difference(found.heading, truth.heading).abs())
}

/// The value that a part of all values is below.
pub(crate) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * part).round() as usize]
}

/// A pose off by up to so much on each axis, uniformly, in metres and radians.
pub(crate) fn moved(pose: &Pose, most_m: f64, most_rad: f64, chance: &mut Chance) -> Pose {
    let mut off = |most: f64| most * (2.0 * chance.uniform() - 1.0);
    Pose::new(pose.position.x + off(most_m), pose.position.y + off(most_m), pose.heading + off(most_rad))
}

/// The office's, as corners.
const TABLES: [[f64; 4]; 2] = [[10.0, 3.5, 11.0, 4.5], [1.0, 6.0, 2.0, 7.5]];
