//! `baudbot run --over`: a run is the same on both of its paths.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::cli::{Running, baudbot, command, good, place, said};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The report of a run that goes this way, as JSON. Warnings are no matter.
fn run(over: &str, args: &[&str]) -> Value {
    let all = [&["run", "--over", over, "--json", "--quiet"], args].concat();
    let (code, out, err) = said(command(&all).current_dir(ROOT).output().unwrap());
    assert_eq!(code, 0, "{args:?}: {err}");
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(summary["over"], over);
    summary
}

/// The summary of a run, which must be the same on both paths but for times of the wall clock.
fn same(args: &[&str]) -> Value {
    let [direct, grpc] = ["direct", "grpc"].map(|over| {
        let mut summary = run(over, args);
        let told = summary.as_object_mut().unwrap();
        for key in ["over", "wall_s", "simulated_per_wall"] {
            told.remove(key).unwrap();
        }
        told["lockstep"].as_object_mut().unwrap().remove("waiting_s").unwrap();
        summary
    });
    assert_eq!(direct, grpc, "{args:?}");
    direct
}

/// The arguments of the runs that a page shows, without what they write and without their ends.
fn runs_of(page: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(Path::new(ROOT).join(page)).unwrap();
    let commands = text.split('`').filter(|code| code.starts_with("run "));
    let without = |command: &str| {
        let mut words = command.split_whitespace().skip(1);
        let mut kept = Vec::new();
        while let Some(word) = words.next() {
            match word {
                "--seconds" | "--record" | "--record-hz" | "--pace" => drop(words.next()),
                _ => kept.push(word.to_owned()),
            }
        }
        kept
    };
    commands.map(without).collect()
}

#[test]
fn the_runs_of_the_gallery_are_the_same() {
    let mut runs = runs_of("docs/gallery.md");
    runs.sort();
    runs.dedup();
    assert!(runs.len() >= 15, "{runs:?}");
    for run in runs {
        let run: Vec<_> = run.iter().map(String::as_str).collect();
        let summary = same(&[&run[..], &["--seconds", "8"]].concat());
        assert!(summary["robots"][0]["turns"].as_u64().unwrap() > 0, "{run:?}");
    }
}

#[test]
fn the_runs_of_all_scenarios_are_the_same() {
    for name in ["arsim", "khepera", "wander"] {
        same(&[name, "--seconds", "20"]);
        same(&[name, "--seconds", "20", "--brain", "none"]);
    }
    let mut scenarios = 0;
    for folder in ["catalogue/scenarios", "catalogue/scenarios/devices"] {
        for entry in std::fs::read_dir(Path::new(ROOT).join(folder)).unwrap() {
            let entry = entry.unwrap();
            let name = entry.file_name().into_string().unwrap();
            if name.ends_with(".toml") {
                let has_program = std::fs::read_to_string(entry.path()).unwrap().contains("\nprogram = ");
                let brain = if has_program { "none" } else { "wander" };
                same(&[&format!("{folder}/{name}"), "--brain", brain, "--seconds", "5"]);
                scenarios += 1;
            }
        }
    }
    assert!(scenarios > 40, "{scenarios}");
}

/// Two robots on each other's way, one of which thinks for longer than a tick; a third has no brain.
const CREW: &str = r#"
    collision = "stop-robot"
    arena.circles = [{ name = "pillar", x_m = 3.0, y_m = 0.0, radius_m = 0.5 }]

    [[robots]]
    name = "alice"
    body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }
    link = { kind = "uart", baud = 9600 }
    brain.thinking_us = 23_000.0
    sensors.front = { kind = "ir", bearing_rad = 0.0, rays = 3, opening_rad = 0.2, range_m = 1.0, c1_m2 = 0.03, c2 = 0.1 }

    [[robots]]
    name = "bob"
    start = { x_m = 1.0, heading_rad = 3.0 }
    body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }
    link = { kind = "onboard" }
    microcontroller.operations_per_s = 4000.0
    brain.operations = 120
    sensors.front = { kind = "ir", bearing_rad = 0.0, rays = 3, opening_rad = 0.2, range_m = 1.0, c1_m2 = 0.03, c2 = 0.1 }

    [[robots]]
    name = "carol"
    start = { x_m = 0.0, y_m = 1.0 }
    body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }
"#;

#[test]
fn several_brains_and_robots_without_one_are_the_same() {
    let path = place("crew.toml");
    std::fs::write(&path, CREW).unwrap();
    let path = path.to_str().unwrap();
    let brains = ["--brain", "alice=avoid", "--brain", "bob=wander", "--brain", "none"];
    let summary = same(&[&[path, "--seconds", "20"], &brains[..]].concat());
    let brain = |robot: usize| summary["robots"][robot]["brain"].as_str().unwrap().to_owned();
    assert_eq!([brain(0), brain(1), brain(2)], ["avoid", "wander", ""]);
    let commands = |robot: usize| summary["robots"][robot]["commands"].as_u64().unwrap();
    assert!(commands(0) > 0 && commands(1) > 0 && commands(2) == 0, "{summary}");
}

#[test]
fn brains_that_poll_are_the_same() {
    let polled = ["--set", "robots.robot.firmware.mode=\"poll\"", "--seconds", "10"];
    let summary = same(&[&["arsim", "--brain", "navigate"], &polled[..]].concat());
    assert!(summary["robots"][0]["commands"].as_u64().unwrap() > 0, "{summary}");
    let down = &summary["robots"][0]["downlink"];
    assert!(down["messages"].as_u64() > summary["robots"][0]["commands"].as_u64(), "polls, too: {down}");
}

#[test]
fn tables_and_traces_are_the_same_to_the_last_byte() {
    for (scenario, brain) in
        [("wander", "avoid"), ("khepera", "avoid"), ("catalogue/scenarios/explore-room.toml", "explore")]
    {
        let files = ["direct", "grpc"].map(|over| {
            let [csv, trace] = ["csv", "pftrace"].map(|end| place(&format!("path-{over}.{end}")));
            let [to_csv, to_trace] = [&csv, &trace].map(|path| path.to_str().unwrap());
            run(
                over,
                &[scenario, "--brain", brain, "--seconds", "5", "--csv", to_csv, "--timeline", to_trace],
            );
            [csv, trace].map(|path| std::fs::read(path).unwrap())
        });
        assert!(files[0].iter().all(|file| file.len() > 1000));
        assert!(files[0] == files[1], "{scenario}");
    }
}

#[test]
fn recordings_are_the_same_and_replay_as_identical() {
    let exports = ["direct", "grpc"].map(|over| {
        let path = place(&format!("path-{over}.mcap"));
        let file = path.to_str().unwrap();
        let room = ["catalogue/scenarios/explore-room.toml", "--brain", "explore", "--seconds", "3"];
        let summary = run(over, &[&room[..], &["--record", file, "--record-hz", "100"]].concat());
        assert_eq!(summary["recording"]["ticks"], 300);
        let (replayed, hash) = (good(&["replay", file, "--quiet"]), summary["state_hash"].as_str().unwrap());
        assert!(replayed.ends_with(&format!("\nidentical: state hash {hash}\n")), "{over}: {replayed}");
        ["--csv", "--events", "--beliefs-csv"].map(|table| good(&["export", file, table, "-"]))
    });
    assert!(exports[0][1].contains("`explore` drives `robot`"), "{}", exports[0][1]);
    assert!(exports[0][2].lines().count() > 100, "{}", exports[0][2]);
    assert!(exports[0] == exports[1]);
}

#[test]
fn which_path_it_was_is_told() {
    let out = good(&["run", "--seconds", "1"]);
    assert!(out.contains("\npath        direct: the world and its brains on one thread\n"), "{out}");
    let out = good(&["run", "--seconds", "1", "--over", "grpc"]);
    assert!(out.contains("\npath        over gRPC: "), "{out}");
    let out = good(&["run", "--seconds", "1", "--pace", "free"]);
    assert!(out.contains("\npath        over gRPC: "), "{out}");
    let (code, _, err) = baudbot(&["run", "--over", "direct", "--lookahead", "off"]);
    assert_eq!(code, 2);
    assert!(err.starts_with("error: --over direct and --lookahead exclude each other: "), "{err}");
}

#[test]
fn ctrl_c_ends_a_direct_run_and_keeps_what_was_done() {
    let [csv, recording] = ["direct-interrupted.csv", "direct-interrupted.mcap"].map(place);
    let [to_csv, to_recording] = [&csv, &recording].map(|path| path.to_str().unwrap());
    let args = ["run", "--seconds", "1e6", "--over", "direct", "--json"];
    let run = Running::start(&[&args[..], &["--csv", to_csv, "--record", to_recording]].concat());
    let begun = Instant::now();
    while std::fs::metadata(&csv).map_or(0, |file| file.len()) < 100_000 {
        assert!(begun.elapsed() < Duration::from_secs(20), "the world does not start");
        std::thread::sleep(Duration::from_millis(5));
    }
    run.signal("-INT");
    let (code, out, _) = run.end();
    assert_eq!(code, 130);
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&summary["interrupted"], &summary["over"]), (&Value::Bool(true), &Value::from("direct")));
    let table = std::fs::read_to_string(&csv).unwrap();
    assert!(table.ends_with('\n'));
    assert_eq!(table.lines().count() as u64 - 1, summary["ticks"].as_u64().unwrap());
    let replayed = good(&["replay", to_recording, "--quiet"]);
    let hash = summary["state_hash"].as_str().unwrap();
    assert!(replayed.ends_with(&format!("\nidentical: state hash {hash}\n")), "{replayed}");
}
