use crate::common::{Chance, Tally, drive, findings, scenario};

const COMPASS: &str = r#"
step_ms = 20.0
[[robots]]
name = "a"
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
link = { kind = "ideal" }
sensors.compass = { kind = "compass", bits = 12, period_ms = 40.0 }
"#;

/// Iron, noise, and the bias of the specimen, of a robot that turns.
#[test]
fn a_compass_is_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let mut chance = Chance::new(seed);
        let [hard, phase, sigma] =
            [chance.between(0.03, 0.3), chance.between(-3.0, 3.0), chance.between(0.01, 0.08)];
        let hidden = |sigma: f64| {
            let changes = [
                format!("seed={seed}"),
                format!("robots.a.sensors.compass.hard_iron_rad={hard}"),
                format!("robots.a.sensors.compass.hard_iron_phase_rad={phase}"),
                format!("robots.a.sensors.compass.noise={{ offset_spread = 0.1, additive = {sigma} }}"),
            ];
            scenario(COMPASS, &changes.each_ref().map(String::as_str))
        };
        let spin = |_| [-0.1, 0.1];
        let log = drive(hidden(sigma), 1000, spin).table(false, true, false, true);
        let found = findings(
            &scenario(COMPASS, &[]),
            &log,
            &["sensors.compass.hard*", "sensors.compass.noise.additive"],
        );
        tally.add(&found, "sensors.compass.hard_iron_rad", hard);
        tally.add(&found, "sensors.compass.hard_iron_phase_rad", phase);
        tally.add(&found, "sensors.compass.noise.additive", sigma);
        tally.add(&found, "bias of compass, in rad", bias(&drive(hidden(0.0), 1000, spin), hard, phase));
    }
    tally.check();
}

/// The bias of the specimen, from a run of the same seed without noise.
fn bias(run: &crate::common::World2Log, hard: f64, phase: f64) -> f64 {
    let row = &run.rows[500];
    let heading = row.pose[2];
    let error = row.readings[0] - heading - hard * (heading + phase).sin();
    (error + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
}
