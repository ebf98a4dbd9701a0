//! The fields of a scenario file, as they are written. `docs/reference/scenario.md` is its description; the two are
//! kept equal by a test.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_wire::create::Version;

use super::actuators::RawBattery;
use super::arena::RawArena;
use super::faults::{RawFault, RawOnLate};
use super::on_pin::{Pins, RawProgram};

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

/// What motors may contain depends on their kind, so they are kept as a table until it is known.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Robot {
    pub(super) name: String,
    pub(super) start: Option<Start>,
    pub(super) starts: Option<Vec<Start>>,
    pub(super) body: Body,
    #[serde(default)]
    pub(super) motors: toml::Table,
    #[serde(default)]
    pub(super) actuators: Tables,
    pub(super) battery: Option<RawBattery>,
    #[serde(default)]
    pub(super) sensors: Tables,
    #[serde(default)]
    pub(super) microcontroller: Microcontroller,
    #[serde(default)]
    pub(super) pins: Pins,
    #[serde(default)]
    pub(super) firmware: Firmware,
    #[serde(default)]
    pub(super) link: Link,
    #[serde(default)]
    pub(super) brain: Brain,
    #[serde(default)]
    pub(super) faults: Vec<RawFault>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Start {
    #[serde(default)]
    pub(super) x_m: f64,
    #[serde(default)]
    pub(super) y_m: f64,
    #[serde(default)]
    pub(super) heading_rad: f64,
    #[serde(default)]
    pub(super) speed_m_s: f64,
    #[serde(default)]
    pub(super) turn_rate_rad_s: f64,
    #[serde(default)]
    pub(super) wheels_at_rest: bool,
    pub(super) name: Option<String>,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Body {
    pub(super) radius_m: Option<f64>,
    pub(super) outline_m: Option<Vec<[f64; 2]>>,
    pub(super) height_m: Option<f64>,
    pub(super) color: Option<[u8; 3]>,
    pub(super) mass_kg: f64,
    pub(super) inertia_kg_m2: f64,
    pub(super) wheel_radius_m: f64,
    pub(super) half_track_m: Option<f64>,
    pub(super) wheel_ratio: Option<f64>,
    pub(super) wheel_scale: Option<f64>,
    pub(super) track_ratio: Option<f64>,
    #[serde(default)]
    pub(super) wheel_mass_kg: f64,
    #[serde(default)]
    pub(super) wheel_inertia_kg_m2: f64,
    #[serde(default)]
    pub(super) damping_n_s_m: f64,
    #[serde(default)]
    pub(super) turn_damping_nm_s: f64,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Microcontroller {
    pub(super) framing_us_per_byte: f64,
    pub(super) receiving_us_per_byte: f64,
    pub(super) obeying_us: f64,
    pub(super) operations_per_s: Option<f64>,
    pub(super) ram_bytes: Option<u64>,
    pub(super) bootloader_s: f64,
    pub(super) chip: Option<String>,
    pub(super) clock_hz: Option<f64>,
    pub(super) clock_ppm: Option<f64>,
    pub(super) fuses: Option<Vec<u64>>,
    pub(super) program: Option<RawProgram>,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Firmware {
    pub(super) protocol: Option<Protocol>,
    pub(super) mode: Option<Mode>,
    pub(super) period_ms: Option<f64>,
    pub(super) phase_ms: Option<f64>,
    pub(super) ages: Option<bool>,
    pub(super) gap_ms: Option<f64>,
}

impl Firmware {
    /// What is spoken: if nothing is said, what the model speaks, or a program of the user's own.
    pub(super) fn protocol(&self, microcontroller: &Microcontroller) -> Protocol {
        let usual = if microcontroller.program.is_some() { Protocol::Own } else { Protocol::default() };
        self.protocol.unwrap_or(usual)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Protocol {
    #[default]
    Framed,
    Bare,
    Khepera,
    Create,
    #[serde(rename = "create-2")]
    Create2,
    /// That of a program of the user's own.
    Own,
}

impl Protocol {
    /// Which Create speaks, if one does.
    pub(super) fn create(self) -> Option<Version> {
        match self {
            Self::Create => Some(Version::One),
            Self::Create2 => Some(Version::Two),
            Self::Framed | Self::Bare | Self::Khepera | Self::Own => None,
        }
    }

    /// Whether a brain on board has its bytes, too.
    pub(super) fn is_dialogue(self) -> bool {
        self == Self::Khepera || self.create().is_some()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Mode {
    Stream,
    Poll,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Link {
    pub(super) kind: LinkKind,
    pub(super) baud: Option<u64>,
    pub(super) bits_per_character: Option<u64>,
    pub(super) receive_depth: Option<u64>,
    pub(super) transmit_depth: Option<u64>,
    pub(super) laptop_buffer_bytes: Option<u64>,
    pub(super) byte_error_rate: Option<f64>,
    pub(super) half_duplex: Option<bool>,
    pub(super) turnaround_us: Option<f64>,
    pub(super) adapter: Option<Adapter>,
    pub(super) frame_ms: Option<f64>,
    pub(super) bytes_per_frame: Option<u64>,
    pub(super) outages: Option<Vec<Outage>>,
    pub(super) serial_port: Option<toml::Value>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LinkKind {
    #[default]
    Ideal,
    Onboard,
    Uart,
    Usb,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Adapter {
    pub(super) kind: AdapterKind,
    pub(super) latency_ms: Option<f64>,
    pub(super) packet_bytes: Option<u64>,
    pub(super) frame_ms: Option<f64>,
    pub(super) extra_frames: Option<u64>,
    pub(super) jitter_us: Option<f64>,
    pub(super) down_us: Option<f64>,
    pub(super) spread_ms: Option<f64>,
    pub(super) burst_probability: Option<f64>,
    pub(super) burst_ms: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum AdapterKind {
    Ftdi,
    Cdc,
    Bluetooth,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Outage {
    pub(super) from_s: f64,
    pub(super) for_s: f64,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Brain {
    pub(super) thinking_us: Option<f64>,
    pub(super) operations: Option<u64>,
    pub(super) memory_bytes: Option<u64>,
    pub(super) deadline_ms: Option<f64>,
    pub(super) on_late: Option<RawOnLate>,
}

/// A robot's sensors or actuators by name. What one may contain depends on its kind, so each is kept as a table
/// until its kind is known.
#[derive(Debug, Default, serde::Deserialize)]
#[serde(from = "BTreeMap<String, toml::Table>")]
pub(super) struct Tables(pub(super) Vec<(String, toml::Table)>);

impl From<BTreeMap<String, toml::Table>> for Tables {
    fn from(tables: BTreeMap<String, toml::Table>) -> Self {
        Self(tables.into_iter().collect())
    }
}

impl Tables {
    /// Puts them into the order of `names`; those that an override added come last.
    pub(super) fn arrange(&mut self, names: &[String]) {
        self.0.sort_by_key(|(name, _)| names.iter().position(|other| other == name).unwrap_or(names.len()));
    }
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
