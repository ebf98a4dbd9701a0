//! The place of a sensor on its robot, and its direction.

use baudbot_geometry::Pose;

use super::Measurement;
use crate::actuator::ActuatorState;
use crate::arena::Height;
use crate::scene::Viewpoint;

/// The place of a sensor, and its direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Mount {
    /// Robot from sensor; on a turret, turret from sensor.
    pub pose: Pose,
    /// The actuator that turns it, by its place among the robot's actuators.
    pub turret: Option<usize>,
    /// The height.
    pub height: Height,
    /// The angle by which its rays rise above the horizon, in radians; level ones have none.
    pub elevation_rad: Option<f64>,
}

impl Mount {
    /// World from sensor.
    pub(crate) fn world_from_sensor(&self, at: &Measurement<'_>) -> Pose {
        let world_from_robot = &at.motion.pose;
        if self.turret.is_some() {
            return self.place(world_from_robot, at.actuators);
        }
        world_from_robot.compose_facing(at.scene.facing(world_from_robot), &self.pose)
    }

    /// World from sensor, on a robot at `world_from_robot` with its actuators in these states.
    pub fn place(&self, world_from_robot: &Pose, actuators: &[ActuatorState]) -> Pose {
        match self.turned(actuators) {
            Some(robot_from_turret) => world_from_robot.compose(&robot_from_turret).compose(&self.pose),
            None => world_from_robot.compose(&self.pose),
        }
    }

    /// Robot from turret, if it is on one.
    pub(super) fn turned(&self, actuators: &[ActuatorState]) -> Option<Pose> {
        let angle_rad = actuators.get(self.turret?).map_or(0.0, |actuator| actuator.angle_rad);
        Some(Pose::new(0.0, 0.0, angle_rad))
    }

    /// A look from there as far as `range_m`.
    pub(crate) fn look<'a>(&self, at: &Measurement<'a>, from: &Pose, range_m: f64) -> Viewpoint<'a> {
        let level = self.look_level(at, from, range_m);
        match self.elevation_rad {
            None => level,
            Some(elevation_rad) => level.raised(elevation_rad),
        }
    }

    fn look_level<'a>(&self, at: &Measurement<'a>, from: &Pose, range_m: f64) -> Viewpoint<'a> {
        let scene = at.scene;
        // A turret turns about the middle, so that its angle does not matter. Most sensors are settled by this, without a sine.
        if scene.is_in_own_disc(self.pose.position.coords) {
            return scene.look_around(from.position, self.height, range_m);
        }
        let eye = self.world_from_sensor(at).position;
        scene.look_with_eye(eye, from.position, self.height, range_m)
    }
}
