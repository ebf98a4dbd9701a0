//! The duration of a search for a robot in its map. Run with `cargo bench -p baudbot-brains --bench localization`.

use baudbot_brains::Chance;
use baudbot_brains::estimate::Estimate;
use baudbot_brains::localization::laser::{self, localize};
use baudbot_brains::localization::particles::{self, Particles};
use baudbot_brains::localization::refine::{self, refine};
use baudbot_brains::localization::{Map, VirtualLaser};
use baudbot_brains::scan::Scan;
use baudbot_geometry::{Point, Pose, Segment, polygon};
use divan::Bencher;

fn main() {
    divan::main();
}

/// A box of 4.4 m with four square pillars: 20 segments.
fn map() -> Map {
    let square = |x: f64, y: f64, half: f64| {
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
        polygon::edges(&corners.map(|(dx, dy)| Point::new(x + dx, y + dy))).collect::<Vec<Segment>>()
    };
    let pillars = [(-0.75, -0.75), (0.75, -0.75), (0.75, 0.75), (-0.75, 0.75)];
    let pillars = pillars.into_iter().flat_map(|(x, y)| square(x, y, 0.2));
    Map::new(square(0.0, 0.0, 2.2).into_iter().chain(pillars).collect(), Vec::new()).expect("finite")
}

/// A URG-04LX with so many of its rays.
fn laser(rays: usize) -> VirtualLaser {
    VirtualLaser::like(&Scan {
        robot_from_laser: Pose::new(0.0, 0.0, 0.0),
        opening_rad: 239.4_f64.to_radians(),
        range_m: 4.0,
        distances_m: vec![0.0; rays],
    })
}

fn truth() -> Pose {
    Pose::new(-1.4, 0.3, 0.2)
}

/// A scan with 1 % of noise.
fn scan(map: &Map, rays: usize) -> Scan {
    let mut scan = laser(rays).scan(map, &truth());
    let mut chance = Chance::new(1, "scan");
    scan.distances_m.iter_mut().for_each(|distance| *distance *= 1.0 + 0.01 * chance.normal());
    scan
}

fn guess() -> Estimate {
    Estimate::within(Pose::new(-1.3, 0.2, 0.3), 0.1, 0.1)
}

#[divan::bench(args = [682, 171, 43])]
fn virtual_scan(bencher: Bencher<'_, '_>, rays: usize) {
    let (map, laser, mut distances_m) = (map(), laser(rays), vec![0.0; rays]);
    bencher.bench_local(|| laser.look(&map, &truth(), &mut distances_m));
}

#[divan::bench(args = [682, 171])]
fn search_with_300_poses(bencher: Bencher<'_, '_>, rays: usize) {
    let map = map();
    let scan = scan(&map, rays);
    let parameters = laser::Parameters { threshold: 0.0, ..laser::Parameters::default() };
    let mut chance = Chance::new(1, "search");
    bencher.bench_local(|| localize(&map, &scan, &guess().world_from_robot, &parameters, &mut chance));
}

#[divan::bench(args = [682, 171])]
fn refinement(bencher: Bencher<'_, '_>, rays: usize) {
    let map = map();
    let scan = scan(&map, rays);
    let mut chance = Chance::new(1, "refine");
    bencher.bench_local(|| refine(&map, &scan, &guess(), &refine::Parameters::default(), &mut chance));
}

#[divan::bench]
fn update_of_500_particles_by_43_beams(bencher: Bencher<'_, '_>) {
    let map = map();
    let scan = scan(&map, 682);
    let around = Estimate::within(truth(), 0.05, 0.05);
    let start = Particles::around(&around, particles::Parameters::default(), Chance::new(1, "particles"));
    bencher.with_inputs(|| start.clone()).bench_local_refs(|particles| {
        particles.advance(&Pose::new(0.0, 0.0, 0.05));
        particles.see(&map, &scan);
    });
}
