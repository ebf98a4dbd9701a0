//! Small scenes for one device, and ways to read it.

use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Input, SensorView, World};
use baudbot_wire::{frame, write_command};

use crate::common::{BODY, world};

/// A robot `r` at the origin, of radius 0.2 m, looking along x; `top` stands before it in the file.
pub(crate) fn scene(top: &str, robot: &str, sensors: &str) -> String {
    format!("{top}\n[[robots]]\nname = \"r\"\n{BODY}\n{robot}\n{sensors}\n")
}

/// The same with a single sensor `s`.
pub(crate) fn with_sensor(top: &str, sensor: &str) -> String {
    scene(top, "firmware = { mode = \"poll\" }", &named("s", sensor))
}

pub(crate) fn named(name: &str, fields: &str) -> String {
    format!("[robots.sensors.{name}]\n{fields}\n")
}

/// A wall whose near face stands at `x`, from the robot's right to its left.
pub(crate) fn wall(x: f64) -> String {
    block("wall", [x, -5.0, x + 0.1, 5.0], "")
}

/// A solid rectangle.
pub(crate) fn block(name: &str, [x0, y0, x1, y1]: [f64; 4], more: &str) -> String {
    format!(
        "[[arena.polygons]]\nname = \"{name}\"\npoints_m = [[{x0:?}, {y0:?}], [{x1:?}, {y0:?}], [{x1:?}, {y1:?}], \
         [{x0:?}, {y1:?}]]\n{more}\n"
    )
}

/// The sensor of this name of the first robot.
#[track_caller]
pub(crate) fn view<'a>(world: &'a World, name: &str) -> SensorView<'a> {
    let robot = world.robot(0);
    let i = place(robot.spec(), name);
    robot.sensors().nth(i).unwrap()
}

#[track_caller]
pub(crate) fn place(spec: &RobotSpec, name: &str) -> usize {
    spec.sensors.iter().position(|sensor| sensor.name == name).unwrap()
}

/// The first reading of the sensor `s`.
#[track_caller]
pub(crate) fn first(toml: &str) -> Vec<f64> {
    let mut world = world(toml);
    world.begin();
    view(&world, "s").sample.to_vec()
}

#[track_caller]
pub(crate) fn single(toml: &str) -> f64 {
    let values = first(toml);
    assert_eq!(values.len(), 1, "{values:?}");
    values[0]
}

/// A number of readings of `s`, one a tick.
pub(crate) fn collect(toml: &str, count: usize) -> Vec<Vec<f64>> {
    let mut world = world(toml);
    (0..count)
        .map(|_| {
            world.begin();
            let values = view(&world, "s").sample.to_vec();
            world.finish(&[]);
            values
        })
        .collect()
}

/// The first components of so many readings.
pub(crate) fn singles(toml: &str, count: usize) -> Vec<f64> {
    collect(toml, count).into_iter().map(|values| values[0]).collect()
}

/// The first components of the first readings of so many specimens.
pub(crate) fn specimens(toml: &str, count: usize) -> Vec<f64> {
    (0..count).map(|seed| first(&format!("seed = {seed}\n{toml}"))[0]).collect()
}

#[track_caller]
pub(crate) fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} should be {expected}");
}

#[track_caller]
pub(crate) fn all_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?} should be {expected:?}");
    let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(close, "{found:?} should be {expected:?}");
}

/// A command for the wheels and all other actuators, framed.
pub(crate) fn signals(spec: &RobotSpec, values: &[f64]) -> Vec<u8> {
    let mut payload = [0; frame::MAX_PAYLOAD];
    let n = write_command(&spec.firmware.layout(), 0, values.iter().copied(), &mut payload).unwrap();
    let mut bytes = [0; frame::MAX_FRAME];
    let n = frame::encode(&payload[..n], &mut bytes).unwrap();
    bytes[..n].to_vec()
}

/// One tick in which the robot of this name sends these signals, if it may.
pub(crate) fn tick_of(world: &mut World, name: &str, values: &[f64]) {
    let turns = world.begin().to_vec();
    let own = turns.iter().find(|turn| world.robot(turn.robot).spec().name == name).copied();
    let bytes = own.map(|turn| signals(world.robot(turn.robot).spec(), values)).unwrap_or_default();
    let inputs: Vec<_> =
        own.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: &bytes }).collect();
    world.finish(&inputs);
}
