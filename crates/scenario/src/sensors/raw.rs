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
    /// The device: one of the kinds of this page.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    pub(crate) kind: SensorKind,
    /// Time between two reads by the microcontroller. Default: `step_ms`.
    pub(crate) period_ms: Option<Number<Millis<Period>>>,
    /// Instant of the first read.
    #[serde(default)]
    pub(crate) phase_ms: Number<Millis<Between<0, 10_000_000>>>,
    /// How long a read keeps the microcontroller busy. What the device itself keeps it waiting (`sonar`,
    /// `photoresistor`) comes on top.
    #[serde(default)]
    pub(crate) acquisition_us: Number<Micros<Between<0, 1_000_000_000>>>,
    /// Bits of each value on the wire. Without it a value crosses as an exact 64-bit number. Range:
    /// `encoders`, `steps`, `optical-flow` 8 to 32; not with `port`.
    // The kind decides which range holds, so it is checked once that is known.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Number<Whole<1, 32, u8>>>"))]
    pub(crate) bits: Option<u64>,
    /// What disturbs its readings: [noise](#noise). Default: none. Range: not for digital kinds.
    #[serde(default)]
    pub(crate) noise: Noise,
    /// It measures at its own pace: [clock](#clock). Range: not `sonar`, `photoresistor`, `optical-flow`.
    pub(crate) clock: Option<Clock>,
    /// It has a cable of its own to the laptop: [port](#port). Range: `laser`, `line-camera`, `gps`.
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
    /// How far a specimen's period may be off, either way. Uniform, drawn once a run. Range: to 0.9 periods.
    #[serde(default)]
    pub(crate) spread_ms: Number<NotNegative>,
    /// How far each measurement may begin late. Uniform, drawn each time. It does not add up. Range: to one
    /// period.
    #[serde(default)]
    pub(crate) jitter_ms: Number<NotNegative>,
    /// When the first measurement begins. Default: anywhere in the first period, drawn once a run.
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
    /// What a receiver says of each fix: `RMC` alone, or `GGA`, `GSA`, three `GSV` and `RMC`. Default: `"all"`.
    /// Range: only `gps`.
    pub(crate) sentences: Option<Sentences>,
    /// Without it the device speaks by itself from the beginning. `"asked"`: it is silent and
    /// [answers](#dialogues-on-a-port). `"driver"`: the same, but a driver of the laptop's starts its scans.
    /// Range: only `laser`, not `clockwise`; not with `turnaround_us`.
    pub(crate) dialogue: Option<Begin>,
    /// Which commands it knows, and what it calls itself. Default: `"urg-04lx"`. Range: only with `dialogue`.
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
    /// On the body's rim at this angle from the heading, looking outwards. Of a body with corners the rim is
    /// that of the disc around it. Default: this one, or `mount`.
    pub(crate) bearing_rad: Option<Number<Turn>>,
    /// Anywhere on the robot, looking any way. Default: this one, or `bearing_rad`.
    pub(crate) mount: Option<Mount>,
    /// How high it sits. It sees what reaches up to there. Default: 0.0.
    pub(crate) height_m: Option<Number<Between<0, 100>>>,
    /// It sits on it and turns with it about the robot's centre. Bearing and mount are then those at the
    /// turret's 0. Range: name of a [turret](actuators.md#kind--turret-a-servo-that-turns-sensors) of the
    /// robot.
    pub(crate) turret: Option<String>,
}

pub(crate) const PLACE: [&str; 4] = ["bearing_rad", "mount", "height_m", "turret"];

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Mount {
    /// Forwards of the robot's centre. Range: at most two body radii either way.
    #[serde(default)]
    pub(crate) x_m: f64,
    /// To the left of the robot's centre. Range: at most two body radii either way.
    #[serde(default)]
    pub(crate) y_m: f64,
    /// Which way it looks, from the robot's heading.
    #[serde(default)]
    pub(crate) heading_rad: Number<Turn>,
}
