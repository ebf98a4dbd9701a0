//! Failures that are rare, with a probability that is known: a robot stands before a wall, and each pulse of its sonar that brings no echo
//! makes it drive on until the next. With n pulses, each lost with probability p, it comes too near if k of them are lost: the tail of a
//! binomial distribution.

use super::*;
use crate::worst::Likelihood;
use crate::{Limit, worst};

/// 40 pulses, of which each lets the robot drive 2.5 cm if its echo is lost.
const SCENARIO: &str = r#"
step_ms = 10.0
substeps = 10
[[arena.polygons]]
name = "wall"
solid = false
closed = false
points_m = [[0.4, -1.0], [0.4, 1.0]]
[[robots]]
name = "alice"
link = { kind = "onboard" }
firmware = { protocol = "framed", mode = "stream", period_ms = 50.0 }
[robots.body]
radius_m = 0.1
mass_kg = 1.0
inertia_kg_m2 = 0.005
wheel_radius_m = 0.03
[robots.motors]
kind = "velocity"
full_speed_m_s = 0.5
# Its motors' controller wants them; the brain does not.
[robots.sensors.encoders]
kind = "encoders"
counts_per_turn = 600
bits = 16
period_ms = 50.0
[robots.sensors.sonar]
kind = "sonar"
bearing_rad = 0.0
opening_rad = 0.0
rays = 1
min_m = 0.01
max_m = 4.0
sound_m_s = 100000.0
period_ms = 50.0
detection = 0.98
"#;

/// Full speed if the sonar hears nothing within two metres, and none if it does.
const BRAIN: &str = r#"
description = "drives while nothing is near"
[policy]
offset = [0.0, 0.0, 2.0]
layers = [[[0.0, 0.0, 100.0, 0.0]], [[10.0, 10.0], [10.0, 10.0]]]
"#;

/// The probability that of 40 pulses at least so many are lost.
fn truth(least: u64) -> f64 {
    let chance = |lost: u64| {
        let ways = (0..lost).fold(1.0, |ways, i| ways * (40 - i) as f64 / (i + 1) as f64);
        ways * 0.02_f64.powi(lost as i32) * 0.98_f64.powi(40 - lost as i32)
    };
    (least..=40).map(chance).sum()
}

/// The estimate of the probability that so many are lost.
fn estimated(name: &str, least: u64, seed: u64, (particles, repeats): (u64, u64)) -> Likelihood {
    let out = folder(name);
    std::fs::create_dir_all(&out).unwrap();
    let brain = out.join("brain.toml");
    std::fs::write(&brain, BRAIN).unwrap();
    // Half a length less than so many lost pulses bring it.
    let clearance_m = 0.3 - 0.025 * (least as f64 - 0.5);
    let toml = format!(
        "scenario = \"wall\"\nbrains = [\"alice={}\"]\nseconds = 2.0\n[require]\nalways = \"clearance_m > {clearance_m}\"\n\
         [worst]\nmethod = \"splitting\"\nparticles = {particles}\nrepeats = {repeats}\nseed = {seed}\n",
        brain.display()
    );
    let experiment = Experiment::parse(&toml, "rare", |_| Ok(SCENARIO.to_owned())).unwrap();
    let limit = Limit { runs: None, within: None, first: false };
    let found = worst(&experiment, &options(&out.join("out")), limit).unwrap();
    let _ = std::fs::remove_dir_all(out);
    found.likelihood.unwrap()
}

#[test]
fn a_robot_whose_sonar_loses_echoes_comes_too_near_as_often_as_is_known() {
    for (least, around) in [(4, 1e-2), (6, 1e-4), (8, 1e-6)] {
        let truth = truth(least);
        assert!((around / 3.0..around * 3.0).contains(&truth), "{truth}");
        let found = estimated(&format!("rare-{least}"), least, 1, (100, 6));
        assert!((0.4..2.5).contains(&(found.probability / truth)), "{truth} {found:?}");
    }
}

#[test]
fn the_interval_of_an_estimate_holds_the_truth_in_19_of_20_trials() {
    for least in [4, 6, 8] {
        let truth = truth(least);
        let mut held = 0;
        let mut runs = 0;
        for seed in 1..=20 {
            let found = estimated(&format!("rare-{least}-{seed}"), least, seed, (100, 10));
            let (low, high) = found.interval;
            held += u32::from((low..=high).contains(&truth));
            runs += found.runs;
        }
        println!("{least}: {truth:.3e}, held in {held} of 20, {} runs a trial", runs / 20);
        // Fewer of 20 intervals of 95 % hold the truth with a probability of 1.6 %.
        assert!(held >= 17, "{least}: {held}");
    }
}
