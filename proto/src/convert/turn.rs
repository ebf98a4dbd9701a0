//! The Turns of brains.

use baudbot_brain::{Body, Reading, Sensor};

use super::breach::{Breach, item};
use crate::v1;

/// The readings of a turn of the robot with this body, in the order of its sensors; `None` where none has come.
///
/// # Errors
/// If a reading is of no sensor of the body, or has another number of values.
pub fn readings(given: Vec<v1::Reading>, body: &Body) -> Result<Vec<Option<Reading>>, Breach> {
    let mut readings = vec![None; body.sensors.len()];
    for given in given {
        let (place, sensor) = item(&body.sensors, given.sensor, "sensor")?;
        readings[place] = Some(reading(given, sensor)?);
    }
    Ok(readings)
}

/// The bytes of a turn that came on cables of sensors' own, each with its sensor's place in the body.
///
/// # Errors
/// If one is of no sensor of the body.
pub fn ports(given: Vec<v1::PortBytes>, body: &Body) -> Result<Vec<(usize, Vec<u8>)>, Breach> {
    let port = |v1::PortBytes { sensor, data, after_ns: _, baud: _ }| {
        Ok((item(&body.sensors, sensor, "sensor")?.0, data))
    };
    given.into_iter().map(port).collect()
}

fn reading(given: v1::Reading, sensor: &Sensor) -> Result<Reading, Breach> {
    let v1::Reading { sensor: _, values, sampled_at_ns, sequence, readable } = given;
    let (expected, found) = (sensor.values(), values.len());
    if expected != found {
        return Err(Breach::Values { sensor: sensor.name.clone(), expected, found });
    }
    Ok(Reading { values, sampled_at_ns, sequence, readable })
}
