//! The fields of any sensor's table, besides those of its kind.

use alloc::string::String;

use baudbot_fields::number::{Between, Micros, Millis, NotNegative, Number, Turn, Whole};
use baudbot_sim::sensor::dialogue::Begin;
use baudbot_sim::sensor::{Noise, SensorKind};

use crate::context::Period;
use crate::raw::Link;

/// The fields that every kind of sensor has.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Common {
    /// Kind of sensor: one of those on this page.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    pub(crate) kind: SensorKind,
    /// Time between two reads by the microcontroller. Default: `step_ms`.
    pub(crate) period_ms: Option<Number<Millis<Period>>>,
    /// Instant of the first read.
    #[serde(default)]
    pub(crate) phase_ms: Number<Millis<Between<0, 10_000_000>>>,
    /// Time for which a read occupies the microcontroller. The time for which the device itself makes it wait
    /// (`sonar`, `photoresistor`) is added.
    #[serde(default)]
    pub(crate) acquisition_us: Number<Micros<Between<0, 1_000_000_000>>>,
    /// Bits of each value on the wire. Without it a value is sent as an exact 64-bit number. Range: `encoders`,
    /// `steps`, `optical-flow` 8 to 32; not with `port`.
    // The kind decides which range holds, so it is checked once that is known.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Number<Whole<1, 32, u8>>>"))]
    pub(crate) bits: Option<u64>,
    /// Errors of the readings: [noise](#noise). Default: none. Range: not for digital kinds.
    #[serde(default)]
    pub(crate) noise: Noise,
    /// The sensor's own clock, by which it measures: [clock](#clock). Range: not `sonar`, `photoresistor`,
    /// `optical-flow`.
    pub(crate) clock: Option<Clock>,
    /// The sensor's own cable to the laptop: [port](#port). Range: `laser`, `line-camera`, `camera`,
    /// `gps`.
    pub(crate) port: Option<Port>,
}

pub(crate) const COMMON: [&str; 8] =
    ["kind", "period_ms", "phase_ms", "acquisition_us", "bits", "noise", "clock", "port"];

/// A device that measures at its own pace.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Clock {
    /// Time between the starts of two measurements.
    pub(crate) period_ms: Number<Period>,
    /// Maximum deviation of a specimen's period, in either direction: uniform, drawn once per run. Range: to 0.9
    /// periods.
    #[serde(default)]
    pub(crate) spread_ms: Number<NotNegative>,
    /// Maximum delay of the start of each measurement: uniform, drawn each time, not cumulative. Range: to one
    /// period.
    #[serde(default)]
    pub(crate) jitter_ms: Number<NotNegative>,
    /// Start of the first measurement. Default: random within the first period, drawn once per run.
    pub(crate) phase_ms: Option<Number<Millis<Between<0, 10_000_000>>>>,
    /// Time from the end of a measurement until its value is at the output.
    #[serde(default)]
    pub(crate) latency_ms: Number<Millis<Between<0, 1_000_000>>>,
}

/// A cable of a device's own.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Port {
    /// The cable, with the fields of [`robots.link`](scenario.md#robotslink). Range: any link but `onboard`.
    pub(crate) link: Link,
    /// Characters of a distance: 2 reach 4.095 m, 3 reach 262 m. Default: 3. Range: 2 or 3; only `laser`.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = [2, 3])))]
    pub(crate) characters: Option<u64>,
    /// Number of the first ray in the messages. Default: 0. Range: the last step included; only
    /// `laser`.
    pub(crate) first_step: Option<Number<Whole<0, 9999>>>,
    /// Sentences that a receiver sends for each fix: `RMC` alone, or `GGA`, `GSA`, three `GSV` and `RMC`. Default:
    /// `"all"`. Range: only `gps`.
    pub(crate) sentences: Option<Sentences>,
    /// Without it the device sends unasked from the start. `"asked"`: it only [answers](#dialogues-on-a-port).
    /// `"driver"`: the same, but a driver on the laptop starts its scans. Range: only `laser`, not `clockwise`; not
    /// with `turnaround_us`.
    pub(crate) dialogue: Option<Begin>,
    /// Model of the device, which determines its commands and the name that it reports. Default: `"urg-04lx"`. Range:
    /// only with `dialogue`.
    pub(crate) model: Option<Model>,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) enum Model {
    #[serde(rename = "urg-04lx")]
    Urg04lx,
    #[serde(rename = "ust-10lx")]
    Ust10lx,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) enum Sentences {
    Rmc,
    All,
}

/// Where a sensor sits and which way it looks.
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Place {
    /// Angle from the heading at which the sensor sits on the body's rim, looking outwards. The rim of a body with
    /// corners is that of the disc around it. Default: this one, or `mount`.
    pub(crate) bearing_rad: Option<Number<Turn>>,
    /// Place anywhere on the robot, with any direction. Default: this one, or `bearing_rad`.
    pub(crate) mount: Option<Mount>,
    /// Height above the floor. The sensor sees only things that are at least this high. Default: 0.0.
    pub(crate) height_m: Option<Number<Between<0, 100>>>,
    /// Turret that carries the sensor and turns it about the robot's centre. `bearing_rad` and `mount` are then those
    /// at the turret's 0. Range: name of a [turret](actuators.md#kind--turret-a-servo-that-turns-sensors) of the
    /// robot.
    pub(crate) turret: Option<String>,
    /// Angle by which the rays rise above the horizon, each at its own bearing; negative: they look down, and meet the floor, too. Range: −1.5 to 1.5; `sonar`, `laser`,
    /// `ir` and `ir-voltage`.
    pub(crate) elevation_rad: Option<Number<Elevation>>,
}

baudbot_fields::rules! {
    /// An angle above or below the horizon, in radians.
    Elevation: Any, -1.5, 1.5;
}

pub(crate) const PLACE: [&str; 5] = ["bearing_rad", "mount", "height_m", "turret", "elevation_rad"];

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Mount {
    /// Distance forwards from the robot's centre. Range: at most two body radii either way.
    #[serde(default)]
    pub(crate) x_m: f64,
    /// Distance to the left from the robot's centre. Range: at most two body radii either way.
    #[serde(default)]
    pub(crate) y_m: f64,
    /// Direction of view, from the robot's heading.
    #[serde(default)]
    pub(crate) heading_rad: Number<Turn>,
}
