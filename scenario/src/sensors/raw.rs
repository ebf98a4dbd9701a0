//! The fields of any sensor's table, besides those of its kind.

use alloc::string::String;

use baudbot_sim::sensor::{Noise, SensorKind};

use crate::raw::Link;

/// The fields that every kind of sensor has.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Common {
    pub(super) kind: SensorKind,
    pub(super) period_ms: Option<f64>,
    #[serde(default)]
    pub(super) phase_ms: f64,
    #[serde(default)]
    pub(super) acquisition_us: f64,
    pub(super) bits: Option<u64>,
    #[serde(default)]
    pub(super) noise: Noise,
    pub(super) clock: Option<Clock>,
    pub(super) port: Option<Port>,
}

pub(super) const COMMON: [&str; 8] =
    ["kind", "period_ms", "phase_ms", "acquisition_us", "bits", "noise", "clock", "port"];

/// A device that measures at its own pace.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Clock {
    pub(super) period_ms: f64,
    #[serde(default)]
    pub(super) spread_ms: f64,
    #[serde(default)]
    pub(super) jitter_ms: f64,
    pub(super) phase_ms: Option<f64>,
    #[serde(default)]
    pub(super) latency_ms: f64,
}

/// A cable of a device's own.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Port {
    pub(super) link: Link,
    pub(super) characters: Option<u64>,
    pub(super) first_step: Option<u64>,
    pub(super) sentences: Option<Sentences>,
    pub(super) dialogue: Option<Dialogue>,
    pub(super) model: Option<Model>,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Dialogue {
    Asked,
    Driver,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
pub(super) enum Model {
    #[serde(rename = "urg-04lx")]
    Urg04lx,
    #[serde(rename = "ust-10lx")]
    Ust10lx,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Sentences {
    Rmc,
    All,
}

/// Where a sensor sits and which way it looks.
#[derive(Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Place {
    pub(super) bearing_rad: Option<f64>,
    pub(super) mount: Option<Mount>,
    pub(super) height_m: Option<f64>,
    pub(super) turret: Option<String>,
}

pub(super) const PLACE: [&str; 4] = ["bearing_rad", "mount", "height_m", "turret"];

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mount {
    #[serde(default)]
    pub(super) x_m: f64,
    #[serde(default)]
    pub(super) y_m: f64,
    #[serde(default)]
    pub(super) heading_rad: f64,
}
