//! What sensors see of a world, ray by ray: for pictures and tests, never for brains.
//!
//! A sensor makes one value of many rays. Who wants to show why the value is what it is needs the rays themselves,
//! cast as the sensor casts them: in its layer of the arena, past its own robot, up to its range.

use alloc::vec::Vec;

use baudbot_geometry::{Fan, Pose, Ray};

use crate::scene::Frozen;
use crate::sensor::{Device, Mount, Sensor};
use crate::world::World;

/// Looks at a world with the eyes of its sensors. What moves is frozen when it is made.
#[derive(Debug)]
pub struct Onlooker<'a> {
    world: &'a World,
    frozen: Frozen,
}

/// A ray, and how far it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glance {
    /// From the sensor, in the world.
    pub ray: Ray,
    /// Distance to what it meets, in metres; none if there is nothing within the range.
    pub distance_m: Option<f64>,
}

impl<'a> Onlooker<'a> {
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

    /// What a sensor of a robot sees along each of its rays; a whisker has one. None of a sensor without rays.
    ///
    /// # Panics
    /// If there is no robot of this index.
    pub fn sees(&self, robot: usize, sensor: &Sensor) -> Vec<Glance> {
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

    /// What is seen from a mount along any rays as far as `range_m`, from right to left.
    ///
    /// # Panics
    /// If there is no robot of this index.
    pub fn along(&self, robot: usize, mount: &Mount, fan: &Fan, range_m: f64) -> Vec<Glance> {
        let pose = self.place(robot, mount);
        let scene = self.world.scenario().scene(&self.frozen, robot);
        let eye = scene.look(pose.position, mount.height, range_m);
        let mut distances_m = alloc::vec![0.0; fan.len()];
        eye.sweep(&pose, fan, 0..fan.len(), &mut distances_m);
        let glance = |(ray, distance_m): (Ray, f64)| Glance {
            ray,
            distance_m: Some(distance_m).filter(|distance_m| distance_m.is_finite()),
        };
        fan.rays(pose.position, pose.direction()).zip(distances_m).map(glance).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    fn world() -> World {
        let body = "body = { radius_m = 0.1, height_m = 0.2, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
        let toml = alloc::format!(
            r#"
            [[arena.circles]]
            name = "stool"
            x_m = 1.0
            y_m = 0.0
            radius_m = 0.2
            height_m = 0.4
            [[arena.circles]]
            name = "tower"
            x_m = 3.0
            y_m = 0.0
            radius_m = 0.5
            [[robots]]
            name = "a"
            {body}
            actuators.neck = {{ kind = "turret", min_rad = -1.0, max_rad = 1.0, rate_rad_s = 1.0 }}
            [robots.sensors.low]
            kind = "sonar"
            bearing_rad = 0.0
            opening_rad = 0.0
            rays = 1
            min_m = 0.0
            max_m = 5.0
            [robots.sensors.high]
            kind = "laser"
            mount = {{}}
            turret = "neck"
            height_m = 0.5
            opening_rad = 3.14159265358979312
            rays = 3
            range_m = 5.0
            [robots.sensors.whisker]
            kind = "whisker"
            bearing_rad = 1.57079632679489656
            length_m = 0.5
            [robots.sensors.bumper]
            kind = "bumper"
            opening_rad = 1.0
            rays = 5
            [robots.sensors.compass]
            kind = "compass"
            [[robots]]
            name = "b"
            start = {{ x_m = 0.0, y_m = 0.5 }}
            {body}
            "#
        );
        World::new(Scenario::parse(&toml).unwrap().into())
    }

    fn distances(name: &str) -> Vec<Option<f64>> {
        let world = world();
        let robot = world.robot(0);
        let sensor = robot.spec().sensors.iter().find(|sensor| sensor.name == name).unwrap();
        let glances = Onlooker::new(&world).sees(0, sensor);
        let rounded = |d: f64| baudbot_geometry::math::floor(d * 1e9 + 0.5) / 1e9;
        glances.iter().map(|glance| glance.distance_m.map(rounded)).collect()
    }

    #[test]
    fn each_sensor_sees_what_reaches_up_to_it() {
        assert_eq!(distances("low"), [Some(0.7)], "the stool is before the tower");
        assert_eq!(distances("high"), [None, Some(2.5), None], "it overlooks the stool and the robots");
        assert_eq!(distances("whisker"), [Some(0.3)], "the other robot is in its way");
    }

    #[test]
    fn a_bumper_has_rays_and_a_compass_has_none() {
        assert_eq!(distances("bumper"), [None; 5]);
        assert_eq!(distances("compass"), []);
    }
}
