//! `baudbot umbmark`.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use crate::cli::{baudbot, good, place};

const ARSIM: &str = "arsim";

/// A robot of 0.34 m between the wheels, with fine encoders; `more` is of its body, and `sensors` are its sensors.
fn scenario(name: &str, more: &str, sensors: &str) -> PathBuf {
    let path = place(name);
    let body =
        "radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.06, wheel_radius_m = 0.05, half_track_m = 0.17";
    let toml = format!(
        "step_ms = 10.0\n\
         [[arena.polygons]]\nname = \"cell\"\nsolid = false\npoints_m = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]\n\
         [[robots]]\nname = \"robot\"\nstart = {{ x_m = 0.1, heading_rad = 1.0 }}\nbody = {{ {body}{more} }}\n\
         motors = {{ kind = \"velocity\", gain_n_s = 0.5, max_torque_nm = 0.5, full_speed_m_s = 0.5 }}\n{sensors}"
    );
    fs::write(&path, toml).unwrap();
    path
}

const ENCODERS: &str = "[robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 20000\nbits = 32\n";

fn found(path: &str, more: &[&str]) -> Value {
    let args = [&["umbmark", path, "--runs", "1", "--json"], more].concat();
    serde_json::from_str(&good(&args)).unwrap()
}

#[track_caller]
fn assert_recovered(found: &Value, name: &str, injected: f64) {
    let value = found["corrected"][name].as_f64().unwrap();
    let error = (value - injected).abs();
    // Of the deviation, and that is of a value by far less.
    assert!(error <= 0.01 * (injected - 1.0).abs(), "{name}: {value} is not {injected}");
    assert!((found["truth"][name].as_f64().unwrap() - injected).abs() < 1e-12);
}

/// E_b and E_d that were injected are found, to a hundredth of what they are from 1, after the second measurement; and the
/// correction is worth more than the tenfold that the paper's robots gained.
#[test]
fn injected_errors_of_wheels_are_recovered_and_the_correction_is_worth_it() {
    let path = scenario("umbmark.toml", ", wheel_ratio = 1.002, track_ratio = 1.02", ENCODERS);
    let found = found(path.to_str().unwrap(), &["--check"]);
    assert_recovered(&found, "wheel_ratio", 1.002);
    assert_recovered(&found, "track_ratio", 1.02);
    let [before, after] = [0, 1].map(|i| found["measurements"][i]["e_max_syst_m"].as_f64().unwrap());
    println!("E_max,syst {before} m before, {after} m after");
    assert!(before > 0.1 && after < 0.1 * before, "{before} m, then {after} m");
    // The first measurement alone has each value to a hundredth of a percent or so.
    for (name, injected) in [("wheel_ratio", 1.002), ("track_ratio", 1.02)] {
        let first = found["measurements"][0][name].as_f64().unwrap();
        assert!((first / injected - 1.0).abs() < 0.002, "{name}: {first}");
    }
}

#[test]
fn an_odometer_is_corrected_as_encoders_are() {
    let odometer = "[robots.sensors.odometer]\nkind = \"odometer\"\nbits = 32\n";
    let sensors = format!("{ENCODERS}{odometer}");
    let path = scenario("umbmark-odometer.toml", ", wheel_ratio = 0.998, track_ratio = 0.99", &sensors);
    let found = found(path.to_str().unwrap(), &["--check", "--side-m", "2", "--sensor", "odometer"]);
    assert_eq!(found["sensor"], "odometer");
    let [before, after] = [0, 1].map(|i| found["measurements"][i]["e_max_syst_m"].as_f64().unwrap());
    assert!(after < 0.1 * before, "{before} m, then {after} m");
}

#[test]
fn the_table_has_every_run_and_the_picture_every_end() {
    let path = scenario("umbmark-table.toml", ", track_ratio = 1.01", ENCODERS);
    let svg = place("umbmark.svg");
    let path = path.to_str().unwrap();
    let words = good(&["umbmark", path, "--runs", "2", "--side-m", "1", "--svg", svg.to_str().unwrap()]);
    for part in [
        "robot   robot, steering by `encoders`",
        "arena   empty and unbounded, in place of the scenario's",
        "cw 2",
        "ccw, centre of gravity",
        "E_max,syst  ",
        "in a brain    wheel_factors = [",
        "the scenario  E_d 1.000000 (found ",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let svg = fs::read_to_string(svg).unwrap();
    assert!(svg.contains("UMBmark of robot") && svg.matches(">counter-clockwise: ").count() == 2, "{svg}");
}

#[test]
fn the_same_command_says_the_same() {
    let args = ["umbmark", ARSIM, "--runs", "1", "--side-m", "0.5", "--seed", "3"];
    assert_eq!(good(&args), good(&args));
}

#[test]
fn robots_that_cannot_drive_a_square_are_refused_with_words() {
    let refused = |path: &str, more: &[&str]| {
        let (code, _, err) = baudbot(&[&["umbmark", path], more].concat());
        assert_eq!(code, 2, "{err}");
        err
    };
    // Servos need no encoders.
    let blind = scenario("umbmark-blind.toml", "", "");
    let toml = fs::read_to_string(&blind).unwrap();
    let motors = toml.lines().find(|line| line.starts_with("motors")).unwrap();
    fs::write(&blind, toml.replace(motors, "motors = { kind = \"servo\" }")).unwrap();
    let err = refused(blind.to_str().unwrap(), &[]);
    assert!(err.contains("robot `robot` has neither encoders nor an odometer"), "{err}");
    let single = scenario("umbmark-single.toml", "", &format!("{ENCODERS}quadrature = false\n"));
    assert!(refused(single.to_str().unwrap(), &[]).contains("do not measure the direction"));
    let fine = scenario("umbmark-fine.toml", "", ENCODERS);
    let fine = fine.to_str().unwrap();
    assert!(refused(fine, &["--sensor", "gps"]).contains("has no odometry called `gps`; it has: encoders"));
    assert!(refused(fine, &["--robot", "bob"]).contains("there is no robot `bob`; there are: robot"));
    assert!(refused(fine, &["--speed-m-s", "3"]).contains("--speed-m-s: must be above 0 and at most 0."));
    assert!(refused(fine, &["--side-m", "0"]).contains("must be from 0.1 to 1000"));
}
