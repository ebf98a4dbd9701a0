use std::fmt::Write as _;

use baudbot_fit::estimate::{Outcome, Reason, Remark};
use baudbot_sim::World;
use baudbot_sim::sensor::Device;

use crate::common::{Chance, Tally, findings, of, remarks, scenario};

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

/// The same with a sensor of a table of samples, and a coarser converter than its codes.
fn table() -> String {
    let (before, after) = IR.split_once("sensors.ir = ").unwrap();
    let (_, after) = after.split_once('\n').unwrap_or((after, ""));
    format!(
        "{before}sensors.ir = {{ preset = \"khepera-2-ir\", period_ms = 10.0, mount = {{ x_m = 0.0 }} }}\n{after}"
    )
}

/// The readings at some distances of a specimen, which is a seed.
fn log(changes: &[String], specimens: std::ops::Range<u64>, readings: usize) -> String {
    log_of(IR, changes, specimens, readings)
}

fn log_of(toml: &str, changes: &[String], specimens: std::ops::Range<u64>, readings: usize) -> String {
    let mut text = "# experiment: curve\ndistance_mm,value_raw,sensor\n".to_owned();
    for specimen in specimens {
        for (i, distance) in DISTANCES_MM.iter().enumerate() {
            let mut all = changes.to_vec();
            all.push(format!("robots.a.start.x_m={}", -distance / 1e3));
            all.push(format!("seed={specimen}"));
            let all: Vec<_> = all.iter().map(String::as_str).collect();
            let full = if toml == IR { 4095.0 } else { 1023.0 };
            let mut world = World::new(scenario(toml, &all).into());
            // Other readings at each distance, of the same specimen.
            let skipped = i * readings;
            for tick in 0..skipped + readings {
                world.begin();
                if tick >= skipped {
                    let value = full * world.robot(0).sensors().next().unwrap().sample[0];
                    writeln!(text, "{distance},{value:.0},{specimen}").unwrap();
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

/// A distance sensor with a voltage for its output, of a preset.
fn voltage() -> String {
    let (before, after) = IR.split_once("sensors.ir = ").unwrap();
    let (_, after) = after.split_once('\n').unwrap_or((after, ""));
    let sensor = "{ preset = \"gp2d12\", period_ms = 10.0, clock = { period_ms = 10.0, spread_ms = 0.0, latency_ms = 0.0 }, mount = { x_m = 0.0 }, noise = { gain_spread = 0.0, offset_spread = 0.0, additive = 0.0 } }";
    format!("{before}sensors.ir = {sensor}\n{after}")
}

#[test]
fn noise_and_curve_of_a_voltage_are_recovered() {
    let toml = voltage();
    let distances_mm = [100.0, 150.0, 200.0, 300.0, 500.0];
    let mut tally = Tally::default();
    for seed in 1..=10 {
        let additive = Chance::new(seed).between(0.005, 0.03);
        let mut text = "distance_mm,value_v\n".to_owned();
        let (mut curve, mut count) = (Vec::new(), 0);
        for distance in distances_mm {
            let changes = [
                format!("robots.a.sensors.ir.noise.additive={additive}"),
                format!("robots.a.start.x_m={}", -distance / 1e3),
                format!("seed={}", 100 * seed + count),
            ];
            count += 1;
            let changes: Vec<_> = changes.iter().map(String::as_str).collect();
            let scenario = scenario(&toml, &changes);
            let Device::VoltageRanger(ranger) = &scenario.robots[0].sensors.iter().next().unwrap().device
            else {
                panic!("it is one")
            };
            curve.push([distance / 1e3, ranger.voltage_at(distance / 1e3)]);
            let mut world = World::new(scenario.into());
            for tick in 0..60 {
                world.begin();
                // The first measurement of its own clock is not there yet.
                if tick >= 20 {
                    writeln!(text, "{distance},{:.4}", world.robot(0).sensors().next().unwrap().sample[0])
                        .unwrap();
                }
                world.finish(&[]);
            }
        }
        let scenario = scenario(&toml, &[]);
        let found = findings(&scenario, &text, &["sensors.ir.noise.additive"]);
        tally.add(&found, "sensors.ir.noise.additive", additive);
        let [Remark::Curve { sensor, points }] =
            &remarks(&scenario, &text, &["sensors.ir.noise.additive"])[..]
        else {
            panic!("its curve")
        };
        assert_eq!((sensor.as_str(), points.len()), ("ir", curve.len()));
        for (point, expected) in points.iter().zip(curve) {
            assert!(
                point[0] == expected[0] && (point[1] - expected[1]).abs() < 0.02,
                "{point:?} {expected:?}"
            );
        }
    }
    tally.check();
}

#[test]
fn noise_about_a_table_is_recovered() {
    let (toml, mut tally) = (table(), Tally::default());
    for seed in 1..=20 {
        let mut chance = Chance::new(seed);
        let [multiplicative, additive] = [chance.between(0.02, 0.05), chance.between(0.005, 0.02)];
        let uniform = chance.between(0.006, 0.02);
        let noise = "robots.a.sensors.ir.noise";
        let changes = [
            format!(
                "{noise}={{ gain_spread = 0.165, multiplicative = {multiplicative}, additive = {additive} }}"
            ),
            format!("{noise}={{ offset_spread = 0.0323, uniform = {uniform} }}"),
        ];
        let known = scenario(&toml, &[]);
        let normal = log_of(&toml, &changes[..1], seed..seed + 1, 40);
        let path = |field: &str| format!("sensors.ir.noise.{field}");
        let fields = ["multiplicative", "additive"].map(path);
        let found = findings(&known, &normal, &[&fields[0], &fields[1]]);
        tally.add(&found, &fields[0], multiplicative);
        tally.add(&found, &fields[1], additive);
        let even = log_of(&toml, &changes[1..], seed..seed + 1, 15);
        let found = findings(&known, &even, &[&path("uniform")]);
        tally.add(&found, &path("uniform"), uniform);
    }
    tally.check();
}

/// The wall of the log is darker than that of the table: the noise is still that of readings at one distance.
#[test]
fn a_curve_that_is_not_the_table_s_is_no_noise() {
    let (toml, mut tally) = (table(), Tally::default());
    let darker = "[[0.60], [0.21], [0.10], [0.10], [0.08], [0.082], [0.078], [0.071], [0.07], [0.06]]";
    let darker = darker.replace('[', "[[").replace(']', "]]").replacen("[[[[", "[[[", 1);
    let darker = darker.strip_suffix(']').unwrap();
    for seed in 1..=20 {
        let additive = Chance::new(seed).between(0.004, 0.02);
        let changes = [
            format!("robots.a.sensors.ir.lookup.samples={darker}"),
            format!("robots.a.sensors.ir.noise={{ additive = {additive} }}"),
        ];
        let log = log_of(&toml, &changes, seed..seed + 1, 20);
        let found = findings(&scenario(&toml, &[]), &log, &["sensors.ir.noise.additive"]);
        tally.add(&found, "sensors.ir.noise.additive", additive);
    }
    tally.check();
}

#[test]
fn the_spread_about_a_table_is_recovered() {
    let (toml, mut tally) = (table(), Tally::default());
    for seed in 1..=20 {
        let mut chance = Chance::new(seed);
        let [gain, offset] = [chance.between(0.05, 0.2), chance.between(0.01, 0.02)];
        let changes = [format!(
            "robots.a.sensors.ir.noise={{ gain_spread = {gain}, offset_spread = {offset}, uniform = 0.01 }}"
        )];
        let log = log_of(&toml, &changes, 100 * seed..100 * seed + 24, 3);
        let fields = ["sensors.ir.noise.gain_spread", "sensors.ir.noise.offset_spread"];
        let found = findings(&scenario(&toml, &[]), &log, &fields);
        tally.add(&found, fields[0], gain);
        tally.add(&found, fields[1], offset);
    }
    tally.check();
}

#[test]
fn single_readings_tell_no_noise_about_a_table() {
    let toml = table();
    let log = log_of(&toml, &["robots.a.sensors.ir.noise={ additive = 0.02 }".to_owned()], 1..5, 1);
    let found = findings(&scenario(&toml, &[]), &log, &["sensors.ir.noise.additive"]);
    let Outcome::CannotTell(reason) = of(&found, "sensors.ir.noise.additive") else { panic!("{found:?}") };
    assert!(matches!(reason, Reason::TooFew { rows: 0, .. }), "{reason}");
}
