//! Scans of known rooms, and what becomes of guesses that are wrong.

use baudbot_geometry::{Point, Segment};

use super::*;
use crate::Chance;
use crate::localization::test_arena::{error, moved, noisy_scan, office, pillars, quantile, urg};
use crate::localization::{Map, VirtualLaser};
use crate::mapping::{Cell, Occupied};

/// The frame of its own that a robot maps in: none of its walls are along the rows of the grid.
fn own(pose: Pose) -> Pose {
    Pose::new(0.31, 0.17, 0.5).compose(&pose)
}

/// The map that a robot makes of a place that it has scanned all around from a pose.
fn mapped(map: &Map, laser: &VirtualLaser, here: Pose) -> (Slam, Occupancy) {
    let mut slam = Slam::new(Parameters::default());
    let mut grid = slam.grid();
    for turn in [0.0, 2.0, 4.0] {
        let pose = Pose { heading: angle::wrap(here.heading + turn), ..here };
        let scan = laser.scan(map, &pose);
        grid.add(&PlacedScan::new(own(pose), scan));
    }
    slam.added = Some(own(here));
    (slam, grid)
}

#[test]
fn the_first_scan_is_believed_to_be_from_where_the_odometry_says() {
    let mut slam = Slam::new(Parameters::default());
    let mut grid = slam.grid();
    let guess = Estimate::within(Pose::new(1.0, 2.0, 0.3), 0.1, 0.1);
    let scan = urg(682).scan(&pillars(), &Pose::new(0.0, 0.0, 0.0));
    assert_eq!(slam.see(&mut grid, &scan, &guess), Some(guess));
    let occupied = grid.cells().filter(|cell| grid.state(*cell) == Occupied::Occupied).count();
    assert!(occupied > 100, "{occupied}");
}

#[test]
fn a_wrong_guess_is_mended() {
    let (map, laser, mut chance) = (office(), urg(682), Chance::new(1, "slam"));
    let here = Pose::new(6.0, 5.2, 0.4);
    let (mut slam, grid) = mapped(&map, &laser, here);
    let mut errors = vec![];
    for _ in 0..30 {
        let truth = moved(&here, 0.2, 1.0, &mut chance);
        let scan = noisy_scan(&laser, &map, &truth, 0.01, &mut chance);
        let guess = Estimate::within(moved(&own(truth), 0.1, 0.05, &mut chance), 0.05, 0.03);
        let found = slam.see(&mut grid.clone(), &scan, &guess).expect("a match");
        errors.push(error(&found.world_from_robot, &own(truth)));
    }
    let (m, rad): (Vec<_>, Vec<_>) = errors.into_iter().unzip();
    let figures = [quantile(&m, 0.5), quantile(&m, 1.0), quantile(&rad, 0.5), quantile(&rad, 1.0)];
    println!("{figures:?}");
    assert!(
        figures[0] < 0.015 && figures[1] < 0.04 && figures[2] < 0.005 && figures[3] < 0.02,
        "{figures:?}"
    );
}

#[test]
fn a_scan_that_fits_nowhere_near_changes_nothing() {
    let (laser, here) = (urg(682), Pose::new(6.0, 5.2, 0.4));
    let (mut slam, mut grid) = mapped(&office(), &laser, here);
    let before = grid.clone();
    let scan = laser.scan(&pillars(), &Pose::new(0.1, 0.0, 0.3));
    assert_eq!(slam.see(&mut grid, &scan, &Estimate::within(own(here), 0.05, 0.05)), None);
    assert_eq!(grid, before);
}

/// The walls determine the distance to them, and not the place along them.
#[test]
fn along_a_corridor_the_odometry_is_believed() {
    let wall = |y: f64| Segment { start: Point::new(-50.0, y), end: Point::new(50.0, y) };
    let map = Map::new(vec![wall(-1.0), wall(1.0)], vec![]).unwrap();
    let laser = urg(682);
    let (mut slam, mut grid) = mapped(&map, &laser, Pose::new(0.0, 0.0, 0.0));
    let scan = laser.scan(&map, &Pose::new(0.5, 0.0, 0.0));
    let guess = Estimate::within(own(Pose::new(0.5, 0.08, 0.03)), 0.05, 0.05);
    let found = slam.see(&mut grid, &scan, &guess).expect("a match");
    let Pose { position, heading } = own(Pose::new(0.0, 0.0, 0.0)).inverse().compose(&found.world_from_robot);
    assert!((position.x - 0.5).abs() < 0.03 && position.y.abs() < 0.02 && heading.abs() < 0.01, "{found:?}");
    let variance = |along: nalgebra::Vector3<f64>| along.dot(&(found.covariance * along));
    let (sin, cos) = 0.5_f64.sin_cos();
    let [along, across] = [(cos, sin), (-sin, cos)].map(|(x, y)| variance(nalgebra::Vector3::new(x, y, 0.0)));
    assert!(along > 3.0 * across, "{along} {across}");
}

#[test]
fn who_sees_nothing_believes_the_odometry() {
    let mut slam = Slam::new(Parameters::default());
    let mut grid = slam.grid();
    let mut scan = urg(11).scan(&office(), &Pose::new(6.0, 5.0, 0.4));
    for nothing in [f64::INFINITY, f64::NAN] {
        scan.distances_m.fill(nothing);
        let guess = Estimate::exact(Pose::new(1.0, 2.0, 0.3));
        assert_eq!(slam.see(&mut grid, &scan, &guess), Some(guess));
    }
}

#[test]
fn a_scan_is_added_only_after_a_step() {
    let (map, laser, here) = (office(), urg(171), Pose::new(6.0, 5.2, 0.4));
    let mut slam = Slam::new(Parameters::default());
    let mut grid = slam.grid();
    let mut change = |pose: Pose| {
        let before = grid.clone();
        slam.see(&mut grid, &laser.scan(&map, &pose), &Estimate::within(pose, 0.02, 0.02)).expect("a match");
        before != grid
    };
    assert!(change(here), "the first one");
    assert!(!change(here.compose(&Pose::new(0.05, 0.0, 0.05))), "hardly moved");
    assert!(change(here.compose(&Pose::new(0.0, 0.0, 0.15))), "turned");
}

#[test]
fn a_grid_that_would_be_too_large_is_an_end_of_it() {
    let mut slam = Slam::new(Parameters::default());
    let mut grid = slam.grid();
    let scan = urg(11).scan(&office(), &Pose::new(6.0, 5.0, 0.4));
    assert!(slam.see(&mut grid, &scan, &Estimate::exact(Pose::new(0.0, 0.0, 0.0))).is_some());
    assert_eq!(slam.see(&mut grid, &scan, &Estimate::exact(Pose::new(1e6, 0.0, 0.0))), None);
    assert_eq!(grid.state(Cell { column: 100_000, row: 0 }), Occupied::Unknown);
}
