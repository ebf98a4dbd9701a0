//! The scenarios in `catalogue/scenarios/devices` are sound, run without a brain, and run the same way twice. Together they
//! have every device.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use baudbot_scenario::Override;
use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::sensor::SensorKind;
use baudbot_sim::{Scenario, World};

const TICKS: u64 = 200;

#[test]
fn each_runs_for_200_ticks_without_a_brain_and_twice_to_the_same_hash() {
    for (name, text) in files() {
        let scenario = Arc::new(parse(&name, &text));
        let [first, second] = [run(&scenario), run(&scenario)];
        assert_eq!(first.tick(), TICKS, "{name} ended early: {:?}", first.ending());
        assert_eq!(first.hash(), second.hash(), "{name}");
    }
}

#[test]
fn something_happens_in_each() {
    for (name, text) in files() {
        let scenario = Arc::new(parse(&name, &text));
        let (start, end) = (World::new(Arc::clone(&scenario)), run(&scenario));
        let has_moved = start.robots().zip(end.robots()).any(|(a, b)| a.motion().pose != b.motion().pose);
        let has_sampled = end.robots().any(|robot| robot.sensors().any(|sensor| sensor.samples > 0));
        assert!(has_moved || has_sampled, "{name}");
    }
}

#[test]
fn each_is_called_as_its_file_and_says_what_to_try() {
    for (name, text) in files() {
        assert_eq!(parse(&name, &text).name, name);
        let head: Vec<_> = text.lines().take_while(|line| line.starts_with('#')).collect();
        assert!(head.iter().any(|line| line.starts_with("# Try:")), "{name} says nothing to try");
        let command = format!("baudbot run catalogue/scenarios/devices/{name}.toml");
        assert!(head.iter().any(|line| line.contains(&command)), "{name} does not say how to run it");
    }
}

#[test]
fn what_they_say_to_set_can_be_set() {
    let mut found = 0;
    for (name, text) in files() {
        let head: Vec<_> = text.lines().map_while(|line| line.strip_prefix('#')).collect();
        for paragraph in head.split(|line| line.is_empty()) {
            let paragraph = paragraph.concat();
            let sets: Vec<_> = paragraph.split("--set ").skip(1).map(quoted_or_word).collect();
            let changes: Vec<_> = sets.iter().map(|set| Override::parse(set).unwrap()).collect();
            if let Err(error) = baudbot_scenario::parse_with(&text, &changes) {
                panic!("{name} with {sets:?}: {error}");
            }
            found += sets.len();
        }
    }
    assert!(found >= 10, "found only {found}");
}

/// The argument of a command, as a text that goes on behind it.
fn quoted_or_word(text: &str) -> &str {
    if let Some((quoted, _)) = text.strip_prefix('\'').and_then(|text| text.split_once('\'')) {
        return quoted;
    }
    text.split(' ').next().unwrap_or_default().trim_end_matches([',', ';', '.'])
}

#[test]
fn every_device_is_in_one_of_them() {
    let (mut sensors, mut motors, mut actuators) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for (name, text) in files() {
        for robot in &parse(&name, &text).robots {
            sensors.extend(robot.sensors.iter().map(|sensor| sensor.device.kind()));
            motors.insert(robot.drive.motor.kind());
            actuators.extend(robot.actuators.iter().map(baudbot_sim::actuator::Actuator::kind));
        }
    }
    assert_eq!(sensors.len(), SensorKind::ALL.len(), "{sensors:?}");
    assert_eq!(motors, BTreeSet::from(["dc", "servo", "stepper", "velocity"]));
    assert_eq!(actuators, BTreeSet::from(["dispenser", "lamp", "speaker", "turret"]));
}

#[test]
fn every_cable_is_in_one_of_them() {
    let mut cables = BTreeSet::new();
    for (name, text) in files() {
        for robot in &parse(&name, &text).robots {
            let (kind, outages) = match &robot.link {
                Link::Ideal => ("ideal", &[][..]),
                Link::Onboard => ("onboard", &[][..]),
                Link::Usb(usb) => ("usb", &usb.outages[..]),
                Link::Uart(uart) => {
                    cables.insert(match uart.adapter {
                        Adapter::None => "no adapter",
                        Adapter::Cdc(_) => "cdc",
                        Adapter::Ftdi(_) => "ftdi",
                        Adapter::Bluetooth(_) => "bluetooth",
                    });
                    (if uart.turnaround_ns.is_some() { "half duplex" } else { "uart" }, &uart.outages[..])
                }
            };
            cables.insert(kind);
            cables.extend(outages.iter().map(|_| "outages"));
        }
    }
    assert_eq!(cables.len(), 10, "{cables:?}");
}

/// The files' names without ending, and their texts.
fn files() -> Vec<(String, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../catalogue/scenarios/devices");
    let mut files: Vec<_> = fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .map(|path| {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            (name, fs::read_to_string(&path).unwrap())
        })
        .collect();
    files.sort();
    assert!(files.len() >= 20, "found only {}", files.len());
    files
}

fn parse(name: &str, text: &str) -> Scenario {
    baudbot_scenario::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn run(scenario: &Arc<Scenario>) -> World {
    let mut world = World::new(Arc::clone(scenario));
    for _ in 0..TICKS {
        world.begin();
        world.finish(&[]);
    }
    world
}
