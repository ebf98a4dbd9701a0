//! The fields of an exercise file.

use serde::Deserialize;
use toml::{Table, Value};

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Exercise {
    pub(crate) title: String,
    #[serde(default)]
    pub(crate) section: String,
    pub(crate) task: String,
    pub(crate) scenario: String,
    #[serde(default)]
    pub(crate) set: Vec<String>,
    pub(crate) robot: Option<String>,
    #[serde(default)]
    pub(crate) brains: Vec<String>,
    pub(crate) seconds: Option<f64>,
    pub(crate) seeds: Option<Value>,
    pub(crate) pass: Option<f64>,
    pub(crate) target: Option<Target>,
    #[serde(default)]
    pub(crate) deficits: Vec<Deficit>,
    #[serde(default)]
    pub(crate) limits: Limits,
    #[serde(default)]
    pub(crate) criteria: Vec<Criterion>,
    #[serde(default)]
    pub(crate) advice: Vec<Advice>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Target {
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    pub(crate) heading_rad: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Deficit {
    pub(crate) zone: String,
    pub(crate) deficit: f64,
    pub(crate) importance: f64,
    pub(crate) rate_per_s: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Limits {
    pub(crate) answer_s: Option<f64>,
    pub(crate) run_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Criterion {
    pub(crate) name: String,
    pub(crate) points: Option<f64>,
    pub(crate) needs: Table,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Advice {
    pub(crate) when: Table,
    pub(crate) say: String,
}
