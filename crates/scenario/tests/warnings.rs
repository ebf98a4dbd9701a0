//! The warnings about a scenario that is not refused.

use crate::common::BODY;

fn warnings(toml: &str) -> Vec<String> {
    let scenario = baudbot_scenario::parse(toml).unwrap_or_else(|error| panic!("{error}"));
    baudbot_scenario::warnings(&scenario).iter().map(ToString::to_string).collect()
}

fn robot(rest: &str) -> String {
    format!("[[robots]]\nname = \"alice\"\n{BODY}\n{rest}")
}

#[test]
fn a_sound_scenario_has_none() {
    for toml in [crate::common::ARSIM, crate::common::WANDER, crate::common::KHEPERA] {
        assert_eq!(warnings(toml), Vec::<String>::new());
    }
}

#[test]
fn a_world_without_robots() {
    assert_eq!(warnings("name = \"empty\""), ["robots: there are none; add one with [[robots]]"]);
}

#[test]
fn a_sensor_that_is_faster_than_its_processor_can_read_it() {
    let sonar = "[robots.sensors.ping]\nkind = \"sonar\"\nbearing_rad = 0.0\nrays = 3\nopening_rad = 0.3\n\
                 min_m = 0.02\nmax_m = 3.0\nperiod_ms = 10.0\ntimeout_ms = 18.5\nholdoff_us = 750.0\n";
    assert_eq!(
        warnings(&robot(sonar)),
        [
            "robots.alice.sensors.ping: a read takes the microcontroller up to 19.25 ms, but is due every 10 ms; reads \
          will be skipped"
        ]
    );
    let compass = |name| {
        format!("[robots.sensors.{name}]\nkind = \"compass\"\nperiod_ms = 10.0\nacquisition_us = 6000.0\n")
    };
    let two = robot(&(compass("a") + &compass("b")));
    assert_eq!(
        warnings(&two),
        [
            "robots.alice.sensors: reading all of them takes up to 120 % of the microcontroller's time; reads will be \
          skipped"
        ]
    );
}

#[test]
fn a_laser_whose_scans_do_not_fit_its_cable() {
    let laser = "[robots.sensors.urg]\nkind = \"laser\"\nmount = { x_m = 0.0 }\nrays = 682\nopening_rad = 4.18\n\
                 range_m = 4.0\nperiod_ms = 100.0\nport = { link = { kind = \"uart\", baud = 115200 } }\n";
    let [warning] = &warnings(&robot(laser))[..] else { panic!("one warning") };
    assert!(
        warning.starts_with("robots.alice.sensors.urg.port: a message of 2137 bytes takes 185.5"),
        "{warning}"
    );
}

#[test]
fn a_door_that_closes_on_a_robot() {
    let door = "[[arena.movers]]\nname = \"door\"\noutline_m = [[0.0, -0.02], [0.9, -0.02], [0.9, 0.02], [0.0, 0.02]]\n\
                x_m = -0.5\ny_m = -0.5\nswing = { to_rad = 1.5, rate_rad_s = 0.5 }\n";
    let [warning] = &warnings(&(door.to_owned() + &robot("")))[..] else { panic!("one warning") };
    assert!(
        warning
            .starts_with("arena.movers.door: its path leads over the place at (0, 0) m where robot `alice`")
    );
}
