//! The square of UMBmark, driven by one robot in an empty arena of its own.

use std::fmt::Display;
use std::sync::Arc;

use baudbot_brains::composed::Composed;
use baudbot_brains::description::Description;
use baudbot_brains::odometry::{Calibration, Parameters};
use baudbot_brains::registry::Registry;
use baudbot_client::{BelievedPose, Body};
use baudbot_geometry::{Pose, angle};
use baudbot_plot::quantity::handy;
use baudbot_run::in_process::InProcess;
use baudbot_sim::arena::Arena;
use baudbot_sim::model::{RobotSpec, Start};
use baudbot_sim::rules::Rules;
use baudbot_sim::scenario::End;
use baudbot_sim::sensor::Device;
use baudbot_sim::surroundings::Surroundings;
use baudbot_sim::{Scenario, SimTime};

use super::analysis::EndError;
use crate::args::UmbmarkArgs;
use crate::error::Refused;

/// The square, and the way in which the robot drives it.
pub(super) struct Course {
    /// The robot alone, on an empty floor without end.
    scenario: Scenario,
    body: Body,
    pub(super) sensor: String,
    side_m: f64,
    pub(super) speed_m_s: f64,
    /// The speed of a wheel at a signal of 1.
    full_speed_m_s: f64,
    rotation_m_s: f64,
}

/// A run of a course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Run {
    pub(super) clockwise: bool,
    pub(super) seed: u64,
    pub(super) calibration: Calibration,
}

impl Course {
    /// The course of this robot of a scenario. Its speed is measured first: no data sheet states it.
    pub(super) fn new(args: &UmbmarkArgs, scenario: &Scenario, robot: &RobotSpec) -> anyhow::Result<Self> {
        let body = Body::from(robot);
        let sensor = sensor(args.sensor.as_deref(), robot, &body)?;
        let scenario = alone(scenario, robot);
        let full_speed_m_s = full_speed_m_s(&scenario)?;
        let slowest_m_s = LEAST_SIGNAL / SLOWEST * full_speed_m_s;
        let usual_m_s = USUAL_M_S.clamp(slowest_m_s, 0.5 * full_speed_m_s);
        let speed_m_s = args.speed_m_s.unwrap_or(usual_m_s);
        if !(speed_m_s > 0.0 && speed_m_s <= full_speed_m_s) {
            return Err(Refused::error(format!(
                "--speed-m-s: must be above 0 and at most {}, the speed of `{}` at a signal of 1; is {speed_m_s}",
                handy(full_speed_m_s),
                robot.name
            )));
        }
        let rotation_m_s = (USUAL_RAD_S * body.half_track_m).min(0.5 * speed_m_s).max(slowest_m_s);
        let side_m = args.side_m;
        Ok(Self { scenario, body, sensor, side_m, speed_m_s, full_speed_m_s, rotation_m_s })
    }

    /// The distance between the wheels by the data sheet, in metres.
    pub(super) fn track_m(&self) -> f64 {
        2.0 * self.body.half_track_m
    }

    /// Radius of the wheels by the data sheet, in metres.
    pub(super) fn wheel_radius_m(&self) -> f64 {
        self.body.wheel_radius_m
    }

    /// Drives once round the square. The robot must come round.
    pub(super) fn drive(&self, run: Run) -> anyhow::Result<EndError> {
        let mut scenario = self.scenario.clone();
        scenario.seed = run.seed;
        scenario.end.after = Some(SimTime::from_ns((self.longest_s() * 1e9) as u64));
        let ticks_of_rest = REST_NS / scenario.step_ns + 1;
        let mut local = InProcess::with_brain(scenario, self.brain(&run)?);
        local.world.keep_timeline(0);
        while !has_arrived(&mut local) {
            local.run(LOOK_EVERY);
            if let Some(ending) = local.world.ending() {
                return Err(self.stuck(&run, ending, &local.world.robot(0).motion().pose));
            }
        }
        local.run(ticks_of_rest);
        let truth = local.world.robot(0).motion().pose;
        let belief = local.belief(0).and_then(|belief| belief.pose);
        let BelievedPose { x_m, y_m, heading_rad, .. } = belief.unwrap_or_default();
        Ok(EndError {
            x_m: truth.position.x - x_m,
            y_m: truth.position.y - y_m,
            heading_rad: angle::difference(truth.heading, heading_rad),
        })
    }

    /// A brain with odometry and no other sense.
    fn brain(&self, run: &Run) -> anyhow::Result<Composed> {
        let Self { side_m, speed_m_s, rotation_m_s, full_speed_m_s, sensor, .. } = self;
        let (clockwise, Calibration { wheels: [left, right], track }) = (run.clockwise, run.calibration);
        let toml = format!(
            "[motor.square]\nkind = \"square\"\n\
             [motor.square.parameters]\nside_m = {side_m:?}\nclockwise = {clockwise}\n\
             steering = {{ speed_m_s = {speed_m_s:?}, rotation_m_s = {rotation_m_s:?}, full_speed_m_s = {full_speed_m_s:?} }}\n\
             [cognitive.odometry]\nkind = \"odometry\"\nutility = {{ bias = 1.0 }}\n\
             [cognitive.odometry.parameters]\nsensor = {sensor:?}\nstart = [0.0, 0.0, 0.0]\n\
             wheel_factors = [{left:?}, {right:?}]\ntrack_factor = {track:?}\n"
        );
        Ok(Description::parse(&toml)?.brain(run.seed, &self.body, &Registry::standard())?)
    }

    /// A robot that has not come round by then will not, in seconds.
    fn longest_s(&self) -> f64 {
        let turns_s = std::f64::consts::TAU * self.body.half_track_m / self.rotation_m_s;
        60.0 + PATIENCE * (4.0 * self.side_m / self.speed_m_s + turns_s)
    }

    fn stuck(&self, run: &Run, ending: &impl Display, at: &Pose) -> anyhow::Error {
        let direction = if run.clockwise { "clockwise" } else { "counter-clockwise" };
        anyhow::anyhow!(
            "`{}` did not complete the square {direction} with seed {}: {ending}; it is at ({}, {}) after {} s, steering \
             by `{}`. If it is too weak to turn so slowly, a higher --speed-m-s helps",
            self.body.name,
            run.seed,
            handy(at.position.x),
            handy(at.position.y),
            handy(self.longest_s()),
            self.sensor
        )
    }
}

/// The robot without the others, at rest at the origin of an arena without anything in it. Scents and lamps stay, as sensors
/// may name them.
fn alone(scenario: &Scenario, robot: &RobotSpec) -> Scenario {
    let start = Start { pose: Pose::new(0.0, 0.0, 0.0), speed_m_s: 0.0, turn_rate_rad_s: 0.0, ..robot.start };
    let zones = Vec::new();
    Scenario {
        end: End::default(),
        rules: Rules::default(),
        arena: Arc::new(Arena::new(Vec::new(), Vec::new())),
        surroundings: Surroundings { zones, ..scenario.surroundings.clone() },
        movers: Vec::new(),
        movables: Vec::new(),
        robots: vec![RobotSpec { start, ..robot.clone() }],
        ..scenario.clone()
    }
}

/// The sensor to steer by: one that counts both ways.
fn sensor(name: Option<&str>, robot: &RobotSpec, body: &Body) -> anyhow::Result<String> {
    let counts = |device: &Device| {
        if let Device::Encoders(encoders) = device {
            encoders.quadrature
        } else {
            matches!(device, Device::Odometer(_))
        }
    };
    let is_fit = |name: &str, device: &Device| counts(device) && Parameters::of(body, name).is_some();
    let fit = || robot.sensors.iter().filter(|sensor| is_fit(&sensor.name, &sensor.device));
    let chosen = match name {
        Some(name) => fit().find(|sensor| sensor.name == name),
        None => fit().max_by_key(|sensor| matches!(sensor.device, Device::Encoders(_))),
    };
    if let Some(chosen) = chosen {
        return Ok(chosen.name.clone());
    }
    let known: Vec<_> = fit().map(|sensor| sensor.name.as_str()).collect();
    let single = robot.sensors.iter().any(|sensor| !counts(&sensor.device) && is_encoders(&sensor.device));
    Err(Refused::error(match (name, known.as_slice()) {
        (Some(name), [_, ..]) => {
            format!(
                "--sensor: robot `{}` has no odometry called `{name}`; it has: {}",
                robot.name,
                known.join(", ")
            )
        }
        (_, _) if single => format!(
            "robot `{}` has encoders that do not measure the direction, so it cannot turn on the spot; set quadrature = true",
            robot.name
        ),
        (_, _) => format!(
            "robot `{}` has neither encoders nor an odometer, so it cannot drive a square by its own odometry; add \
             [robots.sensors.encoders] with kind = \"encoders\"",
            robot.name
        ),
    }))
}

fn is_encoders(device: &Device) -> bool {
    matches!(device, Device::Encoders(_))
}

/// The speed of the wheels at a signal of 1: twice that at half of it, when it has become steady.
fn full_speed_m_s(scenario: &Scenario) -> anyhow::Result<f64> {
    let mut local = InProcess::new(scenario.clone(), "constant:left=0.5,right=0.5")?;
    local.world.keep_timeline(0);
    local.run(TRIAL_NS / scenario.step_ns + 1);
    let speed_m_s = 2.0 * local.world.robot(0).motion().speed_m_s;
    if speed_m_s > LEAST_M_S {
        return Ok(speed_m_s);
    }
    Err(Refused::error(format!(
        "robot `{}` does not move at a signal of 0.5 ({} m/s after {} s)",
        scenario.robots[0].name,
        handy(speed_m_s),
        TRIAL_NS / 1_000_000_000
    )))
}

/// Whether the brain has been round the square.
fn has_arrived(local: &mut InProcess) -> bool {
    local.belief(0).is_some_and(|belief| belief.pose.is_some() && belief.path.is_empty())
}

/// Speed on the sides, in m/s, by default: UMBmark's robots drive slowly, so that they do not slip.
const USUAL_M_S: f64 = 0.2;
/// The speed of turns, in rad/s.
const USUAL_RAD_S: f64 = 0.8;
/// Motors may not turn at less than that.
const LEAST_SIGNAL: f64 = 0.05;
/// Part of its speed that the behaviour slows down to.
const SLOWEST: f64 = 0.25;
/// A robot that is slower does not move.
const LEAST_M_S: f64 = 1e-3;
/// The time for which a robot drives to show its speed.
const TRIAL_NS: u64 = 5_000_000_000;
/// The time until a robot that has arrived stands still, and has published so.
const REST_NS: u64 = 2_000_000_000;
/// The factor on the time that a square should take.
const PATIENCE: f64 = 10.0;
/// Ticks from one look at the brain to the next.
const LOOK_EVERY: u64 = 10;

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOT: &str = "[[robots]]\nname = \"r\"\nstart = { x_m = 3.0, speed_m_s = 0.1 }\n\
                         body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";

    fn scenario(more: &str) -> Scenario {
        baudbot_scenario::parse(&format!("{ROBOT}{more}")).unwrap()
    }

    #[test]
    fn no_brain_learns_how_its_robot_differs_from_its_data_sheet() {
        let sheet = Body::from(&scenario("").robots[0]);
        let other = ROBOT.replace(" }\n", ", wheel_ratio = 1.1, wheel_scale = 0.9, track_ratio = 1.2 }\n");
        let other = other.replace(
            "speed_m_s = 0.1, wheel_ratio = 1.1, wheel_scale = 0.9, track_ratio = 1.2",
            "speed_m_s = 0.1",
        );
        let other = baudbot_scenario::parse(&other).unwrap();
        assert!(other.robots[0].drive.deviation.is_some());
        assert_eq!(Body::from(&other.robots[0]), sheet);
    }

    #[test]
    fn the_robot_is_alone_and_at_rest_at_the_origin() {
        let crowd = "[[arena.circles]]\nname = \"c\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 0.1\n\
                     [[arena.zones]]\nname = \"ice\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 9.0\nslip = 0.5\n\
                     [[robots]]\nname = \"s\"\nstart = { x_m = -3.0 }\n\
                     body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";
        let scenario = scenario(crowd);
        let alone = alone(&scenario, &scenario.robots[0]);
        assert_eq!(alone.robots.len(), 1);
        let start = alone.robots[0].start;
        assert_eq!((start.pose, start.speed_m_s), (Pose::new(0.0, 0.0, 0.0), 0.0));
        assert!(alone.arena.pillars().is_empty() && alone.surroundings.zones.is_empty());
    }
}
