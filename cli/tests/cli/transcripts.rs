//! `--serial`: what the program of a robot's chip sends, and the summary of a robot that has a program and no brain.

use std::fs;

use serde_json::Value;

use crate::cli::{baudbot, good, place};

const FIRMWARE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/firmware.toml");

#[test]
fn what_a_program_sends_is_the_same_on_every_path_and_in_an_export() {
    let [file, tape] = ["sent.txt", "sent.mcap"].map(place);
    let tape = tape.to_str().unwrap();
    let to_file = format!("robot={}", file.display());
    let run = ["run", FIRMWARE, "--seconds", "2", "--quiet", "--serial"];
    let text = good(&[&run[..], &["robot=-"]].concat());
    for line in text.lines().take(text.matches('\n').count()) {
        let numbers: Vec<u32> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        assert!(numbers.len() == 5 && numbers.iter().all(|&number| number < 1024), "{line}");
    }
    // Each 100 ms, but for the last one, which is on its way.
    assert!((18..=20).contains(&text.matches('\n').count()), "{text}");
    good(&[&run[..], &[&to_file, "--record", tape, "--record-hz", "0"]].concat());
    assert_eq!(fs::read_to_string(&file).unwrap(), text);
    assert_eq!(good(&[&run[..], &["robot=-", "--over", "grpc"]].concat()), text);
    assert_eq!(good(&["export", tape, "--quiet", "--serial", "robot=-"]), text);
    let part = good(&["export", tape, "--quiet", "--serial", "robot=-", "--from-s", "0.5", "--to-s", "0.9"]);
    assert!(text.contains(&part) && (3..=4).contains(&part.matches('\n').count()), "{part}");
}

#[test]
fn the_summary_of_a_program_has_what_it_sent_and_nothing_of_brains() {
    let sent = good(&["run", FIRMWARE, "--seconds", "2", "--quiet", "--serial", "robot=-"]);
    let last = sent[..sent.rfind('\n').unwrap()].lines().next_back().unwrap();
    let text = good(&["run", FIRMWARE, "--seconds", "2"]);
    assert!(text.contains(&format!(" bytes; the last line is \"{last}\"\n")), "{text}");
    for word in ["brain", "cycles  ", "messages", "frames", "turns"] {
        assert!(!text.contains(word), "{word}: {text}");
    }
    let json: Value = serde_json::from_str(&good(&["run", FIRMWARE, "--seconds", "2", "--json"])).unwrap();
    let robot = &json["robots"][0];
    assert_eq!(robot["chip"]["last_line"], last);
    let bytes = robot["uplink"]["bytes"].as_u64().unwrap() as usize;
    assert!((sent.len()..=sent.len() + 2).contains(&bytes), "{bytes} sent, {} arrived", sent.len());
    let wander = good(&["run", "wander", "--seconds", "1"]);
    assert!(wander.contains("  brain ") && wander.contains("messages"), "{wander}");
}

#[test]
fn a_robot_that_sends_nothing_of_its_own_is_refused_with_its_name() {
    let refusal = |args: &[&str]| {
        let (code, _, err) = baudbot(args);
        assert_eq!(code, 2, "{err}");
        err
    };
    let err = refusal(&["run", FIRMWARE, "--seconds", "1", "--serial", "bob=-"]);
    assert!(err.contains("--serial: there is no robot `bob`; there are: `robot`"), "{err}");
    let err = refusal(&["run", "wander", "--seconds", "1", "--serial", "robot=-"]);
    assert!(
        err.contains("--serial: `robot` has no program on its microcontroller")
            && err.contains("give it one"),
        "{err}"
    );
    let err = refusal(&["run", FIRMWARE, "--json", "--serial", "robot=-"]);
    assert!(err.contains("--serial ROBOT=- needs stdout for itself; write the bytes to a file"), "{err}");
    let err = refusal(&["run", FIRMWARE, "--vcd", "robot=-", "--serial", "robot=-"]);
    assert!(err.contains("--vcd ROBOT=- needs stdout for itself"), "{err}");
    let (code, _, err) = baudbot(&["run", FIRMWARE, "--seconds", "1", "--serial", "robot=/dev/full"]);
    assert!(code == 1 && err.contains("cannot write /dev/full"), "{err}");
}
