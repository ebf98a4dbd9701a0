//! When the sensors of a robot are read.

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
    /// What is compared.
    pub of: Instants,
}

/// What is compared of the instants at which a sensor is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Instants {
    /// The time between two of them, in milliseconds.
    Period,
    /// The time since the first sensor was read, in milliseconds.
    Phase,
}

impl Sampling {
    pub(super) fn run(&self, number: f64) -> Result<Vec<f64>, ExperimentError> {
        let toml = format!("step_ms = 1.0\n[[robots]]\nname = \"robot\"\npreset = \"{}\"\n", self.preset);
        let (own, first) = (format!("{}{number}", self.sensor), format!("{}0", self.sensor));
        let mut differences = Vec::new();
        for mut world in lab::specimens(&toml, 1)? {
            let names: Vec<_> =
                world.robot(0).spec().sensors.iter().map(|sensor| sensor.name.clone()).collect();
            let place = |wanted: &str| names.iter().position(|name| name == wanted);
            let Some((own, first)) = place(&own).zip(place(&first)) else { continue };
            let mut instants: [Vec<u64>; 2] = Default::default();
            for _ in 0..1000 {
                lab::idle(&mut world);
                let sampled: Vec<_> =
                    world.robot(0).sensors().map(|sensor| (sensor.samples, sensor.sampled_at)).collect();
                for (instants, place) in instants.iter_mut().zip([own, first]) {
                    let (samples, at) = sampled[place];
                    if samples as usize > instants.len() {
                        instants.push(at.as_ns());
                    }
                }
            }
            let [own, first] = instants;
            match self.of {
                Instants::Period => {
                    differences.extend(own.windows(2).map(|pair| (pair[1] - pair[0]) as f64 * 1e-6))
                }
                Instants::Phase => {
                    differences.extend(
                        own.iter().zip(&first).map(|(own, first)| own.saturating_sub(*first) as f64 * 1e-6),
                    );
                }
            }
        }
        Ok(differences)
    }
}
