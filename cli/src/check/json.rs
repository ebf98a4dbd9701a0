//! The output of `check --json`.

use baudbot_geometry::Pose;
use baudbot_import::Weight;
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::Sensor;
use serde_json::{Value, json};

use super::{of_robots, robot};
use crate::link;
use crate::scenarios::{self, Source};

/// A scenario that is sound.
pub(super) fn sound(source: &Source, scenario: &Scenario) -> Value {
    let of_all = scenarios::warnings(source, scenario).into_iter();
    let of_all = of_all.map(|warning| json!({ "robot": null, "warning": warning }));
    let of_robots = of_robots(scenario).into_iter();
    let of_robots =
        of_robots.map(|(robot, warning)| json!({ "robot": robot, "warning": warning.to_string() }));
    json!({
        "scenario": source.label(),
        "sound": true,
        "name": scenario.name,
        "description": scenario.description,
        "step_ms": ms(scenario.step_ns),
        "substeps": scenario.substeps,
        "seed": scenario.seed,
        "noise": scenario.noise,
        "robots": scenario.robots.iter().map(of_robot).collect::<Vec<_>>(),
        "notes": source.notes(Weight::Remark).map(ToString::to_string).collect::<Vec<_>>(),
        "warnings": of_all.chain(of_robots).collect::<Vec<_>>(),
    })
}

/// One that is refused, with what is wrong.
pub(super) fn refused(label: &str, problem: &str) -> Value {
    json!({ "scenario": label, "sound": false, "problem": problem })
}

fn of_robot(robot: &RobotSpec) -> Value {
    let Pose { position, heading } = robot.start.pose;
    let load = robot::load(robot);
    json!({
        "robot": robot.name,
        "start": { "x_m": position.x, "y_m": position.y, "heading_rad": heading },
        "radius_m": robot.drive.radius_m,
        "motors": robot.drive.motor.kind(),
        "link": link::text(&robot.link),
        "up_bytes_per_s": load.map(|(bytes, _)| bytes),
        "up_share": load.map(|(_, share)| share),
        "sensors": robot.sensors.iter().map(of_sensor).collect::<Vec<_>>(),
    })
}

fn of_sensor(sensor: &Sensor) -> Value {
    json!({
        "sensor": sensor.name,
        "kind": sensor.device.kind(),
        "period_ms": ms(robot::period_ns(sensor)),
        "values": sensor.encodings.len(),
    })
}

fn ms(ns: u64) -> f64 {
    ns as f64 / 1e6
}
