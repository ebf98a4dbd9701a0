//! Turrets, motors and brains on board, through commands as a brain sends them.

use baudbot_sim::{Input, World};

use crate::common::statistics::{SAMPLES, assert_distributed, correlation, kolmogorov_smirnov, normal};
use crate::common::{BODY, run, tick, world};
use crate::devices::scene::{named, near, scene, signals, tick_of, view};

fn turret(more: &str) -> World {
    let actuator = format!(
        "[robots.actuators.head]\nkind = \"turret\"\nmin_rad = -1.0\nmax_rad = 2.0\nrate_rad_s = 4.0\n{more}\n"
    );
    world(&scene("step_ms = 5.0", "", &actuator))
}

fn angles(world: &mut World, ticks: usize, signal: f64) -> Vec<f64> {
    (0..ticks)
        .map(|_| {
            tick_of(world, "r", &[0.0, 0.0, signal]);
            world.robot(0).actuators()[0].angle_rad
        })
        .collect()
}

#[test]
fn a_turret_slews_at_its_rate_to_its_target_and_stays_there() {
    let mut world = turret("frame_ms = 0.0");
    for (i, angle) in angles(&mut world, 120, 1.0).into_iter().enumerate() {
        // The command of a tick acts in it on an ideal link, from the next substep on.
        let steps = i as f64;
        let (low, high) = ((0.02 * steps).min(2.0), (0.02 * (steps + 1.0)).min(2.0));
        assert!(angle >= low - 1e-9 && angle <= high + 1e-9, "tick {i}: {angle}");
    }
    near(angles(&mut world, 1, 1.0)[0], 2.0);
    near(*angles(&mut world, 200, -1.0).last().unwrap(), -1.0);
    near(*angles(&mut world, 200, 0.25).last().unwrap(), 0.5);
}

#[test]
fn a_turret_does_not_move_within_its_dead_band() {
    let mut world = turret("frame_ms = 0.0\ndead_band_rad = 0.1");
    near(*angles(&mut world, 50, 0.04).last().unwrap(), 0.0);
    // The turret goes for 0.12 rad, by 0.02 a tick, and stops when that is near.
    near(*angles(&mut world, 50, 0.06).last().unwrap(), 0.02);
}

#[test]
fn a_turret_obeys_with_its_next_pulse() {
    let mut world = turret("frame_ms = 20.0");
    angles(&mut world, 1, 0.0);
    // Commanded at 5 ms; the next pulse begins at 20 ms, which is tick 4.
    let moves: Vec<_> = angles(&mut world, 5, 1.0).into_iter().map(|angle| angle > 0.0).collect();
    assert_eq!(moves, [false, false, false, true, true]);
    // And it goes on to where that pulse sent it until the one at 40 ms.
    let back: Vec<_> = angles(&mut world, 4, -1.0);
    assert!(back[0] < back[1] && back[2] > back[3], "{back:?}");
}

#[test]
fn wheels_on_a_velocity_regulator_have_their_time_constant() {
    let body = BODY.replace("damping_n_s_m = 15.0", "damping_n_s_m = 0.0");
    let robot = "motors = { kind = \"velocity\", full_speed_m_s = 0.5, gain_n_s = 1.5 }\nlink = { kind = \"uart\", baud = 115200 }";
    let toml = scene("substeps = 100", robot, &named("s", "kind = \"encoders\"\ncounts_per_turn = 600"))
        .replace(BODY, &body);
    let mut world = world(&toml);
    let mut speeds = Vec::new();
    for _ in 0..100 {
        tick(&mut world, 0.5, 0.5);
        speeds.push(world.robot(0).motion().speed_m_s);
    }
    let top = speeds[99];
    assert!((top - 0.25).abs() < 1e-4, "{top}");
    // M / 2AK = 3 / (2 · 10 · 1.5) s: ten ticks take the missing speed to 1/e.
    let left = (top - speeds[30]) / (top - speeds[20]);
    assert!((left - (-1.0_f64).exp()).abs() < 0.003, "{left}");
}

#[test]
fn motors_stop_when_no_command_comes_for_too_long() {
    let mut world = world(&scene("", "motors = { timeout_ms = 100.0 }", ""));
    run(&mut world, 50, 0.5, 0.5);
    assert_eq!(world.robot(0).signals().left, 0.5);
    let silent = |world: &mut World, ticks| {
        for _ in 0..ticks {
            world.begin();
            world.finish(&[]);
        }
        world.robot(0).signals().left
    };
    // The last command came at 490 ms.
    assert_eq!(silent(&mut world, 9), 0.5);
    assert_eq!(silent(&mut world, 2), 0.0);
    assert_eq!(silent(&mut world, 100), 0.0);
    assert!(world.robot(0).motion().speed_m_s.abs() < 0.01);
    run(&mut world, 2, 0.3, 0.3);
    assert_eq!(world.robot(0).signals().left, 0.3);
}

const ONBOARD: &str = "link = { kind = \"onboard\" }\nmicrocontroller = { operations_per_s = 4000.0, ram_bytes = 32 }\n\
                       brain = { operations = 80, memory_bytes = 26 }";

/// Ticks of a brain that thinks as long as its scenario states.
fn think(world: &mut World, ticks: usize) {
    for _ in 0..ticks {
        let turns = world.begin().to_vec();
        let thinking_ns = world.robot(0).spec().thinking_ns;
        let bytes = signals(world.robot(0).spec(), &[0.5, 0.5]);
        let inputs: Vec<_> =
            turns.iter().map(|turn| Input { robot: 0, at: turn.at + thinking_ns, bytes: &bytes }).collect();
        world.finish(&inputs);
    }
}

/// The Boe-Bot of Fig. 1.19 has one processor for all.
#[test]
fn a_brain_on_board_takes_the_microcontrollers_time() {
    let mut world =
        world(&scene("step_ms = 1.0", ONBOARD, &named("c", "kind = \"compass\"\nperiod_ms = 1.0")));
    assert_eq!(world.robot(0).spec().thinking_ns, 20_000_000);
    think(&mut world, 1000);
    let compass = view(&world, "c");
    // Some 50 thoughts of 20 ms a second, a read or two after each.
    assert!((40..120).contains(&compass.samples), "{compass:?}");
    assert!(compass.missed > 880, "{compass:?}");
    let commands = world.robot(0).commands();
    assert!((40..=50).contains(&commands), "{commands}");
    assert!(world.robot(0).motion().speed_m_s > 0.1);
}

#[test]
fn a_brain_elsewhere_does_not() {
    let robot = "brain = { thinking_us = 20000.0 }";
    let mut world = world(&scene("step_ms = 1.0", robot, &named("c", "kind = \"compass\"\nperiod_ms = 1.0")));
    think(&mut world, 1000);
    assert_eq!(view(&world, "c").missed, 0);
}

#[test]
fn a_brain_on_board_waits_for_the_processor_that_is_busy() {
    // Each read takes 30 ms of every 50; a thought of 20 ms fits in between, but not within.
    let sensor = named("c", "kind = \"compass\"\nperiod_ms = 50.0\nacquisition_us = 30000.0");
    let mut world = world(&scene("step_ms = 1.0", ONBOARD, &sensor));
    think(&mut world, 2000);
    let commands = world.robot(0).commands();
    // 2 s hold 20 ms · n + 30 ms · 40 only for n up to 40.
    assert!((30..=41).contains(&commands), "{commands} thoughts of 20 ms beside 40 reads of 30 ms in 2 s");
}

#[test]
fn a_servo_turns_its_wheel_at_the_speed_of_its_pulse() {
    let mut world = world(&scene("", "motors = { kind = \"servo\", lag_ms = 60.0 }", ""));
    run(&mut world, 200, 1.0, 1.0);
    near(
        world.robot(0).motion().speed_m_s,
        0.1 * 48.0 * std::f64::consts::TAU / 60.0 * (1.0 - (-1.98_f64 / 0.06).exp()),
    );
}

/// Steps that obey at once, so that a wheel's way in a tick is in proportion to what its motor got.
fn uneven(noise: &str) -> String {
    let motors = format!(
        "motors = {{ kind = \"stepper\", max_rate_steps_s = 1e6, max_acceleration_steps_s2 = 1e9, {noise} }}"
    );
    scene("step_ms = 0.1", &motors, "")
}

/// The factors on the signals of both wheels in so many ticks.
fn factors(toml: &str, ticks: usize) -> Vec<(f64, f64)> {
    let mut world = world(toml);
    let way_m = 0.5 * 1000.0 * 0.0001 / 1000.0 * std::f64::consts::TAU * 0.1;
    (0..ticks)
        .map(|_| {
            let before = world.robot(0).motion().travel_m;
            run(&mut world, 1, 0.5, 0.5);
            let after = world.robot(0).motion().travel_m;
            ((after.left - before.left) / way_m, (after.right - before.right) / way_m)
        })
        .collect()
}

#[test]
fn motors_run_unevenly_by_a_normal_factor_a_tick() {
    let pairs = factors(&uneven("noise_sigma = 0.05"), SAMPLES / 2);
    assert!(correlation(&pairs).abs() < 0.015, "{}", correlation(&pairs));
    let mut both: Vec<_> = pairs.iter().flat_map(|&(left, right)| [left, right]).collect();
    assert_distributed(&mut both, |scale| normal(1.0, 0.05 * scale));
}

#[test]
fn motors_of_a_make_differ_by_a_normal_factor_that_stays() {
    let toml = uneven("noise_spread = 0.05");
    let mut both = Vec::new();
    for seed in 0..1000 {
        let pairs = factors(&format!("seed = {seed}\n{toml}"), 2);
        assert!(
            (pairs[0].0 - pairs[1].0).abs() < 1e-9 && (pairs[0].1 - pairs[1].1).abs() < 1e-9,
            "{pairs:?}"
        );
        both.extend([pairs[0].0, pairs[0].1]);
    }
    let outcome = kolmogorov_smirnov(&mut both, normal(1.0, 0.05));
    assert!(outcome.fits(), "{outcome:?}");
}
