//! The program `baudbot-bench`. How fast anything is, no test asks.

use std::process::Command;

use serde_json::Value;

/// Runs the program: exit code, stdout, stderr.
fn program(args: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_baudbot-bench")).args(args).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().expect("an exit code"), text(output.stdout), text(output.stderr))
}

/// The shortest measurement.
fn bench(args: &[&str]) -> (i32, String, String) {
    program(&[&["--seconds", "0.001", "--repeats", "2"], args].concat())
}

#[test]
fn a_workload_is_measured_in_a_process_of_its_own_and_told_as_json() {
    let (code, out, err) = bench(&["W1", "--json", "-"]);
    assert_eq!(code, 0, "{err}");
    let all: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(all["debug_build"], cfg!(debug_assertions));
    assert_eq!(err.contains("this is a debug build"), cfg!(debug_assertions), "{err}");
    let names: Vec<_> = all["workloads"].as_array().unwrap().iter().map(|w| &w["workload"]).collect();
    assert_eq!(names, ["W1/onboard", "W1/ideal"]);
    let [onboard, ideal] = [0, 1].map(|i| &all["workloads"][i]);
    assert_eq!(onboard["samples"].as_array().unwrap().len(), 2);
    assert!(onboard["median"].as_f64().unwrap() > 0.0, "{out}");
    assert_ne!(onboard["state_hash"], ideal["state_hash"], "bytes are counted on a cable");
}

#[test]
fn brains_in_another_process_drive_in_lockstep() {
    let (code, out, err) = bench(&["N1", "N3", "--json", "-"]);
    assert_eq!(code, 0, "{err}");
    let all: Value = serde_json::from_str(&out).unwrap();
    let all = all["workloads"].as_array().unwrap();
    let names: Vec<_> = all.iter().map(|own| own["workload"].as_str().unwrap()).collect();
    assert_eq!(names, ["N1", "N1/tls", "N3/connections", "N3/streams", "N3/fleet"], "{out}");
    for own in all {
        let balls = own["beside"]["samples"].as_array().unwrap();
        assert!(balls.len() == 2 && balls.iter().all(|ball| ball["value"].as_f64() > Some(0.0)), "{own}");
    }
}

#[test]
fn a_table_has_a_row_a_workload() {
    let (code, out, err) = bench(&["W3/10"]);
    assert_eq!(code, 0, "{err}");
    assert!(out.starts_with("workload "), "{out}");
    assert!(out.contains("\nW3/10 ") && out.contains("robot-steps/s"), "{out}");
}

#[test]
fn the_workloads_are_listed() {
    let (code, out, _) = program(&["W3", "--list"]);
    assert_eq!((code, out.lines().count()), (0, 3), "{out}");
}

#[test]
fn a_number_of_ticks_gives_a_fingerprint_and_no_figure() {
    let hash = |threads: &str| {
        let (code, out, err) = program(&["W3/100", "--ticks", "20", "--threads", threads]);
        assert_eq!(code, 0, "{err}");
        out.split_whitespace().nth(1).unwrap().to_owned()
    };
    let alone = hash("1");
    assert!(alone.len() == 16 && hash("2") == alone, "{alone}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let refused = |args: &[&str], text: &str| {
        let (code, _, err) = program(args);
        assert_eq!(code, 2, "{args:?}: {err}");
        assert!(err.contains(text), "{args:?}: {err}");
    };
    refused(&["W9"], "error: no workload `W9`; there are: W1/onboard, W1/ideal,");
    refused(&["--seconds", "0"], "must be above 0 and at most 3600, is 0");
    refused(&["N1", "--ticks", "10"], "`N1` has other processes and takes no --ticks; W1 to W4, G and V do");
    refused(&["--repeats", "0"], "0 is not in 1..=1000");
}

#[test]
fn another_program_is_measured_by_turns_and_its_figure_is_read_from_its_output() {
    let (code, out, err) = program(&[
        "beside",
        "echo 2.5 steps/s",
        "W1/onboard",
        "--pairs",
        "3",
        "--seconds",
        "0.001",
        "--pattern",
        "([0-9.]+) steps/s",
        "--json",
        "-",
    ]);
    assert_eq!(code, 0, "{err}");
    let all: Value = serde_json::from_str(&out).unwrap();
    let pairs = all["workloads"][0]["pairs"]["figures"].as_array().unwrap();
    assert!(pairs.len() == 3 && pairs.iter().all(|pair| pair[1] == 2.5), "{out}");
    let ratio = |name: &str| all["workloads"][0][name].as_f64().unwrap();
    assert!(ratio("min") <= ratio("median_ratio") && ratio("median_ratio") <= ratio("max"), "{out}");
    let own =
        format!("{} W1/onboard --seconds 0.001 --repeats 1 --json -", env!("CARGO_BIN_EXE_baudbot-bench"));
    let (code, out, err) = program(&["beside", &own, "W1/onboard", "--pairs", "1", "--seconds", "0.001"]);
    assert!(code == 0 && out.starts_with("W1/onboard: ") && out.contains("1 pairs"), "{out}{err}");
}

#[test]
fn another_program_without_a_figure_is_an_error_with_the_end_of_its_output() {
    let args = ["beside", "echo nothing", "W1/onboard", "--pairs", "1", "--seconds", "0.001"];
    let (code, _, err) = program(&args);
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("`echo nothing` wrote no figure of W1/onboard as baudbot-bench does"), "{err}");
    assert!(err.contains("its output ends with:\nnothing"), "{err}");
    let (code, _, err) = program(&["beside", "true", "W1", "--pattern", "("]);
    assert!(code == 2 && err.contains("error: --pattern: regex parse error"), "{err}");
}
