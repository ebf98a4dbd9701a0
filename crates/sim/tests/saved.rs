//! A state by value: the same world is made of it again, with the same future, and what is no such state is refused.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_geometry::Pose;
use baudbot_scenario::Override;
use baudbot_sim::{Input, Intervention, SavedError, World};
use proptest::prelude::*;

/// Goes on for so many ticks; brains send something that is invalid to some firmware.
fn run(world: &mut World, ticks: u64) {
    for _ in 0..ticks {
        let turns = world.begin().to_vec();
        let bytes = [b'D', b',', b'3', b',', b'2', b'\r', world.tick() as u8];
        let inputs: Vec<_> =
            turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: &bytes }).collect();
        world.finish(&inputs);
    }
}

fn again(world: &World) -> World {
    // The scenario is parsed again, as another process does.
    let source = &world.scenario().source;
    let overrides: Vec<_> = source.overrides.iter().map(|text| Override::parse(text).unwrap()).collect();
    let scenario = baudbot_scenario::parse_with(&source.toml, &overrides).unwrap();
    World::load(Arc::new(scenario), &world.save(), world.hash()).unwrap()
}

fn scenarios() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../catalogue/scenarios");
    let files =
        |folder: &Path| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect::<Vec<_>>();
    let mut found = files(&folder);
    found.extend(files(&folder.join("devices")));
    found.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    assert!(found.len() > 20, "{}", found.len());
    found
}

#[test]
fn every_scenario_of_the_project_goes_on_as_it_would_have() {
    let mut tried = 0;
    for path in scenarios() {
        // The scenarios that refer to other files are read by the program, which puts them in place.
        let Ok(scenario) = baudbot_scenario::parse(&fs::read_to_string(&path).unwrap()) else { continue };
        let mut world = World::new(scenario.into());
        run(&mut world, 137);
        let mut loaded = again(&world);
        assert_eq!(loaded.hash(), world.hash(), "{}", path.display());
        run(&mut world, 200);
        run(&mut loaded, 200);
        assert_eq!(loaded.hash(), world.hash(), "{}", path.display());
        tried += 1;
    }
    assert!(tried > 20, "{tried}");
}

const SCENARIO: &str = r#"
[[robots]]
name = "alice"
link = { kind = "uart", baud = 9600 }
body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }
[robots.sensors.compass]
kind = "compass"
bits = 8
period_ms = 10.0
"#;

fn world() -> World {
    let change = Override::parse("robots.alice.link.baud=19200").unwrap();
    World::new(baudbot_scenario::parse_with(SCENARIO, &[change]).unwrap().into())
}

#[test]
fn within_a_tick_and_after_changes_by_hand() {
    let robot = || "alice".to_owned();
    let mut world = world();
    run(&mut world, 5);
    world.intervene(&Intervention::PullCable { robot: robot(), pulled: true }).unwrap();
    run(&mut world, 5);
    world.intervene(&Intervention::PullCable { robot: robot(), pulled: false }).unwrap();
    world.intervene(&Intervention::SetBaud { robot: robot(), baud: 4800 }).unwrap();
    world.intervene(&Intervention::PlaceRobot { robot: robot(), pose: Pose::new(1.0, 2.0, 0.5) }).unwrap();
    world.begin();
    let mut loaded = again(&world);
    assert_eq!(&loaded.scenario().robots, &world.scenario().robots);
    run(&mut world, 50);
    run(&mut loaded, 50);
    assert_eq!(loaded.hash(), world.hash());
    assert_ne!(loaded.hash(), {
        let mut plain = self::world();
        run(&mut plain, 60);
        plain.hash()
    });
}

#[test]
fn what_is_of_another_world_or_damaged_is_refused() {
    let mut world = world();
    run(&mut world, 20);
    let (saved, hash, scenario) = (world.save(), world.hash(), Arc::clone(world.scenario()));
    let load = |saved: &[u8], hash| World::load(Arc::clone(&scenario), saved, hash).map(drop).unwrap_err();
    assert_eq!(load(&saved, hash ^ 1), SavedError::Hash);
    // The error does not contain what would make a forged state good.
    let error = load(&saved, hash ^ 1).to_string();
    assert!(
        !error.contains(&format!("{hash:016x}")) && !error.contains(&format!("{:016x}", hash ^ 1)),
        "{error}"
    );
    assert!(matches!(load(&saved[..saved.len() / 2], hash), SavedError::Unreadable(_)));
    assert_eq!(load(&[&saved[..], &[0]].concat(), hash), SavedError::Other("parts"));
    let other = |toml: &str| {
        let scenario = baudbot_scenario::parse(toml).unwrap();
        World::load(scenario.into(), &saved, hash).map(drop).unwrap_err()
    };
    assert_eq!(other(""), SavedError::Other("robots"));
    let without = SCENARIO.split("[robots.sensors").next().unwrap();
    assert_eq!(other(without), SavedError::Other("sensors"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever is changed in the bytes, they are refused: with an error, and not with a panic.
    #[test]
    fn a_flipped_bit_is_found(place in 0..1_000_000_usize, bit in 0_u32..8) {
        let mut world = world();
        run(&mut world, 20);
        let (mut saved, hash) = (world.save(), world.hash());
        let place = place % saved.len();
        saved[place] ^= 1_u8 << bit;
        prop_assert!(World::load(Arc::clone(world.scenario()), &saved, hash).is_err());
    }
}
