//! The frames, and the transform of each to another.

use baudbot_proto::v1;
use baudbot_sim::Pose;
use foxglove::messages::{FrameTransform, FrameTransforms, Timestamp};

use super::parts::{WORLD, part, sound_pose, time, turn, vector};

/// The frame of a robot's body.
pub(super) fn robot(robot: &str) -> String {
    format!("robot/{}", part(robot))
}

/// The frame of a robot's sensor: x is where it looks.
pub(super) fn sensor(robot: &str, sensor: &str) -> String {
    format!("robot/{}/{}", part(robot), part(sensor))
}

/// The frame of something that moves or is pushed.
pub(super) fn thing(thing: &str) -> String {
    format!("thing/{}", part(thing))
}

/// The frame of a robot by its odometry.
pub(super) fn odometry(robot: &str) -> String {
    format!("odometry/{}", part(robot))
}

/// The transform of a frame to another one.
pub(super) fn transform(at: Timestamp, parent: &str, child: &str, pose: &Pose) -> FrameTransform {
    FrameTransform {
        timestamp: Some(at),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(vector(pose.position.x, pose.position.y, 0.0)),
        rotation: Some(turn(pose.heading)),
    }
}

/// A sensor on a robot.
#[derive(Clone, Debug)]
pub(super) struct Mounted {
    frame: String,
    /// On a turret, turret from sensor.
    robot_from_sensor: Pose,
    /// The actuator that turns it, by its place.
    turret: Option<usize>,
}

impl Mounted {
    /// All sensors of which it matters where they sit.
    pub(super) fn all(robot: &v1::ObservedRobot) -> Vec<Self> {
        let Some(description) = &robot.description else { return Vec::new() };
        let mounted = |described: &v1::SensorDescription| {
            let mount = described.mount.as_ref()?;
            let robot_from_sensor = sound_pose(mount.x_m, mount.y_m, mount.heading_rad)?;
            let frame = sensor(&robot.robot, &described.sensor);
            Some(Self { frame, robot_from_sensor, turret: mount.turret.map(|turret| turret as usize) })
        };
        description.sensors.iter().filter_map(mounted).collect()
    }

    pub(super) fn is_turned(&self) -> bool {
        self.turret.is_some()
    }

    /// The sensor's fixed pose, unless a turret turns it.
    fn at_rest(&self, at: Timestamp, robot: &str) -> Option<FrameTransform> {
        (!self.is_turned()).then(|| transform(at, robot, &self.frame, &self.robot_from_sensor))
    }

    /// The sensor's pose on its turret, which turns about the robot's centre.
    pub(super) fn turned(
        &self,
        at: Timestamp,
        robot: &str,
        actuators: &[v1::ActuatorTruth],
    ) -> Option<FrameTransform> {
        let angle_rad = actuators.get(self.turret?)?.angle_rad;
        let robot_from_turret = sound_pose(0.0, 0.0, angle_rad)?;
        Some(transform(at, robot, &self.frame, &robot_from_turret.compose(&self.robot_from_sensor)))
    }
}

/// Frames that never move. They have a topic of their own, since after a jump only the last message of each topic is shown.
pub(super) fn fixed(robots: &[v1::ObservedRobot], time_ns: u64) -> FrameTransforms {
    let of = |observed: &v1::ObservedRobot| {
        let frame = robot(&observed.robot);
        let mounted = Mounted::all(observed);
        mounted.iter().filter_map(|sensor| sensor.at_rest(time(time_ns), &frame)).collect::<Vec<_>>()
    };
    FrameTransforms { transforms: robots.iter().flat_map(of).collect() }
}

/// World from something, unless it is nowhere.
pub(super) fn in_world(
    at: Timestamp,
    child: &str,
    [x_m, y_m, heading_rad]: [f64; 3],
) -> Option<FrameTransform> {
    Some(transform(at, WORLD, child, &sound_pose(x_m, y_m, heading_rad)?))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn observed() -> v1::ObservedRobot {
        let sensor = |name: &str, mount| v1::SensorDescription {
            sensor: name.into(),
            mount,
            ..v1::SensorDescription::default()
        };
        let mount =
            |turret| Some(v1::Mount { x_m: 0.1, y_m: 0.0, heading_rad: 0.5, turret, elevation_rad: None });
        let sensors = vec![sensor("eye", mount(None)), sensor("head", mount(Some(1))), sensor("clock", None)];
        let description = Some(v1::RobotDescription { sensors, ..v1::RobotDescription::default() });
        v1::ObservedRobot { robot: "alice".into(), description, ..v1::ObservedRobot::default() }
    }

    #[test]
    fn sensors_are_fixed_unless_a_turret_turns_them() {
        let fixed = fixed(&[observed()], 0);
        assert_eq!(fixed.transforms.len(), 1);
        let eye = &fixed.transforms[0];
        assert_eq!((&*eye.parent_frame_id, &*eye.child_frame_id), ("robot/alice", "robot/alice/eye"));
        assert_eq!(eye.translation.unwrap(), vector(0.1, 0.0, 0.0));
        assert_eq!(eye.rotation.unwrap(), turn(0.5));
    }

    #[test]
    fn a_turret_turns_its_sensor_about_the_robots_centre() {
        let head = &Mounted::all(&observed())[1];
        let at = |angle_rad| v1::ActuatorTruth { signal: 0.0, angle_rad };
        let actuators = [at(0.0), at(FRAC_PI_2)];
        let turned = head.turned(Timestamp::MIN, "robot/alice", &actuators).unwrap();
        let place = turned.translation.unwrap();
        assert!(place.x.abs() < 1e-12 && (place.y - 0.1).abs() < 1e-12, "{place:?}");
        assert_eq!(turned.rotation.unwrap(), turn(FRAC_PI_2 + 0.5));
        assert!(head.turned(Timestamp::MIN, "robot/alice", &[]).is_none());
        assert!(head.turned(Timestamp::MIN, "robot/alice", &[at(0.0), at(f64::NAN)]).is_none());
    }
}
