//! `baudbot budget`: what a control cycle costs.

use serde_json::Value;

use crate::{baudbot, good};

#[test]
fn a_robot_that_does_not_keep_its_step_is_told_why_and_what_would_help() {
    let out = good(&["budget", "wander"]);
    let first = "robot robot: MISSES its deadline of 10 ms: needs 28.805 ms; the bottleneck is the wire up\n";
    assert!(out.starts_with(first), "{out}");
    let squeezed = out.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "wire up 19.792 19.792 19.792 ███",
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
