//! From a sensor's table to a [`Sensor`].

use alloc::format;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};

use baudbot_geometry::{Direction, Fan, Pose};
use baudbot_wire::Encoding;
use toml::{Table, Value};

use super::check::Path;
use super::error::deserialize;
use super::{ScenarioError, build::MIN_PERIOD_MS};
use crate::schedule::Schedule;
use crate::sensor::{Compass, Device, Encoders, Infrared, Mount, Odometer, Sensor};

/// What is the same for every kind of sensor.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Common {
    kind: Kind,
    period_ms: Option<f64>,
    #[serde(default)]
    phase_ms: f64,
    #[serde(default)]
    acquisition_us: f64,
    bits: Option<u64>,
}

const COMMON_FIELDS: [&str; 5] = ["kind", "period_ms", "phase_ms", "acquisition_us", "bits"];

#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Ir,
    Encoders,
    Odometer,
    Compass,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawInfrared {
    bearing_rad: Option<f64>,
    mount: Option<RawMount>,
    opening_rad: f64,
    rays: u64,
    range_m: f64,
    c1_m2: f64,
    c2: f64,
    #[serde(default)]
    sigma: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMount {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEncoders {
    counts_per_turn: u64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawOdometer {
    #[serde(default)]
    sigma_m: f64,
    /// Farthest position that an odometer of few bits can tell.
    #[serde(default = "default_position_range_m")]
    position_range_m: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCompass {
    #[serde(default)]
    sigma_rad: f64,
}

fn default_position_range_m() -> f64 {
    10.0
}

/// The sensor of this name, on a robot of this radius in a world of this step.
pub(super) fn sensor(
    path: &Path,
    name: String,
    mut table: Table,
    step_ms: f64,
    radius_m: f64,
) -> Result<Sensor, ScenarioError> {
    let mut common = Table::new();
    for field in COMMON_FIELDS {
        if let Some(value) = table.remove(field) {
            common.insert(field.into(), value);
        }
    }
    let common: Common = deserialize(path.as_str(), Value::Table(common))?;
    let (device, encodings) = device(path, common.kind, Value::Table(table), common.bits, radius_m)?;
    let period_ns = path.ms("period_ms", common.period_ms.unwrap_or(step_ms), MIN_PERIOD_MS, 1e7)?;
    let phase_ns = path.ms("phase_ms", common.phase_ms, 0.0, 1e7)?;
    let acquisition_ns = path.us("acquisition_us", common.acquisition_us, 1e9)?;
    Ok(Sensor { name, device, schedule: Schedule::new(period_ns, phase_ns), acquisition_ns, encodings })
}

fn device(
    path: &Path,
    kind: Kind,
    table: Value,
    bits: Option<u64>,
    radius_m: f64,
) -> Result<(Device, Vec<Encoding>), ScenarioError> {
    let at = path.as_str();
    Ok(match kind {
        Kind::Ir => {
            let device = infrared(path, deserialize(at, table)?, radius_m)?;
            (Device::Infrared(device), vec![level(path, bits, 0.0, 1.0)?])
        }
        Kind::Compass => {
            let raw: RawCompass = deserialize(at, table)?;
            let sigma_rad = path.sigma("sigma_rad", raw.sigma_rad)?;
            (Device::Compass(Compass { sigma_rad }), vec![level(path, bits, -PI, PI)?])
        }
        Kind::Encoders => {
            let raw: RawEncoders = deserialize(at, table)?;
            let counts_per_turn =
                path.whole_within("counts_per_turn", raw.counts_per_turn, 1, 1_000_000)? as u32;
            (Device::Encoders(Encoders { counts_per_turn }), vec![counter(path, bits)?; 2])
        }
        Kind::Odometer => {
            let raw: RawOdometer = deserialize(at, table)?;
            let sigma_m = path.sigma("sigma_m", raw.sigma_m)?;
            let range = path.length("position_range_m", raw.position_range_m)?;
            let position = level(path, bits, -range, range)?;
            let encodings = vec![position, position, level(path, bits, -PI, PI)?];
            (Device::Odometer(Odometer { sigma_m }), encodings)
        }
    })
}

fn infrared(path: &Path, raw: RawInfrared, radius_m: f64) -> Result<Infrared, ScenarioError> {
    let mount = mount(path, raw.bearing_rad, raw.mount, radius_m)?;
    let opening_rad = path.within("opening_rad", raw.opening_rad, 0.0, PI)?;
    let rays = path.whole_within("rays", raw.rays, 1, 10_000)? as usize;
    Ok(Infrared {
        mount,
        fan: Fan::new(opening_rad, rays),
        range_m: path.length("range_m", raw.range_m)?,
        c1_m2: path.not_negative("c1_m2", raw.c1_m2)?,
        c2: path.not_negative("c2", raw.c2)?,
        sigma: path.sigma("sigma", raw.sigma)?,
    })
}

/// On the rim looking outwards, or anywhere looking any way.
fn mount(
    path: &Path,
    bearing_rad: Option<f64>,
    mount: Option<RawMount>,
    radius_m: f64,
) -> Result<Mount, ScenarioError> {
    match (bearing_rad, mount) {
        (Some(bearing), None) => {
            let bearing = path.within("bearing_rad", bearing, -TAU, TAU)?;
            let rim = Direction::from_angle(bearing).vector() * radius_m;
            Ok(Pose::new(rim.x, rim.y, bearing))
        }
        (None, Some(mount)) => {
            let path = path.field("mount");
            let heading = path.within("heading_rad", mount.heading_rad, -TAU, TAU)?;
            // Farther out a sensor would look through walls that the body has not reached.
            let reach = 2.0 * radius_m;
            let x = path.within("x_m", mount.x_m, -reach, reach)?;
            Ok(Pose::new(x, path.within("y_m", mount.y_m, -reach, reach)?, heading))
        }
        _ => Err(path.error("needs either `bearing_rad` (on the rim, looking outwards) or `mount`")),
    }
}

fn level(path: &Path, bits: Option<u64>, min: f64, max: f64) -> Result<Encoding, ScenarioError> {
    let Some(bits) = bits else { return Ok(Encoding::Float64) };
    let bits = path.whole_within("bits", bits, 1, 32)? as u8;
    Ok(Encoding::Level { bits, min, max })
}

fn counter(path: &Path, bits: Option<u64>) -> Result<Encoding, ScenarioError> {
    let Some(bits) = bits else { return Ok(Encoding::Float64) };
    if bits < 8 {
        return Err(path.field("bits").error(format!("a counter has 8 to 32 bits, not {bits}")));
    }
    let bits = path.whole_within("bits", bits, 8, 32)? as u8;
    Ok(Encoding::Counter { bits })
}
