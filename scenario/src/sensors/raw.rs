//! What the table of a sensor may contain, kind by kind, besides what is common to all.

use alloc::string::String;
use alloc::vec::Vec;

use crate::noise::{RawLookup, RawNoise};
use crate::raw::Link;

/// What is the same for every kind of sensor.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Common {
    pub(super) kind: Kind,
    pub(super) period_ms: Option<f64>,
    #[serde(default)]
    pub(super) phase_ms: f64,
    #[serde(default)]
    pub(super) acquisition_us: f64,
    pub(super) bits: Option<u64>,
    #[serde(default)]
    pub(super) noise: RawNoise,
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
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Sentences {
    Rmc,
    All,
}

#[derive(Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Kind {
    Ir,
    IrVoltage,
    Sonar,
    Laser,
    LineCamera,
    Encoders,
    Steps,
    Odometer,
    Compass,
    Accelerometer,
    Gyroscope,
    Gps,
    Whisker,
    Bumper,
    Photoresistor,
    Light,
    Field,
    Microphone,
    Floor,
    Battery,
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

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Infrared {
    pub(super) opening_rad: f64,
    pub(super) rays: u64,
    pub(super) range_m: f64,
    pub(super) c1_m2: Option<f64>,
    pub(super) c2: Option<f64>,
    pub(super) lookup: Option<RawLookup>,
    pub(super) ambient_saturation_lux: Option<f64>,
    #[serde(default)]
    pub(super) sigma: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VoltageRanger {
    pub(super) opening_rad: f64,
    pub(super) rays: u64,
    pub(super) range_m: f64,
    pub(super) curve_m_v: Vec<[f64; 2]>,
    pub(super) idle_v: f64,
    pub(super) supply_v: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sonar {
    pub(super) opening_rad: f64,
    pub(super) rays: u64,
    pub(super) min_m: f64,
    pub(super) max_m: f64,
    #[serde(default = "one")]
    pub(super) detection: f64,
    #[serde(default = "sound_m_s")]
    pub(super) sound_m_s: f64,
    #[serde(default)]
    pub(super) holdoff_us: f64,
    pub(super) timeout_ms: Option<f64>,
    #[serde(default)]
    pub(super) cross_talk: bool,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Laser {
    pub(super) opening_rad: f64,
    pub(super) rays: u64,
    #[serde(default)]
    pub(super) min_m: f64,
    pub(super) range_m: f64,
    #[serde(default)]
    pub(super) sweep_ms: f64,
    #[serde(default)]
    pub(super) clockwise: bool,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LineCamera {
    pub(super) opening_rad: f64,
    pub(super) columns: u64,
    pub(super) range_m: f64,
    #[serde(default)]
    pub(super) background: [u8; 3],
    #[serde(default = "one_row")]
    pub(super) rows: u64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Encoders {
    pub(super) counts_per_turn: u64,
    #[serde(default = "yes")]
    pub(super) quadrature: bool,
    #[serde(default)]
    pub(super) loss: f64,
}

/// For the kinds that have no fields of their own.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Nothing {}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Odometer {
    #[serde(default)]
    pub(super) sigma_m: f64,
    /// Farthest position that an odometer of few bits can tell.
    #[serde(default = "position_range_m")]
    pub(super) position_range_m: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Compass {
    #[serde(default)]
    pub(super) sigma_rad: f64,
    #[serde(default)]
    pub(super) hard_iron_rad: f64,
    #[serde(default)]
    pub(super) hard_iron_phase_rad: f64,
    #[serde(default)]
    pub(super) soft_iron_rad: f64,
    #[serde(default)]
    pub(super) soft_iron_phase_rad: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Accelerometer {
    pub(super) range_m_s2: f64,
    pub(super) bandwidth_hz: Option<f64>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Gyroscope {
    pub(super) range_rad_s: f64,
    pub(super) bandwidth_hz: Option<f64>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Gps {
    #[serde(default)]
    pub(super) wander_sigma_m: f64,
    #[serde(default = "wander_time_s")]
    pub(super) wander_time_s: f64,
    #[serde(default)]
    pub(super) sigma_m: f64,
    #[serde(default)]
    pub(super) speed_sigma_m_s: f64,
    #[serde(default)]
    pub(super) reacquire_s: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Whisker {
    pub(super) length_m: f64,
    #[serde(default)]
    pub(super) active_low: bool,
    #[serde(default)]
    pub(super) bounce_ms: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Bumper {
    pub(super) opening_rad: f64,
    #[serde(default = "bumper_rays")]
    pub(super) rays: u64,
    #[serde(default = "travel_m")]
    pub(super) travel_m: f64,
    #[serde(default)]
    pub(super) active_low: bool,
    #[serde(default)]
    pub(super) bounce_ms: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Photoresistor {
    #[serde(default = "half_turn")]
    pub(super) opening_rad: f64,
    #[serde(default)]
    pub(super) lag_s: f64,
    pub(super) resistance_10lux_ohm: f64,
    pub(super) gamma: f64,
    pub(super) capacitance_uf: f64,
    #[serde(default = "unit_us")]
    pub(super) unit_us: f64,
    #[serde(default = "max_counts")]
    pub(super) max_counts: u64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Light {
    #[serde(default = "half_turn")]
    pub(super) opening_rad: f64,
    pub(super) range_lux: f64,
    #[serde(default)]
    pub(super) lag_s: f64,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Field {
    pub(super) field: String,
    pub(super) max: Option<f64>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Microphone {
    pub(super) max: Option<f64>,
}

fn one() -> f64 {
    1.0
}

/// The notes' figure (§1.2.2).
fn sound_m_s() -> f64 {
    340.0
}

fn one_row() -> u64 {
    1
}

fn yes() -> bool {
    true
}

fn position_range_m() -> f64 {
    10.0
}

fn wander_time_s() -> f64 {
    200.0
}

fn bumper_rays() -> u64 {
    9
}

fn travel_m() -> f64 {
    0.005
}

fn half_turn() -> f64 {
    core::f64::consts::PI
}

fn unit_us() -> f64 {
    2.0
}

fn max_counts() -> u64 {
    65_535
}
