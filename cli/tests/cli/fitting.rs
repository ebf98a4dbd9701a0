//! `baudbot fit`: from runs of our own, with numbers that the preset does not have.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use crate::cli::{baudbot, good, place};

/// A robot with a compass that iron deflects, which spins.
const ROBOT: &str = r#"
name = "spin"
step_ms = 20.0

[[robots]]
name = "a"
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
motors = { kind = "velocity", gain_n_s = 1.5, full_speed_m_s = 0.5 }
sensors.encoders = { kind = "encoders", counts_per_turn = 500 }
sensors.compass = { kind = "compass", sigma_rad = 0.02 }
sensors.odometer = { kind = "odometer", sigma_m = 0.001 }
sensors.ir_left = { kind = "ir", opening_rad = 0.5, rays = 3, range_m = 0.3, c1_m2 = 0.01, c2 = 0.0, bearing_rad = 0.5 }
sensors.ir_right = { kind = "ir", opening_rad = 0.5, rays = 3, range_m = 0.3, c1_m2 = 0.01, c2 = 0.0, bearing_rad = -0.5 }
link = { kind = "ideal" }
"#;

fn file(name: &str, text: &str) -> PathBuf {
    let path = place(name);
    fs::write(&path, text).unwrap();
    path
}

/// The table of a run, the recording of it, and `--columns` for other names give the same numbers; those are what the
/// scenario hides.
#[test]
fn tables_and_recordings_of_runs_are_logs() {
    let (hidden, known) = (
        file("fit-hidden.toml", ROBOT),
        file(
            "fit-known.toml",
            &ROBOT
                .replace("0.02 }", "0.5 }")
                .replace("0.001 }", "0.1 }")
                .replace("gain_n_s = 1.5, full_speed_m_s = 0.5", "full_speed_m_s = 0.7"),
        ),
    );
    let (csv, mcap, svg) = (place("fit.csv"), place("fit.mcap"), place("fit.svg"));
    let [scenario, known, table, recording, picture] =
        [&hidden, &known, &csv, &mcap, &svg].map(|path| path.to_str().unwrap());
    good(&[
        "run",
        scenario,
        "--brain",
        "wander",
        "--seconds",
        "60",
        "--quiet",
        "--csv",
        table,
        "--record",
        recording,
    ]);
    let fields =
        "sensors.compass.sigma_rad,sensors.odometer.sigma_m,body,motors.gain_n_s,motors.full_speed_m_s";
    let fit = |log: &str, more: &[&str]| {
        let mut args = vec!["fit", log, "--scenario", known, "--fields", fields, "--json"];
        args.extend(more);
        let (code, out, err) = baudbot(&args);
        assert_eq!(code, 0, "{err}");
        serde_json::from_str::<Value>(&out).unwrap()
    };
    let found = fit(table, &["--svg", picture]);
    let number = |path: &str| {
        let all = found["numbers"].as_array().unwrap();
        all.iter().find(|one| one["path"] == path).unwrap_or_else(|| panic!("{path}: {found}")).clone()
    };
    for (path, hidden) in [
        ("sensors.compass.noise.additive", 0.02),
        ("sensors.odometer.sigma_m", 0.001),
        ("body.wheel_radius_m", 0.1),
        ("body.half_track_m", 0.2),
        ("motors.gain_n_s", 1.5),
        ("motors.full_speed_m_s", 0.5),
    ] {
        let number = number(path);
        let (low, high) = (number["low"].as_f64().unwrap(), number["high"].as_f64().unwrap());
        assert!(low <= hidden && hidden <= high && high < 1.5 * low, "{number}");
    }
    let set = number("sensors.compass.noise.additive")["set"].as_str().unwrap().to_owned();
    assert!(
        set.starts_with("robots.a.sensors.compass.sigma_rad=0.02") || set.contains("sigma_rad=0.01"),
        "{set}"
    );
    good(&["check", known, "--set", &set]);
    assert_eq!(fit(recording, &[])["numbers"], found["numbers"]);
    let document = fs::read_to_string(&svg).unwrap();
    assert!(
        roxmltree::Document::parse(&document).is_ok() && document.contains("compass: reading less the model")
    );
    let renamed = file("fit-renamed.csv", &fs::read_to_string(&csv).unwrap().replacen("t_s,", "stamp,", 1));
    assert_eq!(fit(renamed.to_str().unwrap(), &["--columns", "time_s=stamp"])["numbers"], found["numbers"]);
}

#[test]
fn what_is_found_goes_into_a_scenario() {
    let mut log = "# experiment: echo\n# baud: 115200\nsent_us,received_us\n".to_owned();
    let mut now = 0.0_f64;
    for i in 0..300 {
        let sent = now + f64::from(i * 7919 % 1000) / 1000.0;
        let received = (sent + 0.04 + 2.0 * 10.0 / 115.2).ceil() + 1.0 + f64::from(i * 104_729 % 1000) * 1e-4;
        log += &format!("{:.1},{:.1}\n", sent * 1e3, received * 1e3);
        now = received + 0.5;
    }
    let log = file("fit-echo.csv", &log);
    let out = good(&["fit", log.to_str().unwrap(), "--preset", "ch340", "--fields", "links.*"]);
    assert!(
        out.starts_with(&format!("# {}, 300 rows, preset ch340; 95 % intervals\n", log.display())),
        "{out}"
    );
    assert!(out.contains("\nlink.adapter.extra_frames = 1 # "), "{out}");
    let scenario = format!(
        "[[robots]]\nname = \"a\"\nbody = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\nlink.kind = \"uart\"\nlink.baud = 115200\nlink.adapter.preset = \"ch340\"\n{out}"
    );
    let scenario = file("fit-pasted.toml", &scenario);
    good(&["check", scenario.to_str().unwrap()]);
}

#[test]
fn what_cannot_be_told_is_said_with_the_reason() {
    let log = file(
        "fit-three.csv",
        "time_s,command_left,command_right,speed_m_s,turn_rate_rad_s\n0,1,1,0,0\n0.1,1,1,1,0\n0.2,1,1,1,0\n",
    );
    let (code, out, _) = baudbot(&[
        "fit",
        log.to_str().unwrap(),
        "--preset",
        "khepera-1",
        "--fields",
        "motors.gain_n_s,sensors.ir_0.noise.gain_spread",
    ]);
    assert_eq!(code, 1, "{out}");
    assert!(out.contains("# cannot determine motors.gain_n_s: the log has 0 rows with commands"), "{out}");
    assert!(
        out.contains("# cannot determine sensors.ir_0.noise.gain_spread: the log has no column `distance_m`"),
        "{out}"
    );
}

#[test]
fn bad_logs_and_fields_are_refused_by_their_place() {
    let log = |text: &str| file("fit-bad.csv", text).to_str().unwrap().to_owned();
    let refused = |path: &str, fields: &str| {
        let (code, out, err) = baudbot(&["fit", path, "--preset", "khepera-1", "--fields", fields]);
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err
    };
    let path = log("time,x_m\n1,2\n");
    assert_eq!(
        refused(&path, "body"),
        format!(
            "error: {path}:1:1 (time): names no unit; write `time_s`, `time_ms`, `time_us` or `time_ns`\n"
        )
    );
    let path = log("time_s;x_m\n0;1,5\n");
    assert!(refused(&path, "body").contains(":2:2 (x_m): `1,5` has a decimal comma; write decimal points"));
    let error = refused(&log("time_s,x_m\n0,1\n"), "motors.gain");
    assert!(
        error.contains("--fields: motors.gain: ") && error.contains("did you mean `motors.gain_n_s`?"),
        "{error}"
    );
    let error = refused(&path, "body.mass_kg");
    assert!(error.contains("no model fits `body.mass_kg` to a log"), "{error}");
    assert!(refused("no/such.csv", "body").starts_with("error: no/such.csv: cannot be read"));
}

#[test]
fn the_list_has_fields_and_columns() {
    let out = good(&["fit", "--list", "--preset", "khepera-1"]);
    for line in [
        "  sensors.ir_0.noise.uniform\n",
        "  motors.gain_n_s\n",
        "  time_s time_ms time_us time_ns\n",
        "  encoders.left\n",
    ] {
        assert!(out.contains(line), "{out}");
    }
}

/// Sensors of a Khepera have a table of samples; what a fit finds about it goes into the scenario.
#[test]
fn noise_about_a_table_goes_into_a_scenario() {
    let mut log = "distance_mm,value_raw,sensor\n".to_owned();
    for (distance, value) in [(20, 300), (30, 180), (40, 130), (50, 116)] {
        for i in 0..20 {
            log += &format!("{distance},{},ir_3\n", value + 4 * (i * 7 % 5 - 2));
        }
    }
    let log = file("fit-table.csv", &log);
    let fields = "sensors.ir_3.noise.*";
    let (code, out, err) =
        baudbot(&["fit", log.to_str().unwrap(), "--preset", "khepera-2", "--fields", fields]);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("\nsensors.ir_3.noise.uniform = 0.0"), "{out}");
    assert!(
        out.contains("# cannot determine sensors.ir_3.noise.gain_spread: a spread over specimens needs"),
        "{out}"
    );
    let scenario = format!("[[robots]]\nname = \"a\"\npreset = \"khepera-2\"\n{out}");
    good(&["check", file("fit-table.toml", &scenario).to_str().unwrap()]);
}
