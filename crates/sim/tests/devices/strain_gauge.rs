//! Strain gauges, on ARSim's robot (3 kg, wheels of 0.1 m) in front of a wall.

use std::f64::consts::TAU;

use baudbot_sim::World;

use crate::common::statistics::{kolmogorov_smirnov, normal};
use crate::common::{run, tick, world};
use crate::devices::scene::{named, near, scene, view, wall};

fn gauge(name: &str, fields: &str) -> String {
    named(name, &format!("kind = \"strain-gauge\"\nopening_rad = 1.0\nrange_n = 1000.0\n{fields}"))
}

/// The robot `gap_m` before the wall, with these gauges.
fn before_wall(gap_m: f64, speed_m_s: f64, sensors: &str) -> World {
    let start = format!("start = {{ x_m = {:?}, speed_m_s = {speed_m_s:?} }}", 0.8 - gap_m);
    world(&scene(&wall(1.0), &start, sensors))
}

fn reading(world: &World, name: &str) -> f64 {
    view(world, name).sample[0]
}

/// At half the voltage a motor that stands gives 0.0333 N m/A · 6 V / 0.62 Ω, less 0.008 N m of friction; gears double that, (1.8) to (1.10).
const HELD_N: f64 = 2.0 * 2.0 * (0.0333 * 6.0 / 0.62 - 0.008) / 0.1;

/// A strain gauge of §1.2.2.
#[test]
fn a_robot_that_is_held_pushes_with_the_torques_of_its_wheels() {
    let sensors = gauge("n", "") + &gauge("bridge", "bridge_mv_v = 2.0") + &gauge("slow", "period_ms = 70.0");
    let mut world = before_wall(0.5, 0.0, &sensors);
    run(&mut world, 400, 0.5, 0.5);
    near(reading(&world, "n"), HELD_N);
    near(reading(&world, "bridge"), HELD_N * 2.0 / 1000.0);
    near(reading(&world, "slow"), HELD_N);
    // No more than 1 N m at each wheel.
    run(&mut world, 100, 1.0, 1.0);
    near(reading(&world, "n"), 20.0);
    run(&mut world, 100, -0.5, -0.5);
    assert_eq!(reading(&world, "n"), 0.0, "it has driven away");
}

/// Before the impact damping and the motors, as generators, slow the robot for one step of 10 ms: at 3 rad/s, with (1.8) to (1.10) and (2.31).
#[test]
fn an_impact_is_the_momentum_over_the_time_between_two_reads() {
    let mut world = before_wall(0.0001, 0.3, &gauge("s", ""));
    world.begin();
    assert_eq!(reading(&world, "s"), 0.0);
    world.finish(&[]);
    world.begin();
    let torque = 2.0 * (0.0333 * 0.0333 * 6.0 / 0.62 + 0.008 + 0.02 * 6.0);
    let speed = 0.3 - 0.01 * (15.0 * 0.3 + 2.0 * torque / 0.1) / 3.0;
    near(reading(&world, "s"), 3.0 * speed / 0.01);
}

#[test]
fn a_bar_behind_feels_what_the_robot_backs_into() {
    let sensors = gauge("front", "")
        + &gauge("behind", "bearing_rad = 3.141592653589793")
        + &gauge("left", "bearing_rad = 1.5");
    let start = "start = { x_m = 0.79, heading_rad = 3.141592653589793 }";
    let mut world = world(&scene(&wall(1.0), start, &sensors));
    run(&mut world, 200, -0.5, -0.5);
    near(reading(&world, "behind"), HELD_N);
    assert_eq!((reading(&world, "front"), reading(&world, "left")), (0.0, 0.0));
}

#[test]
fn what_is_not_at_the_bar_is_not_felt() {
    let mut world = before_wall(0.01, 0.0, &(gauge("s", "") + &gauge("left", "bearing_rad = 1.2")));
    run(&mut world, 200, 0.5, 0.5);
    near(reading(&world, "s"), HELD_N);
    assert_eq!(reading(&world, "left"), 0.0);
}

#[test]
fn a_filter_follows_the_force_with_its_time_constant() {
    let mut world = before_wall(1e-9, 0.0, &gauge("s", "bandwidth_hz = 2.0"));
    let left_n: Vec<_> = (0..60)
        .map(|_| {
            tick(&mut world, 0.5, 0.5);
            HELD_N - reading(&world, "s")
        })
        .skip_while(|&left_n| left_n == HELD_N)
        .collect();
    assert!(left_n.len() > 50);
    for pair in left_n.windows(2) {
        near(pair[1] / pair[0], (-0.01 * TAU * 2.0).exp());
    }
}

#[test]
fn its_noise_is_normal_and_never_below_nothing() {
    let noise = "noise = { additive = 2.0 }";
    let mut world = before_wall(
        1e-9,
        0.0,
        &(gauge("s", noise) + &gauge("behind", &format!("bearing_rad = 3.14\n{noise}"))),
    );
    run(&mut world, 10, 0.5, 0.5);
    let mut readings: Vec<_> = (0..5000)
        .map(|_| {
            tick(&mut world, 0.5, 0.5);
            assert!(reading(&world, "behind") >= 0.0);
            reading(&world, "s")
        })
        .collect();
    let outcome = kolmogorov_smirnov(&mut readings, normal(HELD_N, 2.0));
    assert!(outcome.fits(), "{outcome:?}");
}

#[test]
fn robots_without_a_gauge_move_as_those_with_one() {
    let bumper = named("s", "kind = \"bumper\"\nopening_rad = 1.0");
    let mut worlds = [before_wall(0.3, 0.0, &bumper), before_wall(0.3, 0.0, &gauge("s", ""))];
    for world in &mut worlds {
        run(world, 200, 0.5, 0.4);
    }
    assert_eq!(worlds[0].robot(0).motion(), worlds[1].robot(0).motion());
}
