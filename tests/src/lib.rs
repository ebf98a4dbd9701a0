//! The shared parts of whole-system tests: scenarios, a world with its brains in one thread ([`InProcess`]), and a
//! server with its brains over real gRPC ([`system`]).

pub mod narrow;
pub mod system;

pub use baudbot_run::in_process::InProcess;

use baudbot_scenario::Override;
use baudbot_sim::Scenario;

/// `catalogue/scenarios/arsim.toml`.
pub const ARSIM: &str = include_str!("../../catalogue/scenarios/arsim.toml");
/// `catalogue/scenarios/wander.toml`.
pub const WANDER: &str = include_str!("../../catalogue/scenarios/wander.toml");
/// `catalogue/scenarios/khepera.toml`.
pub const KHEPERA: &str = include_str!("../../catalogue/scenarios/khepera.toml");

/// A scenario with some fields changed.
///
/// # Panics
/// If the scenario or a change is invalid.
pub fn scenario(toml: &str, changes: &[&str]) -> Scenario {
    let changes: Vec<_> = changes.iter().map(|text| Override::parse(text).expect("an override")).collect();
    baudbot_scenario::parse_with(toml, &changes).unwrap_or_else(|error| panic!("{error}"))
}

/// `wander.toml` with `n` robots `r0`, `r1`, … on a grid in a larger room. Where a robot starts depends on
/// its name, not on its place in the file.
pub fn crowd(names: &[String]) -> String {
    let (_, robot) = WANDER.split_once("[[robots]]").expect("a robot");
    let mut toml = String::from(
        "name = \"crowd\"\nstep_ms = 10.0\nsubsteps = 10\ncollision = \"stop-robot\"\n\
         [[arena.polygons]]\nname = \"border\"\nsolid = false\npoints_m = [[-4, -4], [4, -4], [4, 4], [-4, 4]]\n",
    );
    for name in names {
        let i: f64 = name.trim_start_matches('r').parse().expect("names are r0, r1, …");
        let place = format!(
            "start = {{ x_m = {}, y_m = {}, heading_rad = {} }}",
            (i % 4.0) * 1.8 - 2.7,
            (i / 4.0).floor() * 1.8 - 2.7,
            i
        );
        let robot = robot
            .replace("name = \"robot\"", &format!("name = \"{name}\""))
            .replace("start = { x_m = -0.2, y_m = 0.0, heading_rad = 0.0 }", &place);
        assert!(robot.contains(&place), "wander.toml's start line has changed");
        toml.push_str("[[robots]]");
        toml.push_str(&robot);
    }
    toml
}
