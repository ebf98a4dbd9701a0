//! The fields of a robot's cable: what is on it, and what it is made of.

use alloc::vec::Vec;

use baudbot_fields::number::{Between, Micros, Millis, NotNegative, Number, Seconds, Share, Whole};
use baudbot_sim::link::{LEAST_BAUD, MOST_BAUD};

use super::robot::Microcontroller;
use crate::context::{MIN_PERIOD_MS, Period};

baudbot_fields::rules! {
    /// A USB frame, in milliseconds; 0.125 ms is a high-speed microframe.
    Frame: Any, 0.125, 100.0;
    /// Silence that ends a message, in milliseconds.
    Gap: Any, MIN_PERIOD_MS, 1e6;
}

/// How many bytes a buffer or a frame holds.
pub(crate) type Depth = Whole<1, { 1 << 20 }, u32>;

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Firmware {
    /// Protocol of the messages ([wire](wire.md)). `"own"` is a protocol that only your own programs understand.
    /// Default: `"framed"`; `"own"` with a `microcontroller.program`.
    pub(crate) protocol: Option<Protocol>,
    /// Readings are sent on a schedule, or in answer to each command (`framed`: also to each poll; `khepera`, `asercom`:
    /// only to each poll). Default: `"stream"`, the only mode of `create` and `create-2`; `"poll"` for `khepera` and
    /// `asercom`, their only mode.
    pub(crate) mode: Option<Mode>,
    /// Time between two messages of readings. Default: `step_ms`; 15.0 for `create` and `create-2`. Range: only `stream`.
    pub(crate) period_ms: Option<Number<Millis<Period>>>,
    /// Instant at which the first message is due. Default: 0.0. Range: only `stream`.
    pub(crate) phase_ms: Option<Number<Millis<Between<0, 10_000_000>>>>,
    /// Each reading carries its age, which takes one byte per reading. Default: true. Range: only `framed`.
    pub(crate) ages: Option<bool>,
    /// Silence after which a partial message is discarded. Default: 20.0, or 4 characters if longer, plus the
    /// longest delay of a byte in an adapter. Range: longer than a character plus that delay; only `bare`.
    pub(crate) gap_ms: Option<Number<Gap>>,
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) enum Protocol {
    #[default]
    Framed,
    Bare,
    Khepera,
    Create,
    #[serde(rename = "create-2")]
    Create2,
    Asercom,
    /// That of a program of the user's own.
    Own,
}

impl Protocol {
    /// Its name in a scenario.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Framed => "framed",
            Self::Bare => "bare",
            Self::Khepera => "khepera",
            Self::Create => "create",
            Self::Create2 => "create-2",
            Self::Asercom => "asercom",
            Self::Own => "own",
        }
    }

    /// Whether a brain on board has its bytes, too.
    pub(crate) fn is_dialogue(self) -> bool {
        match self {
            Self::Khepera | Self::Create | Self::Create2 | Self::Asercom => true,
            Self::Framed | Self::Bare | Self::Own => false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) enum Mode {
    Stream,
    Poll,
}

#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Link {
    /// Kind of link: without delay and loss; a serial cable; a USB cable to a microcontroller with its own USB; or no
    /// cable, as the brain [is on board](#the-brain-on-board). `ideal` has no other field than `serial_port`,
    /// `onboard` has none.
    pub(crate) kind: LinkKind,
    /// Baud rate, in bits per second. Default: required for `uart`. Range: only `uart`.
    pub(crate) baud: Option<Number<Whole<LEAST_BAUD, MOST_BAUD>>>,
    /// Bits per character: 8 as in the lecture notes, 10 for 8N1, 11 with parity or a second stop bit. Default: 10.
    /// Range: 8, 10 or 11; only `uart`.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = [8, 10, 11])))]
    pub(crate) bits_per_character: Option<u64>,
    /// Size of the microcontroller's receive buffer, in characters; characters that do not fit are lost. Default: 64.
    /// Range: only `uart`.
    pub(crate) receive_depth: Option<Number<Depth>>,
    /// Size of the microcontroller's transmit buffer, in characters, including the one being sent; when it is full,
    /// the microcontroller waits. Default: 64. Range: only `uart`.
    pub(crate) transmit_depth: Option<Number<Depth>>,
    /// Size of the laptop driver's buffers, in bytes: of the one for sending (bytes that do not fit are refused) and
    /// of the one that the brain reads (bytes that do not fit are lost). Default: 4096. Range: at least the longest
    /// message.
    pub(crate) laptop_buffer_bytes: Option<Number<Depth>>,
    /// Probability that a byte arrives with one wrong bit, in either direction. Default: 0.0. Range: only
    /// `uart`.
    pub(crate) byte_error_rate: Option<Number<Share>>,
    /// Both directions share the wire ([timing](../explanation/timing.md#half-duplex)). Default: false. Range:
    /// only `uart`.
    pub(crate) half_duplex: Option<bool>,
    /// Pause from the end of one side's last character to the start of the other's first. Default: 0.0. Range:
    /// only with `half_duplex`.
    pub(crate) turnaround_us: Option<Number<Micros<Between<0, 1_000_000>>>>,
    /// The adapter between the serial cable and the laptop. Range: only `uart`.
    pub(crate) adapter: Option<Adapter>,
    /// Length of a USB frame. Default: 1.0. Range: only `usb`.
    pub(crate) frame_ms: Option<Number<Millis<Frame>>>,
    /// Bytes per frame in each direction; by default 19 packets of 64. Default: 1216. Range: only `usb`.
    pub(crate) bytes_per_frame: Option<Number<Depth>>,
    /// Times during which the cable is unplugged. Range: at most 1000 outages.
    #[cfg_attr(feature = "schema", schemars(length(max = 1000)))]
    pub(crate) outages: Option<Vec<Outage>>,
    /// [Serial ports](ports.md#ports-in-a-scenario) that `baudbot serve` opens at the laptop's end, for programs not
    /// written for baudbot. They are not part of the world: they change no run, and other commands ignore them. Type:
    /// text, or list of at most 8. Range: `"pty:NAME"`, `"tcp:ADDRESS"`, `"rfc2217:ADDRESS"` or `"unix:PATH"`; not
    /// `onboard`; not with several `starts`.
    #[cfg_attr(feature = "schema", schemars(with = "serde_json::Value"))]
    pub(crate) serial_port: Option<toml::Value>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema, serde::Serialize))]
pub(crate) enum LinkKind {
    #[default]
    Ideal,
    Onboard,
    Uart,
    Usb,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Adapter {
    /// Kind of adapter: a USB serial port with a latency timer, one without (CP210x, CH340, CDC-ACM), or a radio.
    pub(crate) kind: AdapterKind,
    /// Period of the latency timer; or mean latency of a radio's packet. Default: `ftdi` 16.0, `bluetooth`
    /// 30.0. Range: `ftdi` 1 to 255.
    // The kind decides which range holds, so `link` checks it.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Number<Between<0, 10_000>>>"))]
    pub(crate) latency_ms: Option<f64>,
    /// Number of bytes at which the chip sends a packet immediately; or the maximum size of a radio's packet.
    /// Default: `ftdi` 62, `bluetooth` 330. Range: `ftdi` at most 510.
    // As `latency_ms`.
    #[cfg_attr(feature = "schema", schemars(with = "Option<Number<Whole<1, 4096, u32>>>"))]
    pub(crate) packet_bytes: Option<u64>,
    /// Length of a USB frame. Default: 1.0. Range: only `ftdi` and `cdc`.
    pub(crate) frame_ms: Option<Number<Millis<Frame>>>,
    /// Additional whole frames that bytes to the laptop take because of the chip's program. Default: 0. Range: only
    /// `ftdi` and `cdc`.
    pub(crate) extra_frames: Option<Number<Whole<0, 100, u32>>>,
    /// Maximum random delay of bytes to the laptop after the frame's boundary: uniform, and the same for all bytes of
    /// a packet. Default: 0.0. Range: only `ftdi` and `cdc`.
    pub(crate) jitter_us: Option<Number<Micros<Between<0, 100_000>>>>,
    /// Time from a brain's write until the bytes reach the chip. Without it they wait for the next frame. Range: only
    /// `ftdi` and `cdc`.
    pub(crate) down_us: Option<Number<Micros<Between<0, 100_000>>>>,
    /// A packet's latency is uniform within `latency_ms` ± this. Default: 10.0, or `latency_ms` if shorter.
    /// Range: to `latency_ms`; only `bluetooth`.
    pub(crate) spread_ms: Option<Number<NotNegative>>,
    /// Probability that a packet is held up. Default: 0.02. Range: only `bluetooth`.
    pub(crate) burst_probability: Option<Number<Share>>,
    /// Additional delay of a packet that is held up. Default: 100.0. Range: only `bluetooth`.
    pub(crate) burst_ms: Option<Number<Millis<Between<0, 10_000>>>>,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) enum AdapterKind {
    Ftdi,
    Cdc,
    Bluetooth,
}

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Outage {
    /// Time at which the cable is unplugged. Range: not before the end of the previous outage.
    pub(crate) from_s: Number<Between<0, 100_000_000>>,
    /// Time until it is plugged in again.
    pub(crate) for_s: Number<Seconds<Between<0, 100_000_000>>>,
}
