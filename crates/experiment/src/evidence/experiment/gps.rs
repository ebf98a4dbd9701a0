//! A satellite receiver that does not move.

use serde::Deserialize;

use super::{ExperimentError, lab};
use crate::evidence::at::At;
use crate::evidence::sample::Sample;

/// Fixes of a preset, by its brain.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AtRest {
    /// The preset of the receiver.
    pub preset: String,
    /// The duration, in seconds.
    pub seconds: f64,
    /// Number of receivers.
    pub specimens: u64,
}

impl AtRest {
    /// The standard deviations of the fixes on each axis, in metres, one for each receiver.
    pub(super) fn run(&self, axis: &str) -> Result<Vec<f64>, ExperimentError> {
        if axis != "latitude" {
            return Err(ExperimentError::At { expected: "`latitude`", at: At::Name(axis.into()) });
        }
        let toml = format!(
            "step_ms = 100.0\nsubsteps = 100\n[[robots]]\nname = \"robot\"\n{}\nsensors.gps.preset = \"{}\"\n",
            lab::DISC,
            self.preset
        );
        let mut deviations = Vec::new();
        for mut world in lab::specimens(&toml, self.specimens)? {
            let (mut fixes, mut samples) = (Vec::new(), 0);
            while world.time().as_seconds() < self.seconds {
                lab::idle(&mut world);
                let robot = world.robot(0);
                let Some(sensor) = robot.sensors().next() else { break };
                if sensor.samples > samples {
                    samples = sensor.samples;
                    fixes.extend(sensor.sample.first().map(|degrees| degrees * METRES_PER_DEGREE));
                }
            }
            deviations.extend(Sample::of(&fixes).map(|sample| sample.sd));
        }
        Ok(deviations)
    }
}

/// The length of a degree of latitude, in metres.
const METRES_PER_DEGREE: f64 = 111_194.9;
