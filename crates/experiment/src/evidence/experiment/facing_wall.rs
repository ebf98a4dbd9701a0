//! A sensor before a white wall, at the distances of the points.

use baudbot_sim::World;
use serde::Deserialize;

use super::{ExperimentError, lab};

/// A sensor of a preset, on the rim of a robot that stands square to a wall.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FacingWall {
    /// The preset of the sensor.
    pub preset: String,
    /// Factor from the sensor's unit to that of the measured values.
    pub scale: f64,
    /// Factor from the measured distances to metres.
    pub x_m: f64,
    /// Number of specimens.
    pub specimens: u64,
    /// Readings of each.
    pub readings: usize,
}

impl FacingWall {
    pub(super) fn run(&self, distance: f64) -> Result<Vec<f64>, ExperimentError> {
        let wall_m = lab::RIM_M + distance * self.x_m;
        let back_m = wall_m + 0.1;
        let toml = format!(
            "step_ms = 5.0\nsubsteps = 10\n\
             [[arena.polygons]]\nname = \"wall\"\nsolid = true\n\
             points_m = [[{wall_m:?}, -3.0], [{back_m:?}, -3.0], [{back_m:?}, 3.0], [{wall_m:?}, 3.0]]\n\
             [[robots]]\nname = \"robot\"\n{}\n\
             sensors.sensor.preset = \"{}\"\n",
            lab::DISC,
            self.preset
        );
        let readings = lab::specimens(&toml, self.specimens)?.flat_map(|world| self.read(world));
        Ok(readings.map(|value| value * self.scale).collect())
    }

    /// The readings of a specimen as its brain gets them.
    fn read(&self, mut world: World) -> Vec<f64> {
        // A device with a clock of its own has no value at first.
        while world.time().as_seconds() < SETTLED_S {
            lab::idle(&mut world);
        }
        let (mut values, mut samples) = (Vec::new(), 0);
        while values.len() < self.readings {
            lab::idle(&mut world);
            let robot = world.robot(0);
            let taken = robot.sensors().next().map_or(0, |sensor| sensor.samples);
            let arrived = robot.readings().first().and_then(|reading| reading.values.first().copied());
            if let Some(value) = arrived.filter(|_| taken > samples) {
                values.push(value);
                samples = taken;
            }
        }
        values
    }
}

/// The time after which every sensor has read what is before it, in seconds.
const SETTLED_S: f64 = 0.2;
