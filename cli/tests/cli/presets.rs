//! `baudbot preset`, and scenarios that use presets.

use std::fs;

use serde_json::Value;

use crate::cli::{baudbot, good, place};

fn json(args: &[&str]) -> Value {
    let out = good(args);
    serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"))
}

#[test]
fn all_presets_are_listed_by_kind() {
    let out = good(&["preset"]);
    let place = |part: &str| out.find(part).unwrap_or_else(|| panic!("no `{part}` in:\n{out}"));
    let parts =
        ["robot\n", "  khepera-1 ", "\nsensor\n", "  gp2d12 ", "\nmotors\n", "\nlink\n", "  uart-9600 "];
    assert!(parts.map(place).is_sorted(), "{out}");
    let listed = json(&["preset", "--json"]);
    let listed = listed.as_array().unwrap();
    assert!(listed.len() > 40 && listed.iter().all(|preset| preset["description"].is_string()));
}

#[test]
fn a_preset_is_shown_as_it_is() {
    let out = good(&["preset", "e-puck-stepper"]);
    assert!(
        out.starts_with(
            "# Known: 5 of 7 numbers from a source; agrees with a real one in 13 points.\nkind = \"motors\"\n"
        ),
        "{out}"
    );
    assert!(out.contains("\nsteps_per_turn = 1000.0 # datasheet: e-puck.org, mechanics"), "{out}");
}

#[test]
fn a_presets_values_come_with_their_standing_and_source() {
    let preset = json(&["preset", "urg-04lx", "--json"]);
    assert_eq!((&preset["name"], &preset["kind"]), (&"urg-04lx".into(), &"sensor".into()));
    let values = preset["values"].as_array().unwrap();
    let value = |path: &str| values.iter().find(|value| value["path"] == path).unwrap();
    assert_eq!(value("sensor.rays")["value"], 682);
    assert_eq!(value("sensor.clock.period_ms")["standing"], "datasheet");
    assert!(value("sensor.noise.additive")["source"].as_str().unwrap().contains("3 mm"));
    assert_eq!(value("sensor.kind")["standing"], Value::Null);
}

#[test]
fn a_preset_that_there_is_not_is_refused_with_those_near_it() {
    let (code, out, err) = baudbot(&["preset", "kephera"]);
    assert_eq!((code, out.as_str()), (2, ""));
    let expected = "error: there is no preset `kephera`; did you mean `khepera-1`, `khepera-2`? `baudbot preset` lists all\n";
    assert_eq!(err, expected);
    assert!(baudbot(&["preset", "xyzzyplugh"]).2.ends_with("`xyzzyplugh`; `baudbot preset` lists all\n"));
}

#[test]
fn a_scenario_of_presets_runs_and_can_be_changed() {
    let path = place("presets.toml");
    fs::write(&path, "[[robots]]\nname = \"bob\"\npreset = \"khepera-1\"\nwithout = [\"ir_6\", \"ir_7\"]\n")
        .unwrap();
    let path = path.to_str().unwrap();
    let out = good(&["check", path, "--set", "robots.bob.link.preset=uart-115200"]);
    assert!(out.contains("115200 baud") && out.contains("ir_5") && !out.contains("ir_6"), "{out}");
    let (code, _, err) = baudbot(&["check", path, "--set", "robots.bob.preset=epuc"]);
    assert_eq!(code, 2);
    assert!(err.contains("robots[0].preset: there is no preset `epuc`; did you mean `e-puck`?"), "{err}");
    let (code, _, err) = baudbot(&["check", path, "--set", "robots.bob.sensors.ir_O.period_ms=5"]);
    assert_eq!(code, 2);
    let meant =
        "robots[0].sensors.ir_O: missing field `kind`, which a new sensor needs; did you mean `ir_0`?";
    assert!(err.contains(meant), "{err}");
    good(&["run", path, "--seconds", "1", "--quiet"]);
}
