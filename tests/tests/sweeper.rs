//! The floor-sweeping robot of Section 8.2: a brain of behaviours and utilities, through its cable.

use baudbot_tests::{InProcess, scenario};

const SWEEPER: &str = include_str!("../../catalogue/scenarios/sweeper.toml");

/// The scenario with this seed, for so long, or until the battery is empty.
fn sweep(brain: &str, seed: u64, minutes: u64) -> InProcess {
    let mut local = InProcess::new(scenario(SWEEPER, &[&format!("seed={seed}")]), brain).unwrap();
    local.run(minutes * 6000);
    local
}

fn never_runs_empty(seeds: std::ops::RangeInclusive<u64>, minutes: u64) {
    for seed in seeds {
        let local = sweep("sweeper", seed, minutes);
        let world = &local.world;
        // The hour is over, or it goes on.
        let ending = world.ending().map(ToString::to_string).unwrap_or_default();
        assert!(!ending.contains("battery"), "seed {seed}: {ending}");
        let covered = world.score().covered(&world.scenario().rules).expect("it is counted");
        assert!(covered > 0.6, "seed {seed}: {covered}");
    }
}

#[test]
fn it_sweeps_and_charges_in_time() {
    never_runs_empty(1..=3, 25);
}

/// `cargo test --release -p baudbot-tests --test system sweeper -- --ignored`
#[test]
#[ignore = "takes a minute"]
fn it_never_runs_empty_in_an_hour() {
    never_runs_empty(1..=10, 60);
}

/// The result of `baudbot tune catalogue/experiments/tune-sweeper.toml` with seeds 1 to 3
/// (docs/reference/experiments.md).
const TUNED: &str = "sweeper:motor.sweep.parameters.forward=0.72126,motor.sweep.parameters.turn_probability=0.006575,\
                     motor.turn_away.utility.weights.near=2.289,motor.turn_away.parameters.turn=0.50381,\
                     motor.charge.utility.bias=1.0386,motor.charge.parameters.full=0.6871";

#[test]
fn the_tuned_one_covers_more_than_the_one_set_by_hand_and_is_not_empty() {
    for seed in 301..=302 {
        let covered = |brain: &str| {
            let local = sweep(brain, seed, 30);
            assert!(local.world.ending().is_none(), "seed {seed}: {:?}", local.world.ending());
            local.world.score().covered(&local.world.scenario().rules).expect("it is counted")
        };
        let (by_hand, tuned) = (covered("sweeper"), covered(TUNED));
        assert!(tuned > by_hand + 0.1, "seed {seed}: {by_hand} {tuned}");
    }
}

#[test]
fn who_never_goes_to_the_charger_runs_empty() {
    let local = sweep("sweeper:motor.charge.utility.bias=-2.0", 1, 60);
    let ending = local.world.ending().map(ToString::to_string).expect("it runs empty");
    assert!(ending.contains("battery"), "{ending}");
}
