//! The report of batteries, ports, zones and things that move; there is nothing of those that are missing.

use serde_json::Value;

use crate::cli::{baudbot, good, place};

/// A robot that stands in a door's way.
const SCOUT: &str = r#"
    end.after_s = 1.0
    metrics.cell_m = 0.1

    [[arena.polygons]]
    name = "border"
    points_m = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]
    solid = false

    [[arena.zones]]
    name = "home"
    x_m = 0.0
    y_m = 0.0
    radius_m = 0.3

    [[arena.zones]]
    name = "far"
    x_m = 1.5
    y_m = 0.0
    radius_m = 0.3
    goal = true

    [[arena.movers]]
    name = "door"
    outline_m = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.05], [0.0, 0.05]]
    x_m = -0.5
    y_m = -0.02
    heading_rad = 3.0
    swing = { to_rad = 6.28, rate_rad_s = 10.0 }

    [[robots]]
    name = "scout"
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
    battery = { nominal_v = 4.8, capacity_mah = 2000, idle_w = 1.0 }
    actuators.head = { kind = "turret", min_rad = -1.0, max_rad = 1.0, rate_rad_s = 6.0 }
    sensors.sonar = { kind = "sonar", mount = {}, turret = "head", opening_rad = 0.3, rays = 3, min_m = 0.1, max_m = 3.0 }

    [robots.sensors.laser]
    kind = "laser"
    bearing_rad = 0.0
    opening_rad = 1.0
    rays = 5
    range_m = 4.0
    period_ms = 100.0
    port = { link = { kind = "uart", baud = 19200 } }
"#;

fn scout(name: &str) -> String {
    let path = place(name);
    std::fs::write(&path, SCOUT).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Runs the scout to its end, which must be a good one; its stdout. The sonar is read too often, and the door swings
/// over the robot: there is a warning of each.
fn warned(args: &[&str]) -> String {
    let (code, out, err) = baudbot(args);
    assert_eq!(code, 0, "{err}");
    let warnings: Vec<_> = err.lines().collect();
    assert_eq!(warnings.len(), 2, "{err}");
    assert!(warnings[0].starts_with("warning: robots.scout.sensors.sonar: a read takes"), "{err}");
    assert!(warnings[1].starts_with("warning: arena.movers.door: its path leads over"), "{err}");
    out
}

#[test]
fn a_run_with_devices_is_summed_up() {
    let out = warned(&["run", &scout("scout.toml"), "--brain", "none"]);
    for part in [
        "covered     ",
        "goals       0 of 1 reached\n",
        "visited     home\n",
        "warning     `door` was blocked for ",
        "  battery  ",
        " J used\n",
        "  zones    home 1 s\n",
        "    laser  ",
    ] {
        assert!(out.contains(part), "`{part}` is not in:\n{out}");
    }
}

#[test]
fn its_json_has_them_and_that_of_others_does_not() {
    const JSON: [&str; 5] = ["run", "--json", "--quiet", "--brain", "none"];
    let scout = scout("scout-json.toml");
    let summary: Value = serde_json::from_str(&warned(&[&JSON[..], &[&scout]].concat())).unwrap();
    assert_eq!(summary["score"]["goals"], 1);
    assert!(summary["score"]["covered_percent"].as_f64().unwrap() > 0.0);
    assert_eq!(summary["blocked"][0]["mover"], "door");
    let robot = &summary["robots"][0];
    assert!(robot["battery"]["used_j"].as_f64().unwrap() > 0.9);
    assert_eq!(robot["zones"][0]["zone"], "home");
    assert!(robot["sensors"][0].get("port").is_none());
    assert!(robot["sensors"][1]["port"]["messages"].as_u64().unwrap() >= 9);

    let wander = good(&[&JSON[..], &["wander", "--ticks", "10"]].concat());
    let wander: Value = serde_json::from_str(&wander).unwrap();
    assert!(wander.get("score").is_none() && wander.get("blocked").is_none(), "{wander}");
    let robot = wander["robots"][0].as_object().unwrap();
    for field in ["battery", "zones", "onboard"] {
        assert!(!robot.contains_key(field), "{field}");
    }
}

#[test]
fn the_table_has_a_column_for_each_ray_for_the_turret_and_the_battery() {
    let table = warned(&["run", &scout("scout-csv.toml"), "--brain", "none", "--csv", "-", "--quiet"]);
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let columns = &rows[0][7..];
    let rays = ["laser.0", "laser.1", "laser.2", "laser.3", "laser.4"];
    assert_eq!((columns[0], &columns[1..6]), ("sonar", &rays[..]));
    let state = ["head.angle_rad", "battery.share", "battery.terminal_v"];
    assert_eq!(columns[6..], [&["left_signal", "right_signal", "collided"], &state[..]].concat());
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let last = rows.last().unwrap();
    let share: f64 = last[last.len() - 2].parse().unwrap();
    assert!((0.999..1.0).contains(&share), "{share}");
}

#[test]
fn a_check_tells_what_goes_over_a_port() {
    let out = good(&["check", &scout("scout-check.toml")]);
    let laser = out.lines().find(|line| line.trim_start().starts_with("laser")).unwrap();
    assert!(laser.contains("100 ms") && laser.contains("5 on its own port"), "{laser}");
}
