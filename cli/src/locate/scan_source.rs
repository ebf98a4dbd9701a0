//! One scan of a simulated laser, from a robot that stands where it is put, and the map that it is matched with.

use std::sync::Arc;

use baudbot_brains::localization::Map;
use baudbot_brains::scan::Scan;
use baudbot_client::{Body, Reading};
use baudbot_geometry::Pose;
use baudbot_plot::quantity::handy;
use baudbot_sim::arena::Arena;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::sensor::{Device, Laser, Sensor};
use baudbot_sim::{Intervention, InterventionError, Scenario, SimTime, World};

use crate::args::LocateArgs;
use crate::error::Refused;

/// The robot that looks, and its sensor.
#[derive(Clone, Copy)]
pub(super) struct ScanSource<'a> {
    /// The robot's place among all.
    place: usize,
    pub(super) robot: &'a RobotSpec,
    /// The laser's place among the robot's sensors.
    sensor: usize,
    laser: &'a Laser,
}

impl<'a> ScanSource<'a> {
    /// The sources that are named, or the first that exist.
    pub(super) fn find(args: &LocateArgs, robots: &'a [RobotSpec]) -> anyhow::Result<Self> {
        let named = |(_, robot): &(usize, &RobotSpec)| match &args.robot {
            Some(name) => robot.name == *name,
            None => lasers(robot).next().is_some(),
        };
        let Some((place, robot)) = robots.iter().enumerate().find(named) else {
            let names = robots.iter().map(|robot| robot.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(Refused::error(match &args.robot {
                Some(name) => format!("--robot: there is no robot `{name}`; there are: {names}"),
                None => "no robot of the scenario has a laser; give it a sensor of kind \"laser\"".to_owned(),
            }));
        };
        let wanted = |(_, sensor, _): &(usize, &Sensor, &Laser)| {
            args.laser.as_ref().is_none_or(|name| sensor.name == *name)
        };
        // A laser on the body itself is chosen rather than one on a turret.
        let on_body = |(_, _, laser): &(usize, &Sensor, &Laser)| laser.mount.turret.is_none();
        let found = lasers(robot).filter(wanted).find(on_body).or_else(|| lasers(robot).find(wanted));
        let Some((sensor, _, laser)) = found else {
            let names =
                lasers(robot).map(|(_, sensor, _)| sensor.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(Refused::error(match &args.laser {
                Some(name) if names.is_empty() => {
                    format!("--laser: `{}` has no laser, so there is none called `{name}`", robot.name)
                }
                Some(name) => format!("--laser: `{}` has no laser `{name}`; it has: {names}", robot.name),
                None => format!("--robot: `{}` has no laser; give it a sensor of kind \"laser\"", robot.name),
            }));
        };
        Ok(Self { place, robot, sensor, laser })
    }

    /// The laser's name.
    pub(super) fn sensor(&self) -> &'a str {
        &self.robot.sensors[self.sensor].name
    }

    /// Everything that stands still and is as high as the laser.
    pub(super) fn map(&self, arena: &Arena) -> anyhow::Result<Map> {
        let above_floor_m = self.laser.mount.height.above_floor_m;
        let polygons = arena.polygons().iter().filter(|polygon| polygon.look.is_at(above_floor_m));
        let lines: Vec<_> = polygons.flat_map(|polygon| polygon.edges()).collect();
        let pillars = arena.pillars().iter().filter(|pillar| pillar.look.is_at(above_floor_m));
        let discs: Vec<_> = pillars.map(|pillar| pillar.circle).collect();
        if lines.is_empty() && discs.is_empty() {
            return Err(Refused::error(format!(
                "nothing in the scenario's arena is as high as the laser `{}`, {} m, so there is no map to match with",
                self.sensor(),
                handy(above_floor_m)
            )));
        }
        Map::new(lines, discs).map_err(|error| Refused::error(error.to_string()))
    }

    /// The first scan that the laser takes while the robot stands there, and where that is: it may have been pushed.
    pub(super) fn scan(&self, scenario: &Arc<Scenario>, at: Option<Pose>) -> anyhow::Result<(Scan, Pose)> {
        let mut world = World::new(Arc::clone(scenario));
        world.keep_timeline(0);
        let pose = at.unwrap_or(self.robot.start.pose);
        let put = Intervention::PlaceRobot { robot: self.robot.name.clone(), pose };
        world.intervene(&put).map_err(|error| refusal(at, &error))?;
        while world.time() <= PATIENCE && world.ending().is_none() {
            world.begin();
            let robot = world.robot(self.place);
            if let Some(sensor) = robot.sensors().nth(self.sensor)
                && sensor.samples > 0
            {
                return Ok((self.read(sensor.sample)?, robot.motion().pose));
            }
            world.finish(&[]);
        }
        Err(Refused::error(format!(
            "the laser `{}` takes no scan within {} s; is its period_ms longer, or does the scenario end before?",
            self.sensor(),
            handy(PATIENCE.as_seconds())
        )))
    }

    /// A sample as a brain takes a reading.
    fn read(&self, sample: &[f64]) -> anyhow::Result<Scan> {
        let reading = Reading { values: sample.to_vec(), sampled_at_ns: None, sequence: 0, readable: true };
        let scan = Scan::of(&Body::from(self.robot).sensors[self.sensor], &reading);
        scan.ok_or_else(|| {
            Refused::error(format!(
                "--laser: `{}` sits on a turret, and the search does not take that into account; choose another",
                self.sensor()
            ))
        })
    }
}

/// The lasers of a robot, with their places among its sensors.
fn lasers(robot: &RobotSpec) -> impl Iterator<Item = (usize, &Sensor, &Laser)> {
    robot.sensors.iter().enumerate().filter_map(|(i, sensor)| {
        if let Device::Laser(laser) = &sensor.device { Some((i, sensor, laser)) } else { None }
    })
}

/// In the words of the command line, why the robot cannot stand there.
fn refusal(at: Option<Pose>, error: &InterventionError) -> anyhow::Error {
    let option = if at.is_some() { "--at" } else { "--at (where the robot starts)" };
    Refused::error(format!("{option}: {error}; choose another place"))
}

/// No laser takes longer for a scan.
const PATIENCE: SimTime = SimTime::from_ns(60_000_000_000);
