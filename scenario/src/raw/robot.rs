//! The fields of a robot, but for those of its cable.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use super::cable::{Firmware, Link};
use crate::actuators::RawBattery;
use crate::faults::{RawFault, RawOnLate};
use crate::on_pin::{Pins, RawProgram};

/// What motors may contain depends on their kind, so they are kept as a table until it is known.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Robot {
    pub(crate) name: String,
    pub(crate) start: Option<Start>,
    pub(crate) starts: Option<Vec<Start>>,
    pub(crate) body: Body,
    #[serde(default)]
    pub(crate) motors: toml::Table,
    #[serde(default)]
    pub(crate) actuators: Tables,
    pub(crate) battery: Option<RawBattery>,
    #[serde(default)]
    pub(crate) sensors: Tables,
    #[serde(default)]
    pub(crate) microcontroller: Microcontroller,
    #[serde(default)]
    pub(crate) pins: Pins,
    #[serde(default)]
    pub(crate) firmware: Firmware,
    #[serde(default)]
    pub(crate) link: Link,
    #[serde(default)]
    pub(crate) brain: Brain,
    #[serde(default)]
    pub(crate) faults: Vec<RawFault>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Start {
    #[serde(default)]
    pub(crate) x_m: f64,
    #[serde(default)]
    pub(crate) y_m: f64,
    #[serde(default)]
    pub(crate) heading_rad: f64,
    #[serde(default)]
    pub(crate) speed_m_s: f64,
    #[serde(default)]
    pub(crate) turn_rate_rad_s: f64,
    #[serde(default)]
    pub(crate) wheels_at_rest: bool,
    pub(crate) name: Option<String>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Body {
    pub(crate) radius_m: Option<f64>,
    pub(crate) outline_m: Option<Vec<[f64; 2]>>,
    pub(crate) height_m: Option<f64>,
    pub(crate) color: Option<[u8; 3]>,
    pub(crate) mass_kg: f64,
    pub(crate) inertia_kg_m2: f64,
    pub(crate) wheel_radius_m: f64,
    pub(crate) half_track_m: Option<f64>,
    pub(crate) wheel_ratio: Option<f64>,
    pub(crate) wheel_scale: Option<f64>,
    pub(crate) track_ratio: Option<f64>,
    #[serde(default)]
    pub(crate) wheel_mass_kg: f64,
    #[serde(default)]
    pub(crate) wheel_inertia_kg_m2: f64,
    #[serde(default)]
    pub(crate) damping_n_s_m: f64,
    #[serde(default)]
    pub(crate) turn_damping_nm_s: f64,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Microcontroller {
    pub(crate) framing_us_per_byte: f64,
    pub(crate) receiving_us_per_byte: f64,
    pub(crate) obeying_us: f64,
    pub(crate) operations_per_s: Option<f64>,
    pub(crate) ram_bytes: Option<u64>,
    pub(crate) bootloader_s: f64,
    pub(crate) chip: Option<String>,
    pub(crate) clock_hz: Option<f64>,
    pub(crate) clock_ppm: Option<f64>,
    pub(crate) fuses: Option<Vec<u64>>,
    pub(crate) program: Option<RawProgram>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Brain {
    pub(crate) thinking_us: Option<f64>,
    pub(crate) operations: Option<u64>,
    pub(crate) memory_bytes: Option<u64>,
    pub(crate) deadline_ms: Option<f64>,
    pub(crate) on_late: Option<RawOnLate>,
}

/// A robot's sensors or actuators by name. What one may contain depends on its kind, so each is kept as a table
/// until its kind is known.
#[derive(Debug, Default, serde::Deserialize)]
#[serde(from = "BTreeMap<String, toml::Table>")]
pub(crate) struct Tables(pub(crate) Vec<(String, toml::Table)>);

impl From<BTreeMap<String, toml::Table>> for Tables {
    fn from(tables: BTreeMap<String, toml::Table>) -> Self {
        Self(tables.into_iter().collect())
    }
}

impl Tables {
    /// Puts them into the order of `names`; those that an override added come last.
    pub(crate) fn arrange(&mut self, names: &[String]) {
        self.0.sort_by_key(|(name, _)| names.iter().position(|other| other == name).unwrap_or(names.len()));
    }
}
