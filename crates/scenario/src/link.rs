//! From the raw link to the robot's cable, and what stands between it and the laptop.

use alloc::format;
use alloc::vec::Vec;

use super::raw;
use baudbot_fields::{FieldError, Path};
use baudbot_sim::link::{
    Adapter, Bluetooth, Frames, Ftdi, LEAST_BAUD, Link, MOST_BAUD, Outage, PACKETS_PER_FRAME, Uart, Usb,
};
use baudbot_sim::time::{SECOND_NS, SimTime};

type Result<T> = core::result::Result<T, FieldError>;

/// Most outages of a link.
const MAX_OUTAGES: usize = 1000;

/// Shortest and longest USB frame, in milliseconds; 0.125 ms is a high-speed microframe.
const FRAME_MS: (f64, f64) = (0.125, 100.0);

/// Most frames that a chip may add, and the longest of an adapter's short delays, in microseconds.
const MOST_EXTRA_FRAMES: u64 = 100;
const MOST_US: f64 = 1e5;

pub(super) fn link(path: &Path, raw: &raw::Link) -> Result<Link> {
    match raw.kind {
        raw::LinkKind::Ideal => {
            let problem = "an ideal link has none; did you mean kind = \"uart\"?";
            refuse_all(path, &uart_fields(raw), problem)?;
            refuse_all(path, &both_fields(raw), problem)?;
            let problem = "an ideal link has none; did you mean kind = \"usb\"?";
            refuse_all(path, &usb_fields(raw), problem)?;
            Ok(Link::Ideal)
        }
        raw::LinkKind::Onboard => {
            let problem = "there is no link: the brain is the microcontroller's program";
            refuse_all(path, &uart_fields(raw), problem)?;
            refuse_all(path, &both_fields(raw), problem)?;
            refuse_all(path, &usb_fields(raw), problem)?;
            path.refuse("serial_port", raw.serial_port.is_some(), problem)?;
            Ok(Link::Onboard)
        }
        raw::LinkKind::Uart => {
            let problem = "a uart has no frames; did you mean kind = \"usb\", or a field of the adapter?";
            refuse_all(path, &usb_fields(raw), problem)?;
            uart(path, raw).map(Link::Uart)
        }
        raw::LinkKind::Usb => {
            refuse_all(path, &uart_fields(raw), "a usb link has none; did you mean kind = \"uart\"?")?;
            usb(path, raw).map(Link::Usb)
        }
    }
}

type Fields<const N: usize> = [(&'static str, bool); N];

fn uart_fields(raw: &raw::Link) -> Fields<8> {
    [
        ("baud", raw.baud.is_some()),
        ("bits_per_character", raw.bits_per_character.is_some()),
        ("receive_depth", raw.receive_depth.is_some()),
        ("transmit_depth", raw.transmit_depth.is_some()),
        ("byte_error_rate", raw.byte_error_rate.is_some()),
        ("half_duplex", raw.half_duplex.is_some()),
        ("turnaround_us", raw.turnaround_us.is_some()),
        ("adapter", raw.adapter.is_some()),
    ]
}

fn both_fields(raw: &raw::Link) -> Fields<2> {
    [("laptop_buffer_bytes", raw.laptop_buffer_bytes.is_some()), ("outages", raw.outages.is_some())]
}

fn usb_fields(raw: &raw::Link) -> Fields<2> {
    [("frame_ms", raw.frame_ms.is_some()), ("bytes_per_frame", raw.bytes_per_frame.is_some())]
}

fn refuse_all(path: &Path, fields: &[(&str, bool)], problem: &str) -> Result<()> {
    fields.iter().try_for_each(|(field, given)| path.refuse(field, *given, problem))
}

fn uart(path: &Path, raw: &raw::Link) -> Result<Uart> {
    let baud =
        raw.baud.ok_or_else(|| path.field("baud").error("a uart needs its baud rate, such as 9600"))?;
    let bits = raw.bits_per_character.unwrap_or(10);
    if ![8, 10, 11].contains(&bits) {
        let problem = format!("must be 8 (as the notes count), 10 (8N1) or 11, is {bits}");
        return Err(path.field("bits_per_character").error(problem));
    }
    let depth = |field, depth| depth_of(path, field, depth, 64);
    let uart = Uart {
        baud: path.whole_within("baud", baud, LEAST_BAUD, MOST_BAUD)? as u32,
        bits_per_character: bits as u8,
        receive_depth: depth("receive_depth", raw.receive_depth)?,
        transmit_depth: depth("transmit_depth", raw.transmit_depth)?,
        laptop_buffer_bytes: depth_of(path, "laptop_buffer_bytes", raw.laptop_buffer_bytes, 4096)?,
        byte_error_rate: path.within("byte_error_rate", raw.byte_error_rate.unwrap_or(0.0), 0.0, 1.0)?,
        adapter: match &raw.adapter {
            None => Adapter::None,
            Some(raw) => adapter(&path.field("adapter"), raw)?,
        },
        turnaround_ns: turnaround_ns(path, raw)?,
        outages: outages(&path.field("outages"), raw.outages.as_deref().unwrap_or_default())?,
        cuts: Vec::new(),
        error_bursts: Vec::new(),
    };
    keeps_up(path, &uart)?;
    Ok(uart)
}

fn depth_of(path: &Path, field: &str, depth: Option<u64>, default: u64) -> Result<usize> {
    path.whole_within(field, depth.unwrap_or(default), 1, 1 << 20).map(|depth| depth as usize)
}

fn usb(path: &Path, raw: &raw::Link) -> Result<Usb> {
    Ok(Usb {
        frame_ns: frame_ns(path, raw.frame_ms)?,
        bytes_per_frame: path.whole_within(
            "bytes_per_frame",
            raw.bytes_per_frame.unwrap_or(PACKETS_PER_FRAME * 64),
            1,
            1 << 20,
        )? as u32,
        laptop_buffer_bytes: depth_of(path, "laptop_buffer_bytes", raw.laptop_buffer_bytes, 4096)?,
        outages: outages(&path.field("outages"), raw.outages.as_deref().unwrap_or_default())?,
        cuts: Vec::new(),
    })
}

fn frame_ns(path: &Path, frame_ms: Option<f64>) -> Result<u64> {
    path.ms("frame_ms", frame_ms.unwrap_or(1.0), FRAME_MS.0, FRAME_MS.1)
}

fn turnaround_ns(path: &Path, raw: &raw::Link) -> Result<Option<u64>> {
    if raw.half_duplex == Some(true) {
        return path.us("turnaround_us", raw.turnaround_us.unwrap_or(0.0), 1e6).map(Some);
    }
    path.refuse("turnaround_us", raw.turnaround_us.is_some(), "only with half_duplex = true")?;
    Ok(None)
}

fn adapter(path: &Path, raw: &raw::Adapter) -> Result<Adapter> {
    let radio_fields = [
        ("spread_ms", raw.spread_ms.is_some()),
        ("burst_probability", raw.burst_probability.is_some()),
        ("burst_ms", raw.burst_ms.is_some()),
    ];
    match raw.kind {
        raw::AdapterKind::Cdc => {
            let problem = "a cdc adapter has no latency timer; did you mean kind = \"ftdi\"?";
            path.refuse("latency_ms", raw.latency_ms.is_some(), problem)?;
            path.refuse("packet_bytes", raw.packet_bytes.is_some(), problem)?;
            refuse_all(path, &radio_fields, "only a radio has that; did you mean kind = \"bluetooth\"?")?;
            frames(path, raw).map(Adapter::Cdc)
        }
        raw::AdapterKind::Ftdi => {
            refuse_all(path, &radio_fields, "only a radio has that; did you mean kind = \"bluetooth\"?")?;
            Ok(Adapter::Ftdi(Ftdi {
                latency_ns: path.ms("latency_ms", raw.latency_ms.unwrap_or(16.0), 1.0, 255.0)?,
                packet_bytes: packet_bytes(path, raw.packet_bytes, 62, 510)?,
                frames: frames(path, raw)?,
            }))
        }
        raw::AdapterKind::Bluetooth => {
            let problem = "a radio has no USB frames; its delays are latency_ms and spread_ms";
            refuse_all(path, &frames_fields(raw), problem)?;
            bluetooth(path, raw).map(Adapter::Bluetooth)
        }
    }
}

fn frames_fields(raw: &raw::Adapter) -> Fields<4> {
    [
        ("frame_ms", raw.frame_ms.is_some()),
        ("extra_frames", raw.extra_frames.is_some()),
        ("jitter_us", raw.jitter_us.is_some()),
        ("down_us", raw.down_us.is_some()),
    ]
}

fn frames(path: &Path, raw: &raw::Adapter) -> Result<Frames> {
    let us = |field, us| path.us(field, us, MOST_US);
    Ok(Frames {
        frame_ns: frame_ns(path, raw.frame_ms)?,
        extra: path.whole_within("extra_frames", raw.extra_frames.unwrap_or(0), 0, MOST_EXTRA_FRAMES)? as u32,
        jitter_ns: us("jitter_us", raw.jitter_us.unwrap_or(0.0))?,
        down_ns: raw.down_us.map(|down_us| us("down_us", down_us)).transpose()?,
    })
}

fn bluetooth(path: &Path, raw: &raw::Adapter) -> Result<Bluetooth> {
    let latency_ms = raw.latency_ms.unwrap_or(30.0);
    let latency_ns = path.ms("latency_ms", latency_ms, 0.0, 1e4)?;
    let spread_ms = raw.spread_ms.unwrap_or_else(|| latency_ms.min(10.0));
    Ok(Bluetooth {
        latency_ns,
        // It cannot be there before it is sent.
        spread_ns: path.ms("spread_ms", spread_ms, 0.0, latency_ms)?,
        burst_probability: path.within(
            "burst_probability",
            raw.burst_probability.unwrap_or(0.02),
            0.0,
            1.0,
        )?,
        burst_ns: path.ms("burst_ms", raw.burst_ms.unwrap_or(100.0), 0.0, 1e4)?,
        packet_bytes: packet_bytes(path, raw.packet_bytes, 330, 4096)?,
    })
}

fn packet_bytes(path: &Path, given: Option<u64>, default: u64, most: u64) -> Result<u32> {
    path.whole_within("packet_bytes", given.unwrap_or(default), 1, most).map(|bytes| bytes as u32)
}

/// Whether the bus can carry what the chip gets.
fn keeps_up(path: &Path, uart: &Uart) -> Result<()> {
    let (most, baud) = (uart.most_baud(), uart.baud);
    if u64::from(baud) <= most {
        return Ok(());
    }
    let packet_bytes = match uart.adapter {
        Adapter::Ftdi(Ftdi { packet_bytes, .. }) => packet_bytes,
        Adapter::None | Adapter::Cdc(_) | Adapter::Bluetooth(_) => 64,
    };
    let problem = format!(
        "{PACKETS_PER_FRAME} packets of {packet_bytes} bytes a frame keep up with {most} baud, not with {baud}"
    );
    Err(path.field("adapter").error(problem))
}

fn outages(path: &Path, raw: &[raw::Outage]) -> Result<Vec<Outage>> {
    if raw.len() > MAX_OUTAGES {
        return Err(path.error(format!("there are {}, the limit is {MAX_OUTAGES}", raw.len())));
    }
    let mut outages: Vec<Outage> = Vec::new();
    for (i, raw) in raw.iter().enumerate() {
        let path = path.index(i);
        let ns = |field, s| path.within(field, s, 0.0, 1e8).map(|s| (s * SECOND_NS as f64 + 0.5) as u64);
        let from = SimTime::from_ns(ns("from_s", raw.from_s)?);
        let until = from + ns("for_s", raw.for_s)?;
        if outages.last().is_some_and(|before| from < before.until) {
            let problem = format!("must not be before the end of the previous outage, is {}", raw.from_s);
            return Err(path.field("from_s").error(problem));
        }
        outages.push(Outage { from, until });
    }
    Ok(outages)
}
