use baudbot_fit::estimate::{Outcome, Reason};

use crate::common::{Chance, Tally, World2Log, drive, findings, of, scenario};

const ROBOT: &str = r#"
step_ms = 10.0
[[robots]]
name = "a"
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
motors = { kind = "velocity", gain_n_s = 1.5, full_speed_m_s = 0.5, max_torque_nm = 5.0 }
link = { kind = "ideal" }
sensors.encoders = { kind = "encoders", counts_per_turn = 1000 }
"#;

/// Signals that change every 0.7 s.
fn steps(seed: u64) -> impl FnMut(f64) -> [f64; 2] {
    let mut chance = Chance::new(seed);
    let mut signals: Vec<[f64; 2]> = Vec::new();
    move |time: f64| {
        let step = (time / 0.7 + 1e-6) as usize;
        while signals.len() <= step {
            signals.push([chance.between(-0.8, 0.8), chance.between(-0.8, 0.8)]);
        }
        signals[step]
    }
}

/// The log of commands that the robot obeys this much later, with noise on the measured speeds and the poses.
fn delayed(seed: u64, changes: &[String], dead_s: f64, sigma: f64) -> World2Log {
    let changes: Vec<_> = changes.iter().map(String::as_str).collect();
    let (mut obeyed, mut logged) = (steps(seed), steps(seed));
    let start = steps(seed)(0.0);
    let command = move |time: f64| if time < dead_s - 1e-9 { start } else { obeyed(time - dead_s + 1e-9) };
    let mut log = drive(scenario(ROBOT, &changes), 800, command);
    let mut chance = Chance::new(seed + 1000);
    for row in &mut log.rows {
        row.command = logged(row.time_s);
        row.speeds = row.speeds.map(|speed| speed + chance.normal(sigma));
        row.pose = row.pose.map(|pose| pose + chance.normal(0.1 * sigma));
    }
    log
}

fn recovered(speeds: bool, sigma: f64, seeds: u64) {
    let mut tally = Tally::default();
    for seed in 1..=seeds {
        let mut chance = Chance::new(500 + seed);
        let [gain, full] = [chance.between(0.6, 3.0), chance.between(0.3, 0.8)];
        // The brain steps each tick.
        let dead_s = 0.01 * chance.between(2.0, 25.0).floor();
        let changes =
            [format!("robots.a.motors.gain_n_s={gain}"), format!("robots.a.motors.full_speed_m_s={full}")];
        let log = delayed(seed, &changes, dead_s, sigma).table(true, !speeds, speeds, false);
        let found = findings(
            &scenario(ROBOT, &[]),
            &log,
            &["motors.dead_time_ms", "motors.gain_n_s", "motors.full_speed_m_s"],
        );
        tally.add(&found, "motors.dead_time_ms", 1e3 * dead_s);
        tally.add(&found, "motors.gain_n_s", gain);
        tally.add(&found, "motors.full_speed_m_s", full);
    }
    tally.check();
}

#[test]
fn dead_time_and_lag_are_recovered_from_speeds() {
    recovered(true, 0.05, 20);
}

/// The gain is missed in three of the first 20 seeds, in eight of 200: 20 are too few to distinguish 17 from 19 here.
#[test]
fn dead_time_and_lag_are_recovered_from_poses() {
    recovered(false, 0.05, 60);
}

#[test]
fn uneven_motors_are_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let sigma = Chance::new(seed).between(0.05, 0.3);
        let changes = [
            format!("seed={seed}"),
            format!("robots.a.motors.noise_sigma={sigma}"),
            "robots.a.motors.gain_n_s=6.0".into(),
        ];
        let changes: Vec<_> = changes.iter().map(String::as_str).collect();
        let log = drive(scenario(ROBOT, &changes), 2500, steps(seed)).table(true, true, false, false);
        let found =
            findings(&scenario(ROBOT, &["robots.a.motors.gain_n_s=6.0"]), &log, &["motors.noise_sigma"]);
        tally.add(&found, "motors.noise_sigma", sigma);
    }
    tally.check();
}

fn reason(log: &str, field: &str) -> Reason {
    let found = findings(&scenario(ROBOT, &[]), log, &[field]);
    match of(&found, field) {
        Outcome::CannotTell(reason) => reason.clone(),
        Outcome::Estimate(estimate) => panic!("{estimate:?}"),
    }
}

#[test]
fn a_constant_command_tells_neither_lag_nor_dead_time() {
    let log = drive(scenario(ROBOT, &[]), 300, |_| [0.5, 0.5]).table(true, true, true, false);
    for field in ["motors.dead_time_ms", "motors.gain_n_s"] {
        assert_eq!(reason(&log, field), Reason::Excitation { what: "the command never changes".into() });
    }
    let rest = drive(scenario(ROBOT, &[]), 300, |_| [0.0; 2]).table(true, true, true, false);
    assert_eq!(
        reason(&rest, "motors.full_speed_m_s"),
        Reason::Excitation { what: "all commands are 0".into() }
    );
    let three: Vec<_> = log.lines().take(4).collect();
    let told = reason(&three.join("\n"), "motors.gain_n_s").to_string();
    assert_eq!(told, "the log has 0 rows with commands, without a gap; 30 are needed");
}

#[test]
fn commands_and_poses_alone_do_not_tell_the_wheels_radius_from_the_full_speed() {
    let log = drive(scenario(ROBOT, &[]), 300, steps(1)).table(true, true, false, false);
    let told = reason(&log, "body.wheel_radius_m").to_string();
    assert!(told.starts_with("confounded with `motors.full_speed_m_s`"), "{told}");
    let spread = reason(&log, "motors.noise_spread");
    assert_eq!(spread, Reason::Specimens { there_are: 1 });
}
