use baudbot_fit::estimate::{Outcome, Reason};

use crate::common::{Chance, Tally, drive, findings, of, scenario};

const ROBOT: &str = r#"
step_ms = 20.0
[[robots]]
name = "a"
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, half_track_m = 0.15 }
motors = { kind = "velocity", gain_n_s = 1.5, full_speed_m_s = 0.5 }
link = { kind = "ideal" }
sensors.encoders = { kind = "encoders", counts_per_turn = 200, bits = 16 }
sensors.odometer = { kind = "odometer", period_ms = 100.0 }
"#;

/// Arcs of both directions, and turns on the spot.
fn arcs(time: f64) -> [f64; 2] {
    match (time / 3.0) as u64 % 4 {
        0 => [0.6, 0.4],
        1 => [-0.2, 0.3],
        2 => [0.3, 0.7],
        _ => [0.4, -0.1],
    }
}

#[test]
fn the_noise_of_an_odometer_is_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let sigma = Chance::new(seed).between(0.0002, 0.003);
        let changes = [format!("seed={seed}"), format!("robots.a.sensors.odometer.sigma_m={sigma}")];
        let mut log = drive(scenario(ROBOT, &changes.each_ref().map(String::as_str)), 1500, arcs);
        // Poses by a camera are noisy, too.
        let mut chance = Chance::new(seed + 50);
        for row in &mut log.rows {
            row.pose = row.pose.map(|pose| pose + chance.normal(0.0005));
        }
        let found = findings(
            &scenario(ROBOT, &[]),
            &log.table(false, true, false, true),
            &["sensors.odometer.sigma_m"],
        );
        tally.add(&found, "sensors.odometer.sigma_m", sigma);
    }
    tally.check();
}

#[test]
fn wheels_are_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let mut chance = Chance::new(seed);
        let [radius, half_track] = [chance.between(0.08, 0.12), chance.between(0.1, 0.2)];
        let changes = [
            format!("seed={seed}"),
            format!("robots.a.body.wheel_radius_m={radius}"),
            format!("robots.a.body.half_track_m={half_track}"),
        ];
        let mut log = drive(scenario(ROBOT, &changes.each_ref().map(String::as_str)), 800, arcs);
        for row in &mut log.rows {
            row.pose = row.pose.map(|pose| pose + chance.normal(0.001));
        }
        let found = findings(&scenario(ROBOT, &[]), &log.table(false, true, false, true), &["body"]);
        tally.add(&found, "body.wheel_radius_m", radius);
        tally.add(&found, "body.half_track_m", half_track);
    }
    tally.check();
}

#[test]
fn lost_marks_are_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let loss = Chance::new(seed).between(0.005, 0.1);
        let changes = [format!("seed={seed}"), format!("robots.a.sensors.encoders.loss={loss}")];
        let log = drive(scenario(ROBOT, &changes.each_ref().map(String::as_str)), 1500, arcs);
        let log = log.table(false, true, false, true);
        tally.add(
            &findings(&scenario(ROBOT, &[]), &log, &["sensors.encoders.loss"]),
            "sensors.encoders.loss",
            loss,
        );
    }
    tally.check();
}

#[test]
fn what_the_log_has_no_truth_for_is_not_told() {
    let log = drive(scenario(ROBOT, &[]), 300, arcs);
    let reason = |log: &str, field: &str| match of(&findings(&scenario(ROBOT, &[]), log, &[field]), field) {
        Outcome::CannotTell(reason) => reason.clone(),
        Outcome::Estimate(estimate) => panic!("{estimate:?}"),
    };
    let blind = log.table(false, false, false, true);
    for field in ["sensors.odometer.sigma_m", "body.wheel_radius_m"] {
        assert!(matches!(reason(&blind, field), Reason::Columns { .. }), "{:?}", reason(&blind, field));
    }
    let both = findings(
        &scenario(ROBOT, &[]),
        &log.table(false, true, false, true),
        &["body", "sensors.encoders.loss"],
    );
    for path in ["body.wheel_radius_m", "sensors.encoders.loss"] {
        assert!(matches!(of(&both, path), Outcome::CannotTell(Reason::Confounded { .. })), "{both:?}");
    }
    let still = drive(scenario(ROBOT, &[]), 300, |_| [0.5, 0.5]).table(false, true, false, true);
    assert_eq!(
        reason(&still, "body.half_track_m"),
        Reason::Excitation { what: "the robot does not turn".into() }
    );
}
