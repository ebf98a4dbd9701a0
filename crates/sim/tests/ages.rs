//! The instants at which the readings at the laptop were sampled: observers get those from which the brain's ages are
//! counted, over all protocols and cables.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use baudbot_sim::{Histogram, Input, World};

/// Something of each protocol: a command of frames, speeds and questions of a Khepera.
const WRITTEN: &[u8] = b"\x40\x01\x02\x00D,1,2\nN\nH\n";

fn scenarios() -> BTreeMap<String, World> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../catalogue/scenarios");
    let files = |folder: &Path| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = files(&folder).chain(files(&folder.join("devices")));
    let world = |path: std::path::PathBuf| {
        // Maps and programs are for the import.
        let scenario = baudbot_scenario::parse(&fs::read_to_string(&path).ok()?).ok()?;
        (scenario.robots.len() <= 4).then(|| (path.display().to_string(), World::new(scenario.into())))
    };
    files.filter_map(world).collect()
}

#[test]
fn observers_are_told_of_the_sample_that_the_brain_is_given() {
    let (mut told, mut sensors) = (0, 0);
    for (name, mut world) in scenarios() {
        let mut ages = BTreeMap::<_, Histogram>::new();
        for _ in 0..300 {
            let turns = world.begin().to_vec();
            for turn in &turns {
                let robot = world.robot(turn.robot);
                let readings = robot.readings().iter().enumerate().filter(|(_, reading)| reading.readable);
                for (i, _) in readings {
                    if let Some(sampled_at) = robot.heard(i).sampled_at {
                        ages.entry((turn.robot, i)).or_default().note(turn.at.since(sampled_at));
                    }
                }
            }
            let inputs = turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: WRITTEN });
            world.finish(&inputs.collect::<Vec<_>>());
        }
        for (place, robot) in world.robots().enumerate() {
            for (i, sensor) in robot.sensors().enumerate() {
                let given = &sensor.freshness.ages;
                let shown = ages.remove(&(place, i)).unwrap_or_default();
                assert_eq!(&shown, given, "{name}, robot {place}, sensor {i}");
                told += given.count();
                sensors += u64::from(given.count() > 0);
            }
        }
    }
    assert!(told > 10_000 && sensors > 100, "{told} readings of {sensors} sensors");
}
