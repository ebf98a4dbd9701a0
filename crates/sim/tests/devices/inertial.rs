//! Accelerometer, gyroscope, compass.

use std::f64::consts::{PI, TAU};

use baudbot_sim::World;

use crate::common::statistics::{SAMPLES, assert_distributed, kolmogorov_smirnov, normal};
use crate::common::{run, world};
use crate::devices::scene::{collect, first, near, scene, single, singles, specimens, view, with_sensor};

const ACCELEROMETER: &str = "kind = \"accelerometer\"\nrange_m_s2 = 5.0";
const GYROSCOPE: &str = "kind = \"gyroscope\"\nrange_rad_s = 4.0";
const MOVING: &str = "start = { speed_m_s = 0.5, turn_rate_rad_s = 0.8 }";

fn moving(top: &str, sensor: &str) -> String {
    scene(top, MOVING, &crate::devices::scene::named("s", sensor))
}

/// The accelerometer of §1.2.2, Fig. 1.10: a mass on a spring feels V̇ and V φ̇.
#[test]
fn an_accelerometer_feels_the_change_of_speed_and_the_curve() {
    let mut world = world(&moving("", &ACCELEROMETER.replace("5.0", "20.0")));
    world.begin();
    // The reading is 0 ahead at the start, as nothing has changed yet; to the side it is V φ̇.
    crate::devices::scene::all_near(view(&world, "s").sample, &[0.0, 0.4]);
    let before = *world.robot(0).motion();
    world.finish(&[]);
    world.begin();
    let now = *world.robot(0).motion();
    let forward = (now.speed_m_s - before.speed_m_s) / 0.01;
    assert!(forward < -1.0, "it brakes: {forward}");
    crate::devices::scene::all_near(
        view(&world, "s").sample,
        &[forward, now.speed_m_s * now.turn_rate_rad_s],
    );
}

#[test]
fn an_accelerometer_says_no_more_than_its_range() {
    let toml = scene(
        "",
        "start = { speed_m_s = -3.0, turn_rate_rad_s = 8.0 }",
        &crate::devices::scene::named("s", ACCELEROMETER),
    );
    let readings = collect(&toml, 3);
    assert_eq!(readings[0], [0.0, -5.0]);
    assert_eq!(readings[1][0], 5.0);
}

/// A gyroscope (§1.2.2).
#[test]
fn a_gyroscope_reads_the_turn_rate_within_its_range() {
    let at = |rate: f64| {
        let start = format!("start = {{ turn_rate_rad_s = {rate:?} }}");
        single(&scene("", &start, &crate::devices::scene::named("s", GYROSCOPE)))
    };
    for (rate, expected) in [(0.8, 0.8), (-3.9, -3.9), (7.0, 4.0), (-7.0, -4.0), (0.0, 0.0)] {
        near(at(rate), expected);
    }
}

/// The same filter, from the truth.
fn filtered(bandwidth_hz: f64, truth: &[f64]) -> Vec<f64> {
    let keep = (-0.01 * TAU * bandwidth_hz).exp();
    let mut last = truth[0];
    truth
        .iter()
        .map(|&input| {
            last = input + (last - input) * keep;
            last
        })
        .collect()
}

#[test]
fn bandwidth_is_a_low_pass_filter_of_first_order() {
    let sensors = crate::devices::scene::named("s", &format!("{GYROSCOPE}\nbandwidth_hz = 5.0"))
        + &crate::devices::scene::named("a", &format!("{ACCELEROMETER}\nbandwidth_hz = 3.0"));
    let mut world = world(&scene("", MOVING, &sensors));
    let (mut turn, mut side, mut found) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..100 {
        world.begin();
        let motion = world.robot(0).motion();
        turn.push(motion.turn_rate_rad_s);
        side.push(motion.speed_m_s * motion.turn_rate_rad_s);
        found.push((view(&world, "s").sample[0], view(&world, "a").sample[1]));
        world.finish(&[]);
    }
    for (i, (turn, side)) in filtered(5.0, &turn).into_iter().zip(filtered(3.0, &side)).enumerate() {
        near(found[i].0, turn);
        near(found[i].1, side);
    }
}

#[test]
fn a_gyroscope_has_normal_noise_and_each_specimen_its_offset() {
    let noisy = with_sensor("step_ms = 0.05", &format!("{GYROSCOPE}\nnoise = {{ additive = 0.02 }}"));
    assert_distributed(&mut singles(&noisy, SAMPLES), |scale| normal(0.0, 0.02 * scale));
    let offset = with_sensor("", &format!("{GYROSCOPE}\nnoise = {{ offset_spread = 0.3 }}"));
    let outcome = kolmogorov_smirnov(&mut specimens(&offset, 2000), normal(0.0, 0.3));
    assert!(outcome.fits(), "{outcome:?}");
}

#[test]
fn an_accelerometer_has_independent_noise_on_its_axes_and_each_specimen_its_gains() {
    let noisy = with_sensor("step_ms = 0.05", &format!("{ACCELEROMETER}\nnoise = {{ additive = 0.1 }}"));
    let readings = collect(&noisy, 20_000);
    let pairs: Vec<_> = readings.iter().map(|reading| (reading[0], reading[1])).collect();
    let correlation = crate::common::statistics::correlation(&pairs);
    assert!(correlation.abs() < 0.025, "{correlation}");
    for axis in 0..2 {
        let mut values: Vec<_> = readings.iter().map(|reading| reading[axis]).collect();
        let outcome = kolmogorov_smirnov(&mut values, normal(0.0, 0.1));
        assert!(outcome.fits(), "{axis}: {outcome:?}");
    }
    let toml = moving("", &format!("{ACCELEROMETER}\nnoise = {{ gain_spread = 0.03 }}"));
    let mut gains: Vec<_> = (0..1000).map(|seed| first(&format!("seed = {seed}\n{toml}"))[1]).collect();
    let outcome = kolmogorov_smirnov(&mut gains, normal(0.4, 0.4 * 0.03));
    assert!(outcome.fits(), "{outcome:?}");
}

fn heading(heading: f64, compass: &str, top: &str) -> f64 {
    let start = format!("start = {{ heading_rad = {heading:?} }}");
    single(&scene(top, &start, &crate::devices::scene::named("s", &format!("kind = \"compass\"\n{compass}"))))
}

/// A compass (§1.2.2).
#[test]
fn a_compass_reads_the_heading_turned_by_iron_and_by_zones() {
    near(heading(0.5, "", ""), 0.5);
    near(heading(-3.0, "", ""), -3.0);
    let iron =
        "hard_iron_rad = 0.1\nhard_iron_phase_rad = 0.2\nsoft_iron_rad = 0.05\nsoft_iron_phase_rad = 0.3";
    near(heading(0.5, iron, ""), 0.5 + 0.1 * 0.7_f64.sin() + 0.05 * 1.3_f64.sin());
    let zone = |name: &str, x: f64| {
        format!(
            "[[arena.zones]]\nname = \"{name}\"\nx_m = {x:?}\ny_m = 0.0\nradius_m = 1.0\ncompass_offset_rad = 0.3\n"
        )
    };
    near(heading(0.5, "", &zone("a", 0.5)), 0.8);
    near(heading(0.5, "", &(zone("a", 0.5) + &zone("b", -0.5))), 1.1);
    near(heading(0.5, "", &zone("a", 5.0)), 0.5);
    // Readings stay in (−π, π].
    near(heading(3.0, "", &zone("a", 0.0)), 3.3 - TAU);
}

#[test]
fn a_compass_has_normal_noise_that_wraps() {
    let toml = with_sensor("step_ms = 0.05", "kind = \"compass\"\nsigma_rad = 0.02");
    assert_distributed(&mut singles(&toml, SAMPLES), |scale| normal(0.0, 0.02 * scale));
    let south = scene(
        "step_ms = 0.05",
        "start = { heading_rad = 3.141592653589793 }",
        &crate::devices::scene::named("s", "kind = \"compass\"\nsigma_rad = 0.02"),
    );
    let readings = singles(&south, 1000);
    assert!(readings.iter().all(|r| r.abs() <= PI && r.abs() > 3.0), "{readings:?}");
    assert!(readings.iter().any(|r| *r < 0.0) && readings.iter().any(|r| *r > 0.0));
}

#[test]
fn a_compass_on_a_turning_robot_keeps_up() {
    let mut world: World = world(&moving("", "kind = \"compass\""));
    run(&mut world, 50, 0.4, -0.4);
    world.begin();
    near(view(&world, "s").sample[0], world.robot(0).motion().pose.heading);
}
