//! The way from the raw link to the robot's cable, and what stands between it and the laptop.

use alloc::format;
use alloc::vec::Vec;

use super::raw;
use baudbot_fields::number::{Between, Millis, Number, Rule, Seconds, Whole};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::link::{Adapter, Bluetooth, Frames, Ftdi, Link, Outage, PACKETS_PER_FRAME, Uart, Usb};
use baudbot_sim::time::SimTime;

type Result<T> = core::result::Result<T, FieldError>;

/// Most outages of a link.
const MAX_OUTAGES: usize = 1000;

/// A USB frame by default, in nanoseconds.
const USUAL_FRAME_NS: u64 = 1_000_000;

pub(super) fn link(path: &Path, raw: &raw::Link) -> Result<Link> {
    match raw.kind {
        raw::LinkKind::Ideal => {
            let problem = "an ideal link has none; did you mean kind = \"uart\"?";
            path.refuse_all(&uart_fields(raw), problem)?;
            path.refuse_all(&both_fields(raw), problem)?;
            let problem = "an ideal link has none; did you mean kind = \"usb\"?";
            path.refuse_all(&usb_fields(raw), problem)?;
            Ok(Link::Ideal)
        }
        raw::LinkKind::Onboard => {
            let problem = "there is no link: the brain is the microcontroller's program";
            path.refuse_all(&uart_fields(raw), problem)?;
            path.refuse_all(&both_fields(raw), problem)?;
            path.refuse_all(&usb_fields(raw), problem)?;
            path.refuse("serial_port", raw.serial_port.is_some(), problem)?;
            Ok(Link::Onboard)
        }
        raw::LinkKind::Uart => {
            let problem = "a uart has no frames; did you mean kind = \"usb\", or a field of the adapter?";
            path.refuse_all(&usb_fields(raw), problem)?;
            uart(path, raw).map(Link::Uart)
        }
        raw::LinkKind::Usb => {
            path.refuse_all(&uart_fields(raw), "a usb link has none; did you mean kind = \"uart\"?")?;
            usb(path, raw).map(Link::Usb)
        }
    }
}

type Fields<const N: usize> = [(&'static str, bool); N];

fn uart_fields(raw: &raw::Link) -> Fields<8> {
    given!(raw; baud, bits_per_character, receive_depth, transmit_depth, byte_error_rate, half_duplex, turnaround_us, adapter)
}

fn both_fields(raw: &raw::Link) -> Fields<2> {
    given!(raw; laptop_buffer_bytes, outages)
}

fn usb_fields(raw: &raw::Link) -> Fields<2> {
    given!(raw; frame_ms, bytes_per_frame)
}

fn uart(path: &Path, raw: &raw::Link) -> Result<Uart> {
    let baud =
        raw.baud.ok_or_else(|| path.field("baud").error("a uart needs its baud rate, such as 9600"))?;
    let bits = raw.bits_per_character.unwrap_or(10);
    if ![8, 10, 11].contains(&bits) {
        let problem = format!("must be 8 (as the notes count), 10 (8N1) or 11, is {bits}");
        return Err(path.field("bits_per_character").error(problem));
    }
    let uart = Uart {
        baud: baud.get() as u32,
        bits_per_character: bits as u8,
        receive_depth: depth_of(raw.receive_depth, 64),
        transmit_depth: depth_of(raw.transmit_depth, 64),
        laptop_buffer_bytes: depth_of(raw.laptop_buffer_bytes, 4096),
        byte_error_rate: raw.byte_error_rate.map_or(0.0, Number::get),
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

fn depth_of(depth: Option<Number<raw::Depth>>, default: u32) -> usize {
    depth.map_or(default, Number::get) as usize
}

fn usb(path: &Path, raw: &raw::Link) -> Result<Usb> {
    Ok(Usb {
        frame_ns: raw.frame_ms.map_or(USUAL_FRAME_NS, Number::get),
        bytes_per_frame: raw.bytes_per_frame.map_or(PACKETS_PER_FRAME as u32 * 64, Number::get),
        laptop_buffer_bytes: depth_of(raw.laptop_buffer_bytes, 4096),
        outages: outages(&path.field("outages"), raw.outages.as_deref().unwrap_or_default())?,
        cuts: Vec::new(),
    })
}

fn turnaround_ns(path: &Path, raw: &raw::Link) -> Result<Option<u64>> {
    if raw.half_duplex == Some(true) {
        return Ok(Some(raw.turnaround_us.map_or(0, Number::get)));
    }
    path.refuse("turnaround_us", raw.turnaround_us.is_some(), "only with half_duplex = true")?;
    Ok(None)
}

fn adapter(path: &Path, raw: &raw::Adapter) -> Result<Adapter> {
    let radio_fields = given!(raw; spread_ms, burst_probability, burst_ms);
    match raw.kind {
        raw::AdapterKind::Cdc => {
            let problem = "a cdc adapter has no latency timer; did you mean kind = \"ftdi\"?";
            path.refuse_all(&given!(raw; latency_ms, packet_bytes), problem)?;
            path.refuse_all(&radio_fields, "only a radio has that; did you mean kind = \"bluetooth\"?")?;
            Ok(Adapter::Cdc(frames(raw)))
        }
        raw::AdapterKind::Ftdi => {
            path.refuse_all(&radio_fields, "only a radio has that; did you mean kind = \"bluetooth\"?")?;
            let packet_bytes = raw.packet_bytes.unwrap_or(62);
            Ok(Adapter::Ftdi(Ftdi {
                latency_ns: path.ms("latency_ms", raw.latency_ms.unwrap_or(16.0), 1.0, 255.0)?,
                packet_bytes: path.number::<Whole<1, 510, u32>>("packet_bytes", packet_bytes)?,
                frames: frames(raw),
            }))
        }
        raw::AdapterKind::Bluetooth => {
            let problem = "a radio has no USB frames; its delays are latency_ms and spread_ms";
            path.refuse_all(&frames_fields(raw), problem)?;
            bluetooth(path, raw).map(Adapter::Bluetooth)
        }
    }
}

fn frames_fields(raw: &raw::Adapter) -> Fields<4> {
    given!(raw; frame_ms, extra_frames, jitter_us, down_us)
}

fn frames(raw: &raw::Adapter) -> Frames {
    Frames {
        frame_ns: raw.frame_ms.map_or(USUAL_FRAME_NS, Number::get),
        extra: raw.extra_frames.map_or(0, Number::get),
        jitter_ns: raw.jitter_us.map_or(0, Number::get),
        down_ns: raw.down_us.map(Number::get),
    }
}

fn bluetooth(path: &Path, raw: &raw::Adapter) -> Result<Bluetooth> {
    let latency_ms = path.number::<Between<0, 10_000>>("latency_ms", raw.latency_ms.unwrap_or(30.0))?;
    let spread_ms = raw.spread_ms.map_or_else(|| latency_ms.min(10.0), Number::get);
    Ok(Bluetooth {
        latency_ns: Millis::<Between<0, 10_000>>::value(latency_ms),
        // The packet cannot be there before it is sent.
        spread_ns: path.ms("spread_ms", spread_ms, 0.0, latency_ms)?,
        burst_probability: raw.burst_probability.map_or(0.02, Number::get),
        burst_ns: raw.burst_ms.map_or(100_000_000, Number::get),
        packet_bytes: path.number::<Whole<1, 4096, u32>>("packet_bytes", raw.packet_bytes.unwrap_or(330))?,
    })
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
        let from_s = raw.from_s.get();
        let from = SimTime::from_ns(Seconds::<Between<0, 100_000_000>>::value(from_s));
        let until = from + raw.for_s.get();
        if outages.last().is_some_and(|before| from < before.until) {
            let problem = format!("must not be before the end of the previous outage, is {from_s}");
            return Err(path.field("from_s").error(problem));
        }
        outages.push(Outage { from, until });
    }
    Ok(outages)
}
