//! Animals of the notes as robots with a cable.

use baudbot_tests::{Pair, scenario};

const ECOLI: &str = include_str!("../../scenarios/ecoli.toml");

/// The robots' mean distance from the source, before and after so many seconds.
fn distances_m(brain: &str, seed: u64, seconds: u64) -> (f64, f64) {
    let mut pair = Pair::new(scenario(ECOLI, &[&format!("seed={seed}")]), brain).unwrap();
    let mean = |pair: &Pair| {
        let positions = pair.world.robots().map(|robot| robot.motion().pose.position);
        let distances: Vec<_> = positions.map(|at| at.x.hypot(at.y)).collect();
        distances.iter().sum::<f64>() / distances.len() as f64
    };
    let before = mean(&pair);
    pair.run(seconds * 50);
    (before, mean(&pair))
}

/// Fig. 4.2, with bodies, cables and noise: they gather, and those that do not compare do not.
#[test]
fn a_hundred_robots_gather_at_a_scent_as_e_coli_does() {
    let (before, after) = distances_m("ecoli", 1, 120);
    assert!(after < 0.35 * before, "{before} {after}");
    let (before, after) = distances_m("ecoli:gain_hz=0", 1, 120);
    assert!(after > 0.8 * before, "who senses nothing does not gather: {before} {after}");
}
