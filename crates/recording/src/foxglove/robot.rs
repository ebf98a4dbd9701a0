//! The data that is kept of one robot to show it.

use baudbot_proto::v1;
use baudbot_proto::v1::SensorKind;
use foxglove::messages::{FrameTransform, SceneEntity, Timestamp};

use super::belief::Believer;
use super::footprint::Heights;
use super::frames::{self, Mounted};
use super::message::FoxgloveMessage;
use super::odometry::DeadReckoning;
use super::parts::{WORLD, sound_pose};
use super::rays;
use super::scan::Scanner;

/// A robot, and what was shown of it.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    name: String,
    frame: String,
    odometry_frame: String,
    sensors: Vec<Sensor>,
    /// Sensors on turrets, whose frames move.
    turned: Vec<Mounted>,
    dead_reckoning: Option<DeadReckoning>,
    pub(super) believer: Believer,
    /// Height at which its rays are drawn.
    rays_m: f64,
}

/// A sensor, in the order of the data sheet.
#[derive(Clone, Debug)]
struct Sensor {
    kind: SensorKind,
    scanner: Option<Scanner>,
}

impl Robot {
    pub(super) fn new(robot: &v1::ObservedRobot, heights: &Heights) -> Self {
        let described = robot.description.as_ref();
        let sensor = |sensor: &v1::SensorDescription| Sensor {
            kind: sensor.kind(),
            scanner: Scanner::of(&robot.robot, sensor),
        };
        Self {
            name: robot.robot.clone(),
            frame: frames::robot(&robot.robot),
            odometry_frame: frames::odometry(&robot.robot),
            sensors: described
                .map_or_else(Vec::new, |described| described.sensors.iter().map(sensor).collect()),
            turned: Mounted::all(robot).into_iter().filter(Mounted::is_turned).collect(),
            dead_reckoning: described.and_then(DeadReckoning::of),
            believer: Believer::new(robot, heights.above()),
            rays_m: 0.5 * heights.of_robot(robot),
        }
    }

    /// The run starts over.
    pub(super) fn forget(&mut self) {
        self.dead_reckoning.iter_mut().for_each(DeadReckoning::forget);
        self.sensors.iter_mut().filter_map(|sensor| sensor.scanner.as_mut()).for_each(Scanner::forget);
    }

    /// Notes the robot's true pose.
    pub(super) fn note(&mut self, truth: &v1::RobotTruth, time_ns: u64) {
        let pose = sound_pose(truth.x_m, truth.y_m, truth.heading_rad);
        if let (Some(dead_reckoning), Some(pose)) = (&mut self.dead_reckoning, pose) {
            dead_reckoning.note(time_ns, pose);
        }
    }

    /// Takes the readings that have reached the brain, with the scans among them.
    pub(super) fn take(&mut self, detail: &v1::RobotDetail, time_ns: u64) -> Vec<FoxgloveMessage> {
        if let Some(dead_reckoning) = &mut self.dead_reckoning {
            dead_reckoning.take(&detail.sensors);
        }
        let sensors = self.sensors.iter_mut().zip(&detail.sensors);
        sensors.filter_map(|(sensor, detail)| sensor.scanner.as_mut()?.message(detail, time_ns)).collect()
    }

    /// Frames that have moved.
    pub(super) fn frames(&self, truth: &v1::RobotTruth, at: Timestamp) -> Vec<FrameTransform> {
        let body = frames::in_world(at, &self.frame, [truth.x_m, truth.y_m, truth.heading_rad]);
        let turned = self.turned.iter().filter_map(|sensor| sensor.turned(at, &self.frame, &truth.actuators));
        let dead_reckoning = self.dead_reckoning.as_ref().and_then(DeadReckoning::pose);
        let dead_reckoning =
            dead_reckoning.map(|pose| frames::transform(at, WORLD, &self.odometry_frame, &pose));
        body.into_iter().chain(turned).chain(dead_reckoning).collect()
    }

    /// Whether the pose by odometry is known.
    pub(super) fn has_ghost(&self) -> bool {
        self.dead_reckoning.as_ref().is_some_and(|dead_reckoning| dead_reckoning.pose().is_some())
    }

    /// The rays of the robot's sensors, except those that scan.
    pub(super) fn rays(&self, detail: &v1::RobotDetail, time_ns: u64) -> Option<SceneEntity> {
        let sensors = self.sensors.iter().zip(&detail.sensors).filter(|(sensor, _)| sensor.scanner.is_none());
        let fans = sensors.filter_map(|(sensor, detail)| Some((sensor.kind, detail.rays.as_ref()?)));
        rays::fans(&self.name, fans, (self.rays_m, time_ns))
    }
}
