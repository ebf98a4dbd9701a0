//! The fields of a scenario file, as they are written. `docs/reference/scenario.md` is its description; the two are
//! kept equal by a test.

mod cable;
mod robot;

use alloc::string::String;
use alloc::vec::Vec;

pub(super) use cable::{Adapter, AdapterKind, Firmware, Link, LinkKind, Mode, Outage, Protocol};
pub(super) use robot::{Body, Brain, Microcontroller, Robot, Start, Tables};

use super::arena::RawArena;

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Scenario {
    #[serde(default)]
    pub(super) name: String,
    #[serde(default)]
    pub(super) description: String,
    #[serde(default = "default::seed")]
    pub(super) seed: u64,
    #[serde(default = "default::step_ms")]
    pub(super) step_ms: f64,
    #[serde(default = "default::substeps")]
    pub(super) substeps: u32,
    #[serde(default = "default::yes")]
    pub(super) noise: bool,
    #[serde(default)]
    pub(super) collision: Collision,
    #[serde(default)]
    pub(super) end: End,
    #[serde(default)]
    pub(super) metrics: Metrics,
    #[serde(default)]
    pub(super) arena: RawArena,
    #[serde(default)]
    pub(super) robots: Vec<Robot>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Collision {
    #[default]
    StopRobot,
    StopRun,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct End {
    pub(super) after_s: Option<f64>,
    pub(super) goal: Option<Goal>,
    pub(super) collisions: Option<u64>,
    #[serde(default)]
    pub(super) all_goals: bool,
    pub(super) covered: Option<f64>,
    pub(super) sensed: Option<f64>,
    #[serde(default)]
    pub(super) battery_empty: bool,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Metrics {
    pub(super) cell_m: Option<f64>,
    pub(super) sensed_by: Option<String>,
    pub(super) sense_ms: Option<f64>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Goal {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) radius_m: f64,
}

mod default {
    pub(super) fn seed() -> u64 {
        1
    }

    pub(super) fn step_ms() -> f64 {
        10.0
    }

    pub(super) fn substeps() -> u32 {
        1
    }

    pub(super) fn yes() -> bool {
        true
    }
}
