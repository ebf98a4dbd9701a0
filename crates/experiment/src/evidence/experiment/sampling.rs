//! The times at which the sensors of a robot are read.

use baudbot_sim::World;
use serde::Deserialize;

use super::{ExperimentError, lab};

/// The sensors of a robot that stands alone.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// The preset of the robot.
    pub preset: String,
    /// The first part of the sensors' names; the rest is where the points are.
    pub sensor: String,
    /// The quantity that is compared.
    pub of: Instants,
}

/// A quantity of the instants at which a sensor is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Instants {
    /// The time between two of them, in milliseconds.
    Period,
    /// The time since sensor 0 was read, in milliseconds.
    Phase,
}

impl Sampling {
    pub(super) fn run(&self, number: f64) -> Result<Vec<f64>, ExperimentError> {
        let toml = format!("step_ms = 1.0\n[[robots]]\nname = \"robot\"\npreset = \"{}\"\n", self.preset);
        let names = [number, 0.0].map(|number| format!("{}{number}", self.sensor));
        let world = lab::specimens(&toml, 1)?.next();
        let Some([own, first]) = world.and_then(|world| instants_ns(world, &names)) else {
            return Ok(Vec::new());
        };
        let between = |from: u64, to: u64| to.saturating_sub(from) as f64 * 1e-6;
        Ok(match self.of {
            Instants::Period => own.windows(2).map(|pair| between(pair[0], pair[1])).collect(),
            Instants::Phase => first.iter().zip(&own).map(|(first, own)| between(*first, *own)).collect(),
        })
    }
}

/// The instants at which these sensors are read within a second.
fn instants_ns(mut world: World, names: &[String; 2]) -> Option<[Vec<u64>; 2]> {
    let robot = world.robot(0);
    let mut sensors = robot.spec().sensors.iter().map(|sensor| &sensor.name);
    let first = sensors.clone().position(|name| *name == names[1])?;
    let places = [sensors.position(|name| *name == names[0])?, first];
    let mut instants: [Vec<u64>; 2] = Default::default();
    while world.time().as_seconds() < 1.0 {
        lab::idle(&mut world);
        let sensors: Vec<_> = world.robot(0).sensors().collect();
        for (instants, place) in instants.iter_mut().zip(places) {
            if sensors[place].samples as usize > instants.len() {
                instants.push(sensors[place].sampled_at.as_ns());
            }
        }
    }
    Some(instants)
}
