//! `baudbot budget`: what a control cycle costs.

use serde_json::Value;

use crate::cli::{baudbot, good};

#[test]
fn a_robot_that_does_not_keep_its_step_is_told_why_and_what_would_help() {
    let out = good(&["budget", "wander"]);
    let first =
        "robot robot: MISSES its deadline of 10 ms: needs 28.805 ms; the bottleneck is the cable up\n";
    assert!(out.starts_with(first), "{out}");
    let squeezed = out.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "cable up 19.792 19.792 19.792 ███",
        "whole cycle 28.805 28.805 ",
        "38400 baud (a setting at both ends): ",
        " --set robots.robot.link.baud=38400 ",
    ] {
        assert!(squeezed.contains(part), "no `{part}` in\n{out}");
    }
    let limits: Vec<_> = out.lines().filter(|line| line.ends_with("limits the exchanges")).collect();
    assert!(limits.len() == 1 && limits[0].trim_start().starts_with("frames "), "{out}");
}

#[test]
fn the_mend_mends() {
    let fast = ["budget", "wander", "--set", "robots.robot.link.baud=38400", "--check"];
    let out = good(&fast);
    assert!(out.contains("meets its deadline of 10 ms: 7."), "{out}");
    let (code, out, err) = baudbot(&["budget", "wander", "--check"]);
    assert_eq!((code, err.as_str()), (1, ""), "{out}");
}

#[test]
fn json_has_the_unit_in_each_name() {
    let out = good(&["budget", "khepera", "--json"]);
    let budget: Value = serde_json::from_str(&out).unwrap();
    let robot = &budget["robots"][0];
    assert_eq!((&robot["robot"], &robot["step_ns"]), (&"khepera".into(), &10_000_000.into()));
    assert_eq!(robot["cycle"]["rows"][2]["part"], "wire-up");
    assert_eq!(robot["cycle"]["rows"][2]["typical_ns"], 7_031_250);
    assert_eq!(robot["verdict"], "keeps");
    assert!(robot["rates"][0]["most_per_s"].as_f64().unwrap() <= 100.0);
}

#[test]
fn a_dead_time_of_the_motors_stands_below_the_cycle_and_in_the_json() {
    let robot = ["budget", "wander", "--set", "robots.robot.motors.dead_time_ms=120"];
    let out = good(&robot);
    assert!(
        out.contains("    the motors have a dead time of 120 ms, which comes after the cycle\n"),
        "{out}"
    );
    assert!(!good(&["budget", "wander"]).contains("dead time"), "{out}");
    let json: Value = serde_json::from_str(&good(&[&robot[..], &["--json"]].concat())).unwrap();
    assert_eq!(json["robots"][0]["dead_time_ns"], 120_000_000);
}

#[test]
fn one_robot_can_be_asked_for_and_one_that_there_is_not_is_refused() {
    let out = good(&["budget", "khepera", "--robot", "khepera"]);
    assert_eq!(out.matches("robot khepera: ").count(), 1, "{out}");
    let (code, out, err) = baudbot(&["budget", "khepera", "--robot", "bob"]);
    assert_eq!((code, out.as_str()), (2, ""));
    assert_eq!(err, "error: --robot: there is no robot `bob`; there are: `khepera`\n");
    assert_eq!(baudbot(&["budget", "no-such-file.toml"]).0, 2);
}

const FIRMWARE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/firmware.toml");

#[test]
fn a_program_is_measured_in_a_run_that_is_always_the_same() {
    let measured = ["budget", FIRMWARE, "--seconds", "4", "--json"];
    let text = good(&measured);
    assert_eq!(text, good(&measured));
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["robots"].as_array().unwrap().len(), 0);
    let program = &json["programs"][0];
    assert_eq!(program["round_cycles"]["best"], 11, "{program}");
    // 11 cycles of 62.5 ns.
    assert_eq!(program["round"]["best_ns"], 687);
    let rate = |what: &str| {
        let rates = program["rates"].as_array().unwrap();
        let found = rates.iter().find(|rate| rate["what"] == what);
        found.unwrap_or_else(|| panic!("{what}: {program}"))["per_s"].as_f64().unwrap()
    };
    // Every 20 ms it reads five sensors.
    for sensor in ["sensor ir_left", "sensor ir_front", "sensor ir_right"] {
        assert!((rate(sensor) - 50.0).abs() < 1.0, "{program}");
    }
    assert!((rate("conversions of the ADC") - 250.0).abs() < 5.0, "{program}");
    // 13 periods of 128 cycles for each voltage, and what it computes.
    let way = &program["readings_to_motors"];
    let [best, typical] = ["best_ns", "typical_ns"].map(|key| way[key].as_f64().unwrap() / 1e6);
    assert!(best > 0.4 && typical < 1.5, "{way}");
    let uplink = &program["loads"][0];
    let [bytes, most] = ["bytes_per_s", "most_bytes_per_s"].map(|key| uplink[key].as_f64().unwrap());
    assert!((most - 960.0).abs() < 1.0 && bytes > 100.0 && bytes < 300.0, "{uplink}");
    assert!((uplink["share"].as_f64().unwrap() - bytes / most).abs() < 1e-12);
}

#[test]
fn the_text_about_a_program_has_its_rounds_its_way_to_the_motors_and_its_cable() {
    let out = good(&["budget", FIRMWARE, "--seconds", "2"]);
    assert!(out.starts_with("robot robot: mostly meets its deadline of "), "{out}");
    for part in [
        "round of the main loop",
        "from the readings to the motors",
        "sensor ir_front",
        "age of readings when the motors change",
        " of 960 bytes a second",
        "processor",
    ] {
        assert!(out.contains(part), "no `{part}` in\n{out}");
    }
}

#[test]
fn what_is_not_there_for_programs_is_refused_with_what_is() {
    let (code, _, err) = baudbot(&["budget", FIRMWARE, "--svg", "-"]);
    assert!(code == 2 && err.contains("--vcd robot=FILE"), "{err}");
    let (code, _, err) = baudbot(&["budget", FIRMWARE, "--seconds", "0"]);
    assert!(code == 2 && err.contains("above 0"), "{err}");
}

/// Three compasses at 9600 baud, and a brain that is to answer within 13 ms.
const COMPASSES: &str = include_str!("../../../crates/scenario/tests/budget/every_tick.toml");

/// A verdict holds for the brain that it names, and a run reports a brain that differed from the assumption.
#[test]
fn a_verdict_names_its_brain_and_a_run_counts_what_that_did_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("compasses.toml");
    std::fs::write(&file, COMPASSES).unwrap();
    let file = file.to_str().unwrap();
    let lines = |arguments: &[&str]| -> Vec<String> {
        let out = good(&[&["budget", file][..], arguments].concat());
        out.lines().take(2).map(str::to_owned).collect()
    };
    let [program, wander] = [["--brain", "exec:true"], ["--brain", "wander"]].map(|brain| lines(&brain));
    assert!(program[0].contains(": meets its deadline of 13 ms: "), "{program:?}");
    assert_eq!(
        program[1],
        "  holds if its brain, `exec:true`, answers each message once and writes nothing else"
    );
    assert!(wander[0].contains(": meets its deadline of 13 ms: "), "{wander:?}");
    assert_eq!(
        wander[1],
        "  holds if its brain, `wander`, writes at most once a tick, and not before its last command is off the cable"
    );
    let blind = lines(&["--writes", "every-tick"]);
    assert!(blind[0].contains(": mostly meets its deadline of 13 ms: "), "{blind:?}");
    assert!(blind[1].ends_with("writes at most once a tick, whether or not a message has come"), "{blind:?}");
    assert!(baudbot(&["budget", file, "--writes", "often"]).2.contains("must be \"on-message\""));

    let run = |stated: &[&str]| -> Value {
        let run = ["run", file, "--brain", "wander", "--seconds", "10", "--json"];
        let out: Value = serde_json::from_str(&good(&[&run[..], stated].concat())).unwrap();
        out["robots"][0]["cycles"].clone()
    };
    let cycles = run(&[]);
    assert_eq!((&cycles["late"], &cycles["writes"]), (&0.into(), &"when-free".into()));
    assert_eq!((&cycles["unstated_writes"], &cycles["disturbed"]), (&0.into(), &0.into()));
    // The brain repeats its command now and then without a message, which this setting excludes.
    let cycles = run(&["--set", "robots.robot.brain.writes=\"on-message\""]);
    assert_eq!((&cycles["late"], &cycles["writes"]), (&0.into(), &"on-message".into()));
    assert!(
        cycles["unstated_writes"].as_u64() > Some(0) && cycles["disturbed"].as_u64() > Some(0),
        "{cycles}"
    );
}
