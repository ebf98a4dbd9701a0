//! The refusals, with their words and exit codes.

use std::fs::{self, File};

use crate::cli::{baudbot, place};

/// The one line on stderr of a command that must fail with this code.
fn refusal(code: i32, args: &[&str]) -> String {
    let (found, out, err) = baudbot(args);
    assert_eq!((found, out.as_str()), (code, ""), "{err}");
    let line = err.strip_prefix("error: ").unwrap_or_else(|| panic!("no error: {err}"));
    line.trim_end().to_owned()
}

#[test]
fn a_wrong_field_is_named_with_its_file() {
    let body = "body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
    let mut toml = String::new();
    for (i, range_m) in [1, 1, -1].iter().enumerate() {
        toml += &format!(
            "[[robots]]\nname = \"r{i}\"\nstart.x_m = {i}.0\n{body}\n[robots.sensors.front]\nkind = \"ir\"\n\
             bearing_rad = 0.0\nrays = 3\nopening_rad = 0.5\nrange_m = {range_m}.0\nc1_m2 = 0.03\nc2 = 0.1\n"
        );
    }
    let path = place("wrong.toml");
    fs::write(&path, &toml).unwrap();
    let path = path.to_str().unwrap();
    let expected = format!("{path}: robots[2].sensors.front.range_m: must be positive, is -1");
    for command in ["run", "check", "serve"] {
        assert_eq!(refusal(2, &[command, path]), expected);
    }
}

#[test]
fn an_override_fails_as_the_file_would() {
    let set = |set| refusal(2, &["check", "wander", "--set", set]);
    assert_eq!(set("robots.robot.body.mass_kg=0"), "wander: robots[0].body.mass_kg: must be positive, is 0");
    assert_eq!(
        set("step_ms"),
        "--set: `step_ms`: an override is PATH=VALUE, such as robots.alice.start.x_m=0.5"
    );
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let nowhere = refusal(2, &["run", "nowhere.toml"]);
    assert_eq!(nowhere, "nowhere.toml: there is no such file, and no scenario of this name is built in");
    assert_eq!(refusal(2, &["check", "/"]), "/: is a directory, not a scenario file");
    let binary = place("binary.toml");
    fs::write(&binary, [0xff, 0xfe]).unwrap();
    assert!(refusal(2, &["check", binary.to_str().unwrap()]).ends_with("is not text in UTF-8"));
}

#[test]
fn a_recording_in_the_place_of_a_scenario_is_recognized() {
    let file = place("recognized.mcap");
    let _ = fs::remove_file(&file);
    let path = file.to_str().unwrap();
    let (code, _, err) = baudbot(&["run", "wander", "--seconds", "1", "--quiet", "--record", path]);
    assert_eq!(code, 0, "{err}");
    let words = format!("{path}: is a recording, not a scenario; `baudbot replay {path}` repeats its run");
    for command in ["check", "run", "budget"] {
        assert!(refusal(2, &[command, path]).starts_with(&words));
    }
    // Also a long one.
    File::options().append(true).open(&file).unwrap().set_len(1 << 40).unwrap();
    assert!(refusal(2, &["check", path]).starts_with(&words));
    fs::remove_file(&file).unwrap();
}

#[test]
fn a_file_that_is_too_long_is_not_read() {
    let path = place("long.toml");
    // No memory would hold it.
    File::create(&path).unwrap().set_len(1 << 40).unwrap();
    let refusal = refusal(2, &["check", path.to_str().unwrap()]);
    fs::remove_file(&path).unwrap();
    assert!(refusal.ends_with("has 1099511627776 bytes, a scenario has at most 16777216"), "{refusal}");
}

#[test]
fn brains_that_do_not_fit_are_refused() {
    let brain = |brain| refusal(2, &["run", "--seconds", "1", "--brain", brain]);
    assert!(brain("genius").starts_with("no brain `genius`; there are: "));
    assert_eq!(brain("bob=avoid"), "--brain: there is no robot `bob`; there are: robot");
    assert!(brain("navigate").contains("needs a sensor `odometer`"));
    assert!(brain("constant:left=fast").contains("left must be a number"));
    let path = place("blind.toml");
    let body = "{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
    fs::write(&path, format!("[[robots]]\nname = \"bat\"\nbody = {body}\n")).unwrap();
    let blind = refusal(2, &["run", path.to_str().unwrap()]);
    assert!(
        blind.starts_with("robot `bat` has no IR sensors") && blind.contains("--brain bat=NAME"),
        "{blind}"
    );
    let tour = refusal(2, &["run", "tour"]);
    assert!(tour.ends_with("; its file suggests --brain tour"), "{tour}");
}

#[test]
fn a_seed_below_zero_is_out_of_range() {
    let seed = refusal(2, &["run", "--seed", "-1"]);
    assert!(seed.contains("invalid value '-1' for '--seed <N>'"), "{seed}");
}

#[test]
fn a_server_that_is_not_there_can_be_started() {
    // Port 1 needs a privileged server, of which a test machine has none.
    for command in [&["brain", "avoid"][..], &["watch"]] {
        let missing = refusal(1, &[command, &["--connect", "127.0.0.1:1"]].concat());
        assert!(missing.starts_with("no server answers at 127.0.0.1:1 ("), "{missing}");
        assert!(missing.ends_with("is `baudbot serve` running there?"), "{missing}");
    }
}

#[test]
fn an_address_that_others_reach_needs_tokens_and_tls() {
    for command in ["serve", "run"] {
        assert!(
            refusal(2, &[command, "--listen", "0.0.0.0:0"]).contains("--tokens FILE (see `baudbot token`)")
        );
    }
}

#[test]
fn worlds_have_names_of_their_own() {
    let twice = refusal(2, &["serve", "--listen", "127.0.0.1:0", "wander", "wander"]);
    assert_eq!(twice, "world: there is a world `wander` already");
}

#[test]
fn an_end_that_cannot_be_is_told_with_its_option() {
    for seconds in ["0", "-1", "1e300"] {
        let refusal = refusal(2, &["run", "--seconds", seconds]);
        assert!(refusal.starts_with("--seconds: wander: end.after_s: must be between"), "{refusal}");
    }
    let huge = refusal(2, &["run", "--ticks", "18446744073709551615"]);
    assert!(huge.starts_with("--ticks: wander: end.after_s: must be between"), "{huge}");
    let none = refusal(2, &["run", "--ticks", "0"]);
    assert!(none.contains("'--ticks <N>'"), "{none}");
}

#[test]
fn a_file_without_an_end_is_not_read_for_ever() {
    for command in ["run", "check", "serve"] {
        let endless = refusal(2, &[command, "/dev/zero"]);
        let expected = "/dev/zero: has more than 16777216 bytes, the most that a scenario may have";
        assert_eq!(endless, expected);
    }
}

#[test]
fn a_run_that_does_not_start_leaves_the_old_table() {
    let path = place("keep.csv");
    let csv = path.to_str().unwrap();
    fs::write(&path, "precious").unwrap();
    refusal(2, &["run", "--brain", "avoid:bogus=1", "--csv", csv]);
    refusal(2, &["run", "--listen", "0.0.0.0:0", "--csv", csv]);
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    let nowhere = place("nowhere").join("a.csv");
    let nowhere = nowhere.to_str().unwrap();
    assert!(refusal(1, &["run", "--csv", nowhere]).starts_with(&format!("cannot write {nowhere}: ")));
}

#[test]
fn options_that_contradict_are_refused() {
    assert!(refusal(2, &["run", "--json", "--csv", "-"]).contains("both write to stdout"));
    assert!(refusal(2, &["serve", "--watchdog-ms", "5"]).contains("need --pace lockstep"));
}

#[test]
fn a_picture_that_cannot_be_written_is_named() {
    let nowhere = place("nowhere").join("a.svg");
    let nowhere = nowhere.to_str().unwrap();
    let refusal = refusal(1, &["check", "wander", "--svg", nowhere]);
    assert!(refusal.starts_with(&format!("cannot write {nowhere}: ")), "{refusal}");
}
