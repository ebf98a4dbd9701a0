//! Sensors of two spots of infra-red light on the ceiling.

use std::f64::consts::{FRAC_PI_2, SQRT_2};

use crate::common::statistics::{SAMPLES, assert_distributed, normal};
use crate::devices::scene::{all_near, block, collect, first, named, scene};

/// Spots a metre apart along x, 2 m above the sensor.
const SPOTS: &str = "kind = \"ir-beacons\"\nspots_m = [[-0.5, 0.0], [0.5, 0.0]]\nceiling_m = 2.5\nheight_m = 0.5\nopening_rad = 2.6";
const ABOVE_M: f64 = 2.0;

fn at(top: &str, [x_m, y_m, heading_rad]: [f64; 3], fields: &str) -> String {
    let start = format!("start = {{ x_m = {x_m:?}, y_m = {y_m:?}, heading_rad = {heading_rad:?} }}");
    scene(
        top,
        &format!("{start}\nfirmware = {{ mode = \"poll\" }}"),
        &named("s", &format!("{SPOTS}\n{fields}")),
    )
}

/// The beacons of Section 6.3.
#[test]
fn without_noise_it_tells_its_own_pose() {
    for pose in [[0.0, 0.0, 0.0], [0.3, -1.2, 2.5], [-2.0, 2.0, -3.0]] {
        all_near(&first(&at("", pose, "mount = {}")), &[pose[0], pose[1], pose[2], 2.0]);
    }
    // At the robot's left, and looking there.
    let askew = format!("mount = {{ y_m = 0.1, heading_rad = {FRAC_PI_2:?} }}");
    all_near(&first(&at("", [1.0, 0.5, 0.0], &askew)), &[1.0, 0.6, FRAC_PI_2, 2.0]);
}

#[test]
fn a_spot_is_seen_in_its_cone_only() {
    // The cone ends at 1.3 rad, 7.2 m from a spot on the floor.
    let edge_m = ABOVE_M * 1.3_f64.tan();
    let seen = |x_m: f64| first(&at("", [x_m, 0.0, 0.0], "mount = {}"));
    assert_eq!(seen(edge_m - 0.51)[3], 2.0);
    assert_eq!(seen(edge_m - 0.49), [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(seen(edge_m + 0.51), [0.0; 4]);
}

#[test]
fn a_wall_that_is_higher_than_the_sensor_hides_a_spot() {
    let wall = |height: &str| block("wall", [0.9, -5.0, 1.0, 5.0], height);
    let seen = |top: &str| first(&at(top, [2.0, 0.0, 0.0], "mount = {}"))[3];
    assert_eq!([seen(""), seen(&wall("")), seen(&wall("height_m = 0.4"))], [2.0, 0.0, 2.0]);
    assert_eq!(seen(&block("post", [0.0, -0.1, 0.1, 0.1], "")), 1.0, "it stands between the spots");
}

/// Standard deviations, for a radian's, of the image of a spot at this distance: away from the sensor and across.
fn images(distance_m: f64) -> [f64; 2] {
    let cos2 = ABOVE_M.powi(2) / (ABOVE_M.powi(2) + distance_m.powi(2));
    [ABOVE_M / cos2, ABOVE_M / cos2.sqrt()]
}

#[test]
fn between_the_spots_place_and_heading_have_the_errors_of_both() {
    let sigma = 0.001;
    let toml = at("step_ms = 0.05", [0.0; 3], &format!("mount = {{}}\nsigma_rad = {sigma:?}"));
    let readings = collect(&toml, SAMPLES);
    let [away, across] = images(0.5);
    // Both images are away along x; the mean of two, and the difference over a metre.
    for (value, sigma) in
        [(0, sigma * away / SQRT_2), (1, sigma * across / SQRT_2), (2, sigma * across * SQRT_2)]
    {
        let mut values: Vec<_> = readings.iter().map(|reading| reading[value]).collect();
        assert_distributed(&mut values, |scale| normal(0.0, sigma * scale));
    }
}

#[test]
fn the_error_grows_with_the_angle_from_the_spots() {
    // So small that a turn about spots 4 m away moves y by nothing.
    let sigma = 0.00005;
    let far_m = 4.0;
    let toml = at("step_ms = 0.05", [0.0, -far_m, 0.0], &format!("mount = {{}}\nsigma_rad = {sigma:?}"));
    let readings = collect(&toml, SAMPLES);
    let distance_m = far_m.hypot(0.5);
    let ([away, across], (sin, cos)) = (images(distance_m), (far_m / distance_m, 0.5 / distance_m));
    // The heading is off by the difference of both images along y.
    let along_y = (away * sin).hypot(across * cos);
    let mut headings: Vec<_> = readings.iter().map(|reading| reading[2]).collect();
    assert_distributed(&mut headings, |scale| normal(0.0, SQRT_2 * sigma * along_y * scale));
    // y has the mean of both, x that of the other axis and the turn about spots 4 m away.
    let mut ys: Vec<_> = readings.iter().map(|reading| reading[1] + far_m).collect();
    assert_distributed(&mut ys, |scale| normal(0.0, sigma * along_y / SQRT_2 * scale));
    assert!(along_y / images(0.5)[1] > 4.5, "{along_y}");
}
