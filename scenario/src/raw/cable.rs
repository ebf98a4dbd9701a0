//! The fields of a robot's cable: what is on it, and what it is made of.

use alloc::vec::Vec;

use baudbot_wire::create::Version;

use super::robot::Microcontroller;

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Firmware {
    pub(crate) protocol: Option<Protocol>,
    pub(crate) mode: Option<Mode>,
    pub(crate) period_ms: Option<f64>,
    pub(crate) phase_ms: Option<f64>,
    pub(crate) ages: Option<bool>,
    pub(crate) gap_ms: Option<f64>,
}

impl Firmware {
    /// What is spoken: if nothing is said, what the model speaks, or a program of the user's own.
    pub(crate) fn protocol(&self, microcontroller: &Microcontroller) -> Protocol {
        let usual = if microcontroller.program.is_some() { Protocol::Own } else { Protocol::default() };
        self.protocol.unwrap_or(usual)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Protocol {
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
    pub(crate) fn create(self) -> Option<Version> {
        match self {
            Self::Create => Some(Version::One),
            Self::Create2 => Some(Version::Two),
            Self::Framed | Self::Bare | Self::Khepera | Self::Own => None,
        }
    }

    /// Whether a brain on board has its bytes, too.
    pub(crate) fn is_dialogue(self) -> bool {
        self == Self::Khepera || self.create().is_some()
    }
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Mode {
    Stream,
    Poll,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Link {
    pub(crate) kind: LinkKind,
    pub(crate) baud: Option<u64>,
    pub(crate) bits_per_character: Option<u64>,
    pub(crate) receive_depth: Option<u64>,
    pub(crate) transmit_depth: Option<u64>,
    pub(crate) laptop_buffer_bytes: Option<u64>,
    pub(crate) byte_error_rate: Option<f64>,
    pub(crate) half_duplex: Option<bool>,
    pub(crate) turnaround_us: Option<f64>,
    pub(crate) adapter: Option<Adapter>,
    pub(crate) frame_ms: Option<f64>,
    pub(crate) bytes_per_frame: Option<u64>,
    pub(crate) outages: Option<Vec<Outage>>,
    pub(crate) serial_port: Option<toml::Value>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum LinkKind {
    #[default]
    Ideal,
    Onboard,
    Uart,
    Usb,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Adapter {
    pub(crate) kind: AdapterKind,
    pub(crate) latency_ms: Option<f64>,
    pub(crate) packet_bytes: Option<u64>,
    pub(crate) frame_ms: Option<f64>,
    pub(crate) extra_frames: Option<u64>,
    pub(crate) jitter_us: Option<f64>,
    pub(crate) down_us: Option<f64>,
    pub(crate) spread_ms: Option<f64>,
    pub(crate) burst_probability: Option<f64>,
    pub(crate) burst_ms: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum AdapterKind {
    Ftdi,
    Cdc,
    Bluetooth,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Outage {
    pub(crate) from_s: f64,
    pub(crate) for_s: f64,
}
