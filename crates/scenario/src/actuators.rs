//! Actuators besides the wheels, and the battery: what a file may say of them.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::f64::consts::TAU;

use toml::Table;

use super::error::Sheet;
use baudbot_fields::{FieldError, Fields, Path};
use baudbot_sim::actuator::{Actuator, ActuatorKind};
use baudbot_sim::battery::Battery;
use baudbot_sim::motor::PositionalServo;

/// The kind of actuator. Default: required.
#[derive(Clone, Copy, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) enum RawActuatorKind {
    Turret,
    Lamp,
    Speaker,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawTurret {
    /// Limit to the right. Range: −2π to 0.
    min_rad: f64,
    /// Limit to the left. Range: 0 to 2π.
    max_rad: f64,
    /// How fast it turns. Range: positive.
    rate_rad_s: f64,
    /// The turret does not move if the commanded angle is this close. Range: 0 to 1.
    #[serde(default)]
    dead_band_rad: f64,
    /// Time between two pulses. A command takes effect with the next one; with 0, immediately. Range: 0 to
    /// 1000.
    #[serde(default = "frame_ms")]
    frame_ms: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawLamp {
    /// Luminous intensity at signal 1, the same in all directions, in candela. Range: positive.
    intensity_cd: f64,
    /// Height above the floor. Range: 0 to 1000.
    #[serde(default)]
    height_m: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawSpeaker {
    /// Loudness at signal 1, at a distance of 1 m. Range: above 0, at most 10^9.
    level: f64,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawBattery {
    /// Nominal voltage. Range: 0.001 to 10^6.
    nominal_v: f64,
    /// Charge when full, in mAh. Range: positive.
    capacity_mah: f64,
    /// Lowers the voltage under load. Range: not negative.
    #[serde(default)]
    internal_resistance_ohm: f64,
    /// Constant power of the robot's electronics. Range: not negative.
    #[serde(default)]
    idle_w: f64,
    /// Voltage without load, relative to the nominal one, over the remaining share of the charge: linear
    /// between the points, constant beyond the ends. Type: list of `[charge, voltage]`. Default: one for NiMH
    /// cells. Range: at least 1 point; charges 0 to 1, increasing; voltages 0 to 10.
    curve_share_v: Option<Vec<(f64, f64)>>,
    /// Share of the capacity that a constant current in A gets out of the full battery: linear between the
    /// points, constant beyond the ends. Without it every current gets all of it. Type: list of `[current,
    /// share]`. Default: none. Range: currents 0 to 10^6, increasing; shares 0.001 to 1.
    #[serde(default)]
    capacity_a_share: Vec<(f64, f64)>,
    /// Share of the charge at the start. Default: 1.0. Range: 0 to 1.
    charge: Option<f64>,
}

fn frame_ms() -> f64 {
    20.0
}

type Result<T> = core::result::Result<T, FieldError>;

/// The actuator of this name.
pub(super) fn actuator(path: &Path, name: String, mut table: Table) -> Result<Actuator> {
    let kind = table.remove("kind").ok_or_else(|| {
        path.field("kind").error("is missing; an actuator is a `turret`, a `lamp` or a `speaker`")
    })?;
    let kind: RawActuatorKind = Sheet::from(kind).read(&path.field("kind"))?;
    let fields = Sheet::from(table);
    let kind = match kind {
        RawActuatorKind::Turret => turret(path, &fields.read(path)?)?,
        RawActuatorKind::Lamp => {
            let raw: RawLamp = fields.read(path)?;
            ActuatorKind::Lamp {
                intensity_cd: path.positive("intensity_cd", raw.intensity_cd)?,
                height_m: path.within("height_m", raw.height_m, 0.0, 1e3)?,
            }
        }
        RawActuatorKind::Speaker => {
            let raw: RawSpeaker = fields.read(path)?;
            path.positive("level", raw.level)?;
            ActuatorKind::Speaker { level: path.within("level", raw.level, 0.0, 1e9)? }
        }
    };
    Ok(Actuator { name, kind })
}

fn turret(path: &Path, raw: &RawTurret) -> Result<ActuatorKind> {
    let min = path.within("min_rad", raw.min_rad, -TAU, 0.0)?;
    let max = path.within("max_rad", raw.max_rad, 0.0, TAU)?;
    Ok(ActuatorKind::Turret(PositionalServo {
        range_rad: [min, max],
        rate_rad_s: path.positive("rate_rad_s", raw.rate_rad_s)?,
        dead_band_rad: path.within("dead_band_rad", raw.dead_band_rad, 0.0, 1.0)?,
        frame_ns: path.ms("frame_ms", raw.frame_ms, 0.0, 1e3)?,
    }))
}

/// A battery, and how full it is at the start.
pub(super) fn battery(path: &Path, raw: RawBattery) -> Result<(Battery, f64)> {
    let curve = raw.curve_share_v.unwrap_or_else(Battery::nimh_curve);
    let at = path.field("curve_share_v");
    for (i, pair) in curve.iter().enumerate() {
        at.index(i).within("share", pair.0, 0.0, 1.0)?;
        at.index(i).within("voltage", pair.1, 0.0, 10.0)?;
        if i > 0 && pair.0 <= curve[i - 1].0 {
            return Err(at.index(i).error(format!(
                "shares must increase, {} follows {}",
                pair.0,
                curve[i - 1].0
            )));
        }
    }
    if curve.is_empty() {
        return Err(at.error("needs at least one pair of charge left and share of the nominal voltage"));
    }
    path.positive("nominal_v", raw.nominal_v)?;
    let battery = Battery {
        nominal_v: path.within("nominal_v", raw.nominal_v, 1e-3, 1e6)?,
        capacity_c: Battery::coulombs(path.positive("capacity_mah", raw.capacity_mah)?),
        internal_resistance_ohm: path.not_negative("internal_resistance_ohm", raw.internal_resistance_ohm)?,
        curve,
        yields: yields(&path.field("capacity_a_share"), raw.capacity_a_share)?,
        idle_w: path.not_negative("idle_w", raw.idle_w)?,
    };
    Ok((battery, path.within("charge", raw.charge.unwrap_or(1.0), 0.0, 1.0)?))
}

/// Which share of its capacity a battery gives at which current.
fn yields(path: &Path, points: Vec<(f64, f64)>) -> Result<Vec<(f64, f64)>> {
    for (i, &(current, share)) in points.iter().enumerate() {
        path.index(i).within("current", current, 0.0, 1e6)?;
        path.index(i).within("share", share, MIN_YIELD, 1.0)?;
        if i > 0 && current <= points[i - 1].0 {
            let problem = format!("currents must increase, {current} follows {}", points[i - 1].0);
            return Err(path.index(i).error(problem));
        }
    }
    Ok(points)
}

/// A battery that gives less of its capacity gives nothing.
const MIN_YIELD: f64 = 1e-3;
