//! The fingerprints of whole runs, the same on every machine, in debug and release. A change that moves one
//! says why in its commit, and updates the table:
//! `BAUDBOT_PRINT_HASHES=1 cargo test -p baudbot-tests --test golden_hashes -- --nocapture`.

use baudbot_tests::{ARSIM, KHEPERA, Pair, WANDER, crowd, scenario};

/// Scenario, brain, state hash after 1,000 ticks.
const GOLDEN: [(&str, &str, u64); 6] = [
    ("arsim", "constant:left=0.7,right=-0.7", 0x9bacf885806e0a11),
    ("arsim", "navigate", 0x2be022c73ba37387),
    ("wander", "avoid", 0x1913315bf3e993df),
    ("wander", "wander:forward=0.3", 0x0daeaaca2ae121d5),
    ("khepera", "avoid", 0x4eeda8dc7099211f),
    ("crowd", "avoid", 0x17f2de47de88c67b),
];

#[test]
fn every_scenario_has_its_golden_hash_after_1000_ticks() {
    let mut found = Vec::new();
    for (name, brain, _) in GOLDEN {
        let toml = match name {
            "arsim" => ARSIM.to_owned(),
            "wander" => WANDER.to_owned(),
            "khepera" => KHEPERA.to_owned(),
            _ => crowd(&(0..10).map(|i| format!("r{i}")).collect::<Vec<_>>()),
        };
        let mut pair = Pair::new(scenario(&toml, &[]), brain);
        pair.run(1000);
        found.push((name, brain, pair.world.hash()));
    }
    if std::env::var_os("BAUDBOT_PRINT_HASHES").is_some() {
        for (name, brain, hash) in &found {
            println!("    ({name:?}, {brain:?}, {hash:#018x}),");
        }
    }
    assert_eq!(found, GOLDEN);
}
