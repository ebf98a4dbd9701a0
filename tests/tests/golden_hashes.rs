//! The fingerprints of whole runs, the same on every machine, in debug and release. A change that moves one has the
//! reason in its commit, and updates the table: `BAUDBOT_PRINT_HASHES=1 cargo test -p baudbot-tests --test
//! golden_hashes -- --nocapture`.

use baudbot_sim::World;
use baudbot_tests::{ARSIM, InProcess, KHEPERA, WANDER, crowd, scenario};

/// Scenario, brain, state hash after 1,000 ticks.
const GOLDEN: [(&str, &str, u64); 6] = [
    ("arsim", "constant:left=0.7,right=-0.7", 0x6aac6e1bf23d609f),
    ("arsim", "navigate", 0xd14ff56530303bb5),
    ("wander", "avoid", 0x986b919e077e9243),
    ("wander", "wander:forward=0.3", 0x6c2f336de2ceeb5b),
    ("khepera", "avoid", 0x06d58ddb453eb4db),
    ("crowd", "avoid", 0xa2f16396467c5cc9),
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
        let mut local = InProcess::new(scenario(&toml, &[]), brain).unwrap();
        local.run(1000);
        found.push((name, brain, local.world.hash()));
    }
    if std::env::var_os("BAUDBOT_PRINT_HASHES").is_some() {
        for (name, brain, hash) in &found {
            println!("    ({name:?}, {brain:?}, {hash:#018x}),");
        }
    }
    assert_eq!(found, GOLDEN);
}

/// A program on a robot's chip: `catalogue/scenarios/firmware/wander.hex`.
const GOLDEN_CHIP: u64 = 0x1353bc5057d504d8;

#[test]
fn a_program_on_a_robots_chip_has_its_golden_hash_after_1000_ticks() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios"));
    let text = baudbot_import::inline(include_str!("../../catalogue/scenarios/firmware.toml"), folder);
    let mut world = World::new(scenario(&text.unwrap(), &[]).into());
    for _ in 0..1000 {
        world.begin();
        world.finish(&[]);
    }
    let found = world.hash();
    if std::env::var_os("BAUDBOT_PRINT_HASHES").is_some() {
        println!("    const GOLDEN_CHIP: u64 = {found:#018x};");
    }
    assert_eq!(found, GOLDEN_CHIP, "{found:#018x}");
}

/// What a search with `baudbot worst worst-wander` changed in `wander`, and the hash of the end of that run.
const WORST: (&[&str], u64) = (
    &[
        "end.after_s=10.3",
        "robots.robot.link.baud=4800",
        "robots.robot.link.byte_error_rate=0.084",
        "robots.robot.start.heading_rad=-2.2",
    ],
    0x921cdf1ea4fa2f06,
);

#[test]
fn the_run_in_which_a_search_found_a_failure_fails_in_the_same_way_everywhere() {
    let mut local = InProcess::new(scenario(WANDER, WORST.0), "avoid").unwrap();
    while local.world.ending().is_none() {
        local.run(1);
    }
    // As at the end of a run.
    local.world.begin();
    let found = local.world.hash();
    assert!(local.world.robot(0).collided(), "{:?}", local.world.ending());
    assert_eq!(found, WORST.1, "{found:#018x}");
}
