//! `--timeline` and `diagram`: what happened when, of real runs.

use crate::cli::{baudbot, command, good, place};

/// The error of a run that is refused.
fn refusal(code: i32, args: &[&str]) -> String {
    let (found, _, err) = baudbot(args);
    assert_eq!(found, code, "{err}");
    err
}

#[test]
fn a_run_writes_a_trace_and_is_the_same_run() {
    let path = place("run.pftrace");
    let path = path.to_str().unwrap();
    let with = good(&["run", "--seconds", "2", "--timeline", path, "--json", "--quiet"]);
    let without = good(&["run", "--seconds", "2", "--json", "--quiet"]);
    let hash = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap()["state_hash"].clone();
    assert_eq!(hash(&with), hash(&without));
    let trace = std::fs::read(path).unwrap();
    // Each packet of a trace is a field 1 with a length.
    assert_eq!(trace[0], 0x0a);
    for name in ["ir_left", "cable up", "microcontroller", "brain", "motors"] {
        assert!(trace.windows(name.len()).any(|part| part == name.as_bytes()), "{name}");
    }
    let piped = command(&["run", "--seconds", "2", "--timeline", "-"]).output().unwrap();
    assert!(piped.status.success() && piped.stdout == trace, "the trace alone");
    assert!(String::from_utf8(piped.stderr).unwrap().contains("state hash"), "the summary is on stderr then");
}

#[test]
fn a_trace_has_what_is_on_the_pins_of_a_chip() {
    const FIRMWARE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/firmware.toml");
    let [path, tape] = ["pins.pftrace", "pins-of-trace.mcap"].map(place);
    let [path, tape] = [&path, &tape].map(|path| path.to_str().unwrap());
    let run = ["run", FIRMWARE, "--seconds", "1", "--json", "--quiet"];
    let with = good(&[&run[..], &["--timeline", path, "--record", tape]].concat());
    let hash = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap()["state_hash"].clone();
    assert_eq!(hash(&with), hash(&good(&run)));
    let trace = std::fs::read(path).unwrap();
    for name in [
        "D9 motors.left.pwm",
        "27.7 %, 7.81 kHz",
        "adc2 sensors.ir_front",
        "uart sent",
        "main loop",
        " short rounds, ",
    ] {
        assert!(trace.windows(name.len()).any(|part| part == name.as_bytes()), "{name}");
    }
    assert!(trace.len() < 500_000, "{} bytes", trace.len());
    let exported = place("pins-exported.pftrace");
    good(&["export", tape, "--timeline", exported.to_str().unwrap()]);
    assert!(std::fs::read(exported).unwrap() == trace);
}

#[test]
fn a_trace_that_cannot_be_written_is_an_error_that_names_it() {
    let nowhere = place("nowhere").join("a.pftrace");
    let nowhere = nowhere.to_str().unwrap();
    assert!(
        refusal(1, &["run", "--timeline", nowhere]).starts_with(&format!("error: cannot write {nowhere}: "))
    );
    assert!(refusal(2, &["run", "--json", "--timeline", "-"]).contains("needs stdout for itself"));
    let (code, _, err) = baudbot(&["run", "--seconds", "10", "--timeline", "/dev/full"]);
    assert!(code == 1 && err.contains("cannot write /dev/full"), "{err}");
}

/// The boxes of Fig. 3.2, in microseconds.
#[test]
fn the_third_cycle_of_wander_takes_what_the_documents_say() {
    let svg = good(&["diagram", "wander", "--cycle", "3", "--svg", "-"]);
    assert!(
        svg.contains("take 28.8 ms: longer than the Δt of 10 ms") || svg.contains("take 28.805 ms"),
        "{svg}"
    );
    let table = good(&["diagram", "wander", "--at", "0.04", "--span", "30"]);
    let row = table.lines().find(|line| line.contains("cable up") && line.contains("40.695")).unwrap();
    assert!(row.contains("19.791") && row.contains("readings, 19 bytes"), "{table}");
}

#[test]
fn a_fault_has_a_lane_of_its_own() {
    let fault = "robots.robot.faults=[{ kind = \"cable\", from_s = 1.0, for_s = 0.2 }]";
    let svg = good(&["diagram", "wander", "--set", fault, "--at", "0.95", "--span", "300", "--svg", "-"]);
    assert!(svg.contains("cable out") && svg.contains("lost"), "{svg}");
}
