//! Forged states, fingerprint and all: what is taken up runs on as any other world.
//!
//! `BAUDBOT_FORGED=100000 cargo test --release -p baudbot-sim --test outside forged` tries as many; `BAUDBOT_FORGED_SEED` others, and
//! `BAUDBOT_FORGED_TELL=1` says which one it is at.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use baudbot_sim::random::Stream;
use baudbot_sim::{Input, Intervention, Scenario, World};

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Scenarios with all kinds of devices, cables and things in them.
fn scenarios() -> Vec<(String, Arc<Scenario>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../catalogue/scenarios");
    let files = |folder: &Path| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = files(&root).chain(files(&root.join("devices"))).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    paths.sort();
    let parse = |path: PathBuf| {
        // The scenarios with maps and plans belong to other crates.
        let text = fs::read_to_string(&path).unwrap();
        let program = fs::read_to_string(path.with_file_name("firmware/wander.hex")).unwrap_or_default();
        let text = text.replace("\"firmware/wander.hex\"", &format!("{{ hex = '''\n{program}''' }}"));
        let scenario = baudbot_scenario::parse(&text).ok()?;
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        (scenario.robots.len() <= 4).then(|| (name, scenario.into()))
    };
    let found: Vec<_> = paths.into_iter().filter_map(parse).collect();
    assert!(found.len() > 15, "{}", found.len());
    found
}

fn run(world: &mut World, ticks: u64) {
    for _ in 0..ticks {
        let written = [0x40, 0x01, 0x02, 0x00, b'D', b',', b'1', b',', b'2', b'\n'];
        let turns = world.begin().to_vec();
        let inputs = turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: &written });
        let inputs: Vec<_> = inputs.collect();
        world.finish(&inputs);
        // The views of operators and observers.
        world.robots().for_each(|robot| {
            robot.cycles().durations.quantile_ns(0.5);
            robot.readings().iter().for_each(|reading| drop(reading.values.clone()));
        });
    }
}

/// The fingerprint of a state as its bytes are: it is no secret.
fn fingerprint(saved: &[u8], altered: bool) -> u64 {
    let bytes = if altered { saved } else { &saved[..saved.len() - 1] };
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Some bytes are others, are gone, or are there twice; numbers are as large as they can be.
fn forge(saved: &[u8], chance: &mut Stream) -> Vec<u8> {
    let mut forged = saved.to_vec();
    for _ in 0..=chance.below(2) {
        let at = chance.below(forged.len() as u32) as usize;
        match chance.below(8) {
            0..4 => forged[at] ^= 1 << chance.below(8),
            4 => forged[at] = [0, 1, 2, 0x7f, 0xff][chance.below(5) as usize],
            5 => drop(forged.splice(at..=at, [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01])),
            6 => drop(forged.splice(at..=at, [0xff, 0xff, 0xff, 0xff, 0x0f])),
            _ => {
                // A number of 8 bytes, perhaps.
                let odd = [f64::NAN, f64::INFINITY, f64::MAX, -1e9, 1e9, f64::MIN_POSITIVE];
                let bytes = odd[chance.below(6) as usize].to_le_bytes();
                let until = forged.len().min(at + 8);
                forged[at..until].copy_from_slice(&bytes[..until - at]);
            }
        }
    }
    forged
}

#[test]
fn a_forged_state_is_refused_or_runs_on() {
    let all = setting("BAUDBOT_FORGED", 3_000);
    let mut chance = Stream::new(setting("BAUDBOT_FORGED_SEED", 1), "forged");
    let scenarios = scenarios();
    let share = all / (3 * scenarios.len() as u64) + 1;
    let (mut taken, mut changed, tells) = (0, 0, setting("BAUDBOT_FORGED_TELL", 0) > 0);
    for (name, scenario) in &scenarios {
        let mut world = World::new(Arc::clone(scenario));
        for (ticks, by_hand) in [(7, false), (130, false), (40, true)] {
            run(&mut world, ticks);
            if by_hand {
                change_cables(&mut world);
            }
            world.begin();
            let saved = world.save();
            let altered = fingerprint(&saved, true) == world.hash();
            assert!(altered || fingerprint(&saved, false) == world.hash(), "{name}");
            changed += usize::from(altered);
            assert!(World::load(Arc::clone(scenario), &saved, world.hash()).is_ok(), "{name}");
            for i in 0..share {
                let forged = forge(&saved, &mut chance);
                if tells {
                    // A hanging world prints nothing by itself.
                    eprintln!("{name}, after {ticks} ticks, number {i}: {}", hex(&saved, &forged));
                }
                let load = || {
                    let hash = fingerprint(&forged, altered);
                    let Ok(mut world) = World::load(Arc::clone(scenario), &forged, hash) else {
                        return false;
                    };
                    let length = world.save().len();
                    run(&mut world, 100);
                    let grown = world.save().len();
                    assert!(grown < 2 * length + 100_000, "from {length} to {grown} bytes");
                    true
                };
                match catch_unwind(AssertUnwindSafe(load)) {
                    Ok(is_taken) => taken += u64::from(is_taken),
                    Err(_) => panic!("{name}, after {ticks} ticks, number {i}: {}", hex(&saved, &forged)),
                }
            }
        }
    }
    // Most of what is changed are numbers that might as well be others.
    assert!(taken > all / 10, "{taken} of {all}");
    assert!(changed > 10, "{changed} states with cables that were changed");
}

/// Cables that a state has in place of its scenario's.
fn change_cables(world: &mut World) {
    let robots: Vec<_> = world.robots().map(|robot| robot.spec().name.clone()).collect();
    for robot in robots {
        // A robot without such a cable keeps its own.
        let _ = world.intervene(&Intervention::SetBaud { robot: robot.clone(), baud: 19_200 });
        let _ = world.intervene(&Intervention::PullCable { robot, pulled: true });
    }
}

/// The places at which the forged state differs.
fn hex(saved: &[u8], forged: &[u8]) -> String {
    let at = saved.iter().zip(forged).position(|(a, b)| a != b).unwrap_or_default();
    format!(
        "from byte {at} on: {:02x?}, not {:02x?}",
        &forged[at..forged.len().min(at + 24)],
        &saved[at..saved.len().min(at + 24)]
    )
}
