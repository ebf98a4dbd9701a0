use std::fmt::Write as _;

use baudbot_fit::estimate::{Outcome, Reason};
use baudbot_sim::World;

use crate::common::{Chance, Tally, findings, of, scenario};

/// A robot that stands before a wall; the sensor looks straight ahead from its centre.
const IR: &str = r#"
step_ms = 10.0
[[arena.polygons]]
name = "wall"
closed = true
points_m = [[0.0, -5.0], [1.0, -5.0], [1.0, 5.0], [0.0, 5.0]]

[[robots]]
name = "a"
start = { x_m = -0.1 }
body = { radius_m = 0.005, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
link = { kind = "ideal" }
sensors.ir = { kind = "ir", bits = 12, opening_rad = 0.4, rays = 5, range_m = 0.2, c1_m2 = 0.0005, c2 = 0.0, mount = { x_m = 0.0 } }
"#;

const DISTANCES_MM: [f64; 8] = [20.0, 25.0, 30.0, 40.0, 50.0, 65.0, 80.0, 100.0];

/// What a specimen, which is a seed, reads at some distances.
fn log(changes: &[String], specimens: std::ops::Range<u64>, readings: usize) -> String {
    let mut text = "# experiment: curve\ndistance_mm,value_raw,sensor\n".to_owned();
    for specimen in specimens {
        for (i, distance) in DISTANCES_MM.iter().enumerate() {
            let mut all = changes.to_vec();
            all.push(format!("robots.a.start.x_m={}", -distance / 1e3));
            all.push(format!("seed={specimen}"));
            let all: Vec<_> = all.iter().map(String::as_str).collect();
            let mut world = World::new(scenario(IR, &all).into());
            // Other readings at each distance, of the same specimen.
            let skipped = i * readings;
            for tick in 0..skipped + readings {
                world.begin();
                if tick >= skipped {
                    let value = world.robot(0).sensors().next().unwrap().sample[0];
                    writeln!(text, "{distance},{:.0},{specimen}", value * 4095.0).unwrap();
                }
                world.finish(&[]);
            }
        }
    }
    text
}

#[test]
fn a_curve_and_its_noise_are_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let mut chance = Chance::new(seed);
        let [c1, c2] = [chance.between(0.0001, 0.0003), chance.between(0.02, 0.1)];
        let [multiplicative, additive] = [chance.between(0.01, 0.05), chance.between(0.002, 0.01)];
        let changes = [
            format!("robots.a.sensors.ir.c1_m2={c1}"),
            format!("robots.a.sensors.ir.c2={c2}"),
            format!(
                "robots.a.sensors.ir.noise={{ multiplicative = {multiplicative}, additive = {additive} }}"
            ),
        ];
        let log = log(&changes, seed..seed + 1, 40);
        let fields = ["sensors.ir.c*", "sensors.ir.noise.multiplicative", "sensors.ir.noise.additive"];
        let found = findings(&scenario(IR, &[]), &log, &fields);
        tally.add(&found, "sensors.ir.c1_m2", c1);
        tally.add(&found, "sensors.ir.c2", c2);
        tally.add(&found, "sensors.ir.noise.multiplicative", multiplicative);
        tally.add(&found, "sensors.ir.noise.additive", additive);
    }
    tally.check();
}

#[test]
fn uniform_noise_is_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let uniform = Chance::new(seed).between(0.005, 0.03);
        let log = log(&[format!("robots.a.sensors.ir.noise={{ uniform = {uniform} }}")], seed..seed + 1, 15);
        let found = findings(&scenario(IR, &[]), &log, &["sensors.ir.noise.uniform"]);
        tally.add(&found, "sensors.ir.noise.uniform", uniform);
    }
    tally.check();
}

#[test]
fn the_spread_of_specimens_is_recovered() {
    let mut tally = Tally::default();
    for seed in 1..=20 {
        let mut chance = Chance::new(seed);
        let [gain, offset] = [chance.between(0.05, 0.2), chance.between(0.01, 0.04)];
        let changes = [
            "robots.a.sensors.ir.c2=0.1".to_owned(),
            format!(
                "robots.a.sensors.ir.noise={{ gain_spread = {gain}, offset_spread = {offset}, additive = 0.004 }}"
            ),
        ];
        let log = log(&changes, 100 * seed..100 * seed + 24, 3);
        let fields = ["sensors.ir.noise.gain_spread", "sensors.ir.noise.offset_spread", "sensors.*.c1_m2"];
        let found = findings(&scenario(IR, &[]), &log, &fields);
        tally.add(&found, "sensors.ir.noise.gain_spread", gain);
        tally.add(&found, "sensors.ir.noise.offset_spread", offset);
        tally.add(&found, "sensors.ir.c1_m2", 0.0005);
    }
    tally.check();
}

#[test]
fn one_specimen_tells_no_spread_and_one_distance_no_curve() {
    let changes = ["robots.a.sensors.ir.noise={ additive = 0.004 }".to_owned()];
    let all = log(&changes, 1..2, 15);
    let found = findings(&scenario(IR, &[]), &all, &["sensors.ir.noise.gain_spread"]);
    let spread = of(&found, "sensors.ir.noise.gain_spread");
    assert_eq!(*spread, Outcome::CannotTell(Reason::Specimens { there_are: 1 }));
    let one: Vec<_> =
        all.lines().filter(|line| line.starts_with(['#', 'd']) || line.starts_with("50,")).collect();
    let one = one.join("\n") + &"\n50,900,1".repeat(10);
    let found = findings(&scenario(IR, &[]), &one, &["sensors.ir.c1_m2", "sensors.ir.c2"]);
    let Outcome::CannotTell(Reason::Confounded { with }) = of(&found, "sensors.ir.c1_m2") else {
        panic!("{found:?}")
    };
    assert_eq!(with, "`c2`");
}
