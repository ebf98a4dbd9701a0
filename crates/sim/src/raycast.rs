//! The view of sensors, ray by ray: for pictures and tests, never for brains.
//!
//! A sensor makes one value of many rays. A picture that explains the value needs the rays themselves,
//! cast as the sensor casts them: in its layer of the arena, past its own robot, up to its range.

use alloc::vec::Vec;

use baudbot_geometry::{Fan, Point, Pose, Ray, math};

use crate::scene::Frozen;
use crate::sensor::{Device, Mount, Sensor};
use crate::world::World;

/// Looks at a world with the eyes of its sensors. What moves is frozen when it is made.
#[derive(Debug)]
pub struct RayCaster<'a> {
    world: &'a World,
    frozen: Frozen,
}

/// A ray as it is seen from above, and how far it runs: along the floor, also if it has an elevation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastRay {
    /// The ray from the sensor, in the world.
    pub ray: Ray,
    /// Distance to what it meets, in metres; none if there is nothing within the range.
    pub distance_m: Option<f64>,
    /// Distance to where its range ends, in metres.
    pub range_m: f64,
}

impl CastRay {
    /// Its length, in metres.
    pub fn length_m(&self) -> f64 {
        self.distance_m.unwrap_or(self.range_m)
    }

    /// The point in which it ends.
    pub fn end(&self) -> Point {
        self.ray.at(self.length_m())
    }
}

impl<'a> RayCaster<'a> {
    /// Looks at the world as it is now.
    pub fn new(world: &'a World) -> Self {
        Self { world, frozen: world.frozen() }
    }

    /// World from sensor, of something mounted on a robot.
    ///
    /// # Panics
    /// If there is no robot of this index.
    pub fn place(&self, robot: usize, mount: &Mount) -> Pose {
        let robot = self.world.robot(robot);
        mount.place(&robot.motion().pose, robot.actuators())
    }

    /// The view of a robot's sensor along each of its rays; a whisker has one. None of a sensor without rays.
    ///
    /// # Panics
    /// If there is no robot of this index.
    pub fn sees(&self, robot: usize, sensor: &Sensor) -> Vec<CastRay> {
        let Some(mount) = sensor.device.mount() else { return Vec::new() };
        match (&sensor.device, sensor.device.fan(), sensor.device.range_m()) {
            (Device::Whisker(whisker), ..) => self.along(robot, mount, &Fan::new(0.0, 1), whisker.length_m),
            (Device::Bumper(bumper), ..) => {
                let reach_m = self.world.robot(robot).spec().drive.radius_m + bumper.travel_m;
                self.along(robot, mount, &bumper.fan, reach_m)
            }
            (_, Some(fan), Some(range_m)) => self.along(robot, mount, fan, range_m),
            (_, _, _) => Vec::new(),
        }
    }

    /// The view from a mount along any rays as far as `range_m`, from right to left.
    ///
    /// # Panics
    /// If there is no robot of this index.
    pub fn along(&self, robot: usize, mount: &Mount, fan: &Fan, range_m: f64) -> Vec<CastRay> {
        let pose = self.place(robot, mount);
        let scene = self.world.scenario().scene(&self.frozen, self.world.trails(), robot);
        let level = scene.look(pose.position, mount.height, range_m);
        let (eye, share) = match mount.elevation_rad {
            None => (level, 1.0),
            Some(elevation_rad) => (level.raised(elevation_rad), math::cos(elevation_rad)),
        };
        let mut distances_m = alloc::vec![0.0; fan.len()];
        eye.sweep(&pose, fan, 0..fan.len(), &mut distances_m);
        let cast = |(ray, distance_m): (Ray, f64)| CastRay {
            ray,
            distance_m: Some(share * distance_m).filter(|distance_m| distance_m.is_finite()),
            range_m: share * range_m,
        };
        fan.rays(pose.position, pose.direction()).zip(distances_m).map(cast).collect()
    }
}
