//! Optical-flow sensors, on a robot whose wheels roll 0.2π metres a second times the signal, from the first step on.

use std::f64::consts::{FRAC_PI_2, PI};

use baudbot_geometry::Pose;
use baudbot_sim::{Intervention, World};

use crate::common::statistics::{SAMPLES, assert_distributed, kolmogorov_smirnov, normal};
use crate::common::{tick, world};
use crate::devices::scene::{named, scene, view};

const MOTORS: &str = "motors = { kind = \"stepper\", steps_per_turn = 1000, full_rate_steps_s = 1000, max_acceleration_steps_s2 = 1e9 }";

fn flow(name: &str, fields: &str) -> String {
    named(name, &format!("kind = \"optical-flow\"\nmax_speed_m_s = 10.0\n{fields}"))
}

fn driving(top: &str, sensors: &str) -> World {
    world(&scene(top, MOTORS, sensors))
}

/// The readings of the sensor of this name in each of so many ticks with these signals.
fn readings(world: &mut World, name: &str, ticks: usize, [left, right]: [f64; 2]) -> Vec<[f64; 2]> {
    let read = |_| {
        tick(world, left, right);
        let sample = view(world, name).sample;
        [sample[0], sample[1]]
    };
    (0..ticks).map(read).collect()
}

fn sum(readings: &[[f64; 2]]) -> [f64; 2] {
    readings.iter().fold([0.0; 2], |[x, y], reading| [x + reading[0], y + reading[1]])
}

#[test]
fn a_straight_way_is_counted_along_the_sensors_own_axes() {
    let ahead = flow("ahead", "mount = {}\ncounts_per_m = 10000.0");
    let left = flow("left", "mount = { heading_rad = 1.5707963267948966 }\ncounts_per_m = 10000.0");
    let mut world = driving("", &(ahead + &left));
    // 0.1π m/s are π mm a tick, 31.4 counts; in the first tick it has yet to move.
    let found = readings(&mut world, "ahead", 5, [0.5, 0.5]);
    assert_eq!(found, [[0.0, 0.0], [31.0, 0.0], [32.0, 0.0], [31.0, 0.0], [32.0, 0.0]]);
    assert_eq!(view(&world, "left").sample, [0.0, -32.0]);
    let back = readings(&mut world, "ahead", 101, [-0.5, -0.5]);
    // The way there is counted in the first of them, and 100 ticks are 3141.59 counts.
    assert_eq!(sum(&found)[0] + sum(&back)[0], (5.0 * 10.0 * PI - 1000.0 * PI).round());
}

#[test]
fn a_sensor_off_the_centre_sees_the_robot_turn() {
    let sensor = |name: &str, mount: &str| {
        flow(name, &format!("mount = {{ {mount} }}\ncounts_per_m = 100000.0\nperiod_ms = 1000.0"))
    };
    let sensors = sensor("front", "x_m = 0.1")
        + &sensor("side", "y_m = 0.2")
        + &sensor("askew", "x_m = 0.1, heading_rad = 1.5707963267948966")
        + &sensor("centre", "heading_rad = 1.0");
    let mut world = driving("", &sensors);
    // Rims at ∓0.1π m/s turn the robot by π/2 a second, as they are 0.2 m from its centre.
    tick(&mut world, -0.5, 0.5);
    readings(&mut world, "front", 100, [-0.5, 0.5]);
    assert!((world.robot(0).motion().pose.heading - FRAC_PI_2 * 1.01).abs() < 1e-9);
    // ω × r, times a second: 0.1 m or 0.2 m times π/2.
    assert_eq!(view(&world, "front").sample, [0.0, 15708.0]);
    assert_eq!(view(&world, "side").sample, [-31416.0, 0.0]);
    assert_eq!(view(&world, "askew").sample, [15708.0, 0.0]);
    assert_eq!(view(&world, "centre").sample, [0.0, 0.0]);
}

#[test]
fn parts_of_a_count_are_kept_however_often_it_is_read() {
    let often = flow("often", "mount = {}\ncounts_per_m = 100.0");
    let seldom = flow("seldom", "mount = {}\ncounts_per_m = 100.0\nperiod_ms = 1000.0");
    let mut world = driving("", &(often + &seldom));
    // 0.314 counts a tick.
    let found = readings(&mut world, "often", 101, [0.5, 0.5]);
    assert!(found.iter().all(|&[dx, dy]| (dx == 0.0 || dx == 1.0) && dy == 0.0), "{found:?}");
    assert_eq!(sum(&found), [31.0, 0.0]);
    assert_eq!(view(&world, "seldom").sample, [31.0, 0.0]);
}

#[test]
fn registers_saturate_and_what_is_beyond_is_lost() {
    let sensors = flow("byte", "mount = {}\ncounts_per_m = 100000.0\nbits = 8")
        + &flow("wide", "mount = {}\ncounts_per_m = 100000.0\nbits = 16");
    let mut world = driving("", &sensors);
    // 314 counts a tick.
    readings(&mut world, "byte", 2, [0.5, 0.5]);
    assert_eq!((view(&world, "byte").sample[0], view(&world, "wide").sample[0]), (127.0, 314.0));
    assert_eq!(world.robot(0).readings()[0].values[0], 127.0);
    readings(&mut world, "byte", 2, [-0.5, -0.5]);
    assert_eq!((view(&world, "byte").sample[0], view(&world, "wide").sample[0]), (-128.0, -314.0));
    readings(&mut world, "byte", 2, [0.0, 0.0]);
    assert_eq!((view(&world, "byte").sample[0], view(&world, "wide").sample[0]), (0.0, 0.0));
}

#[test]
fn it_loses_track_of_a_floor_that_goes_by_too_fast() {
    let sensor = "kind = \"optical-flow\"\nmount = {}\ncounts_per_m = 10000.0\nmax_speed_m_s = 0.315";
    let mut world = driving("", &named("s", sensor));
    // 0.1π m/s are slow enough, π % more are not.
    assert!(sum(&readings(&mut world, "s", 11, [0.5, 0.5]))[0] > 310.0);
    tick(&mut world, 0.52, 0.52);
    assert_eq!(sum(&readings(&mut world, "s", 10, [0.52, 0.52])), [0.0, 0.0]);
    tick(&mut world, 0.5, 0.5);
    assert!(sum(&readings(&mut world, "s", 10, [0.5, 0.5]))[0] > 310.0, "it finds it again");
}

#[test]
fn a_robot_that_is_put_somewhere_else_has_gone_no_way() {
    let mut world = driving("", &flow("s", "mount = {}\ncounts_per_m = 10000.0"));
    tick(&mut world, 0.0, 0.0);
    let put = Intervention::PlaceRobot { robot: "r".into(), pose: Pose::new(1.0, 2.0, 0.5) };
    world.intervene(&put).unwrap();
    assert_eq!(sum(&readings(&mut world, "s", 3, [0.0, 0.0])), [0.0, 0.0]);
}

#[test]
fn slip_does_not_deceive_it() {
    let ice =
        "[[arena.zones]]\nname = \"ice\"\npoints_m = [[-5, -5], [5, -5], [5, 5], [-5, 5]]\nslip = 0.5\n";
    let mut world = driving(ice, &flow("s", "mount = {}\ncounts_per_m = 10000.0"));
    // Half of 0.1π m/s, for a second.
    assert_eq!(sum(&readings(&mut world, "s", 101, [0.5, 0.5])), [1571.0, 0.0]);
    assert!(world.robot(0).motion().travel_m.left > 0.3);
}

#[test]
fn each_specimen_has_its_gain() {
    let toml =
        |top: &str| scene(top, MOTORS, &flow("s", "mount = {}\ncounts_per_m = 1e6\ngain_spread = 0.01"));
    let second = |toml: &str| readings(&mut world(toml), "s", 2, [0.5, 0.5])[1][0];
    let mut found: Vec<_> = (0..2000).map(|seed| second(&toml(&format!("seed = {seed}")))).collect();
    let outcome = kolmogorov_smirnov(&mut found, normal(1000.0 * PI, 10.0 * PI));
    assert!(outcome.fits(), "{outcome:?}");
    assert_eq!(second(&toml("noise = false")), 3142.0);
}

#[test]
fn its_error_is_normal_and_grows_as_the_root_of_the_way() {
    let sensors = flow("often", "mount = {}\ncounts_per_m = 1e6\nsigma_m = 0.001")
        + &flow("seldom", "mount = {}\ncounts_per_m = 1e6\nsigma_m = 0.001\nperiod_ms = 40.0");
    let mut world = driving("step_ms = 10.0\nsubsteps = 1", &sensors);
    tick(&mut world, 0.5, 0.5);
    let (mut along, mut aside, mut of_four) = (Vec::new(), Vec::new(), Vec::new());
    for i in 1..=SAMPLES {
        tick(&mut world, 0.5, 0.5);
        let sample = view(&world, "often").sample;
        along.push(sample[0]);
        aside.push(sample[1]);
        if i % 4 == 0 {
            of_four.push(view(&world, "seldom").sample[0] - 4000.0 * PI);
        }
    }
    // After π mm the root is that of 0.00314, and after four times the way twice as much.
    let sigma = 1000.0 * (0.001 * PI).sqrt();
    assert_distributed(&mut along, |scale| normal(1000.0 * PI, sigma * scale));
    assert_distributed(&mut aside, |scale| normal(0.0, sigma * scale));
    let outcome = kolmogorov_smirnov(&mut of_four, normal(0.0, 2.0 * sigma));
    assert!(outcome.fits(), "{outcome:?}");
}

#[test]
fn a_robot_that_stands_has_no_error() {
    let mut world =
        driving("", &flow("s", "mount = {}\ncounts_per_m = 1e6\nsigma_m = 1.0\ngain_spread = 1.0"));
    assert_eq!(sum(&readings(&mut world, "s", 100, [0.0, 0.0])), [0.0, 0.0]);
}
