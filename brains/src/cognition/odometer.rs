//! Where the robot is, from a sensor that says it: an odometer on the microcontroller, or a positioning system.

use baudbot_client::Body;
use baudbot_geometry::Pose;
use serde::Deserialize;

use crate::process::{CognitiveProcess, Estimate, Moment};

/// Which sensor.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Its name.
    pub sensor: String,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { sensor: "odometer".to_owned() }
    }
}

/// A process that believes an odometer.
#[derive(Clone, Debug, PartialEq)]
pub struct Odometer {
    sensor: usize,
}

impl Odometer {
    /// For a robot with this body; an error if it has no such sensor with x_m, y_m and heading_rad.
    ///
    /// # Errors
    /// In words.
    pub fn new(parameters: &Parameters, body: &Body) -> Result<Self, String> {
        let sensor = body.sensor_index(&parameters.sensor);
        let sensor = sensor.filter(|&sensor| body.sensors[sensor].values() >= 3);
        let sensor = sensor.ok_or_else(|| {
            format!(
                "sensor: robot `{}` has no `{}` with x_m, y_m and heading_rad",
                body.name, parameters.sensor
            )
        })?;
        Ok(Self { sensor })
    }
}

impl CognitiveProcess for Odometer {
    fn step(&mut self, moment: &mut Moment<'_>) {
        let reading = moment.turn.readings.get(self.sensor).and_then(Option::as_ref);
        let Some(reading) = reading.filter(|reading| reading.readable) else { return };
        let &[x_m, y_m, heading_rad, ..] = reading.values.as_slice() else { return };
        let at_ns = reading.sampled_at_ns.unwrap_or(moment.turn.at_ns);
        moment.beliefs.pose =
            Some(Estimate { pose: Pose::new(x_m, y_m, heading_rad), covariance_m2: None, at_ns });
    }
}
