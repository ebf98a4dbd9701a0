//! Warnings: settings that are allowed but hardly intended are reported, not refused.

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

use baudbot_geometry::{Pose, angle};

use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::mover::{Mover, Path as Way};
use baudbot_sim::sensor::Sensor;

/// Something about a scenario that its author should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The path of the setting: `robots.alice.sensors.sonar`, with names in place of numbers.
    pub path: String,
    /// The consequence.
    pub problem: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path, self.problem)
    }
}

/// A setting that is allowed but hardly intended.
pub fn warnings(scenario: &Scenario) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut tables = BTreeSet::new();
    if scenario.robots.is_empty() {
        warnings.push(Warning {
            path: "robots".into(),
            problem: "there are none; add one with [[robots]]".into(),
        });
    }
    for robot in scenario.robots.iter().filter(|robot| tables.insert(robot.table_name())) {
        if robot.chip.is_none() {
            too_fast_to_read(robot, &mut warnings);
        }
        too_long_for_the_port(robot, &mut warnings);
        is_on_nothing(robot, &mut warnings);
    }
    for mover in &scenario.movers {
        let meets = |robot: &&RobotSpec| passes(mover, robot);
        if let Some(robot) = scenario.robots.iter().find(meets) {
            let problem = format!(
                "its path leads over the place at ({}, {}) m where robot `{}` starts; it waits while something \
                 stands there",
                robot.start.pose.position.x, robot.start.pose.position.y, robot.name
            );
            warnings.push(Warning { path: format!("arena.movers.{}", mover.name), problem });
        }
    }
    warnings
}

/// A program with nothing on its pins.
fn is_on_nothing(robot: &RobotSpec, warnings: &mut Vec<Warning>) {
    let Some(chip) = &robot.chip else { return };
    if chip.board().wiring().parts().next().is_none() {
        let problem = "nothing is on the pins, so the program moves nothing and senses nothing; the preset `uno-rover` has pins".into();
        warnings.push(Warning { path: format!("robots.{}.pins", robot.table_name()), problem });
    }
}

/// A microcontroller that has more to read than time.
fn too_fast_to_read(robot: &RobotSpec, warnings: &mut Vec<Warning>) {
    let share = |sensor: &Sensor| {
        let takes_ns = sensor.acquisition_ns + sensor.device.longest_wait_ns();
        takes_ns as f64 / sensor.schedule.period_ns() as f64
    };
    let on_wire = || robot.sensors.iter().filter(|sensor| sensor.is_on_wire());
    for sensor in on_wire().filter(|sensor| share(sensor) > 1.0) {
        let takes_ms = ms(sensor.acquisition_ns + sensor.device.longest_wait_ns());
        let problem = format!(
            "a read takes the microcontroller up to {takes_ms} ms, but is due every {} ms; reads will be skipped",
            ms(sensor.schedule.period_ns())
        );
        warnings.push(Warning {
            path: format!("robots.{}.sensors.{}", robot.table_name(), sensor.name),
            problem,
        });
    }
    let all: f64 = on_wire().map(share).sum();
    if all > 1.0 && on_wire().all(|sensor| share(sensor) <= 1.0) {
        let percent = (100.0 * all + 0.5) as u64;
        let problem = format!(
            "reading all of them takes up to {percent} % of the microcontroller's time; reads will be skipped"
        );
        warnings.push(Warning { path: format!("robots.{}.sensors", robot.table_name()), problem });
    }
}

/// In milliseconds for people: whole microseconds, rounded up.
fn ms(ns: u64) -> f64 {
    ns.div_ceil(1000) as f64 / 1e3
}

/// A device that has measured again before its last message is over.
fn too_long_for_the_port(robot: &RobotSpec, warnings: &mut Vec<Warning>) {
    for sensor in robot.sensors.iter() {
        let (Some(port), Some(clock)) = (&sensor.port, &sensor.own_clock) else { continue };
        let bytes = port.format.message_len(&sensor.device);
        let takes_ns = port.link.burst_ns(bytes as u64);
        if takes_ns > clock.period_ns {
            let problem = format!(
                "a message of {bytes} bytes takes {} ms on its cable, but the device measures every {} ms; \
                 measurements will be skipped",
                ms(takes_ns),
                ms(clock.period_ns)
            );
            let path = format!("robots.{}.sensors.{}.port", robot.table_name(), sensor.name);
            warnings.push(Warning { path, problem });
        }
    }
}

/// Whether a thing that moves by itself would run over the place where a robot starts.
fn passes(mover: &Mover, robot: &RobotSpec) -> bool {
    let body = robot.form().at(&robot.start.pose);
    on_the_way(mover).iter().any(|pose| mover.form().at(pose).overlaps(&body))
}

/// Poses along the mover's way, near to each other; none if the way is unknown.
fn on_the_way(mover: &Mover) -> Vec<Pose> {
    let between = |from: f64, to: f64, i: u32| from + (to - from) * f64::from(i) / f64::from(LOOKS);
    match &mover.path {
        Way::Wander { .. } => Vec::new(),
        Way::Swing { ends_rad: [from, to], .. } => {
            let turned = |i| Pose { heading: angle::wrap(between(*from, *to, i)), ..mover.start };
            (0..=LOOKS).map(turned).collect()
        }
        Way::Stops { points, .. } => {
            let legs = points.windows(2).flat_map(|leg| {
                (0..=LOOKS).map(|i| (between(leg[0].x, leg[1].x, i), between(leg[0].y, leg[1].y, i)))
            });
            legs.map(|(x, y)| Pose::new(x, y, mover.start.heading)).collect()
        }
    }
}

/// Places that are examined on each part of a way.
const LOOKS: u32 = 100;
