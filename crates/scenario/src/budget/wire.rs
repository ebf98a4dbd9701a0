//! The delays of a message on its way, at least and at most: the wire, the adapter, a frame of USB.

use super::plan::{Range, adapter};
use baudbot_sim::link::{Adapter, Bluetooth, Ftdi, Link};
use baudbot_sim::sensor::Sensor;
use baudbot_sim::sensor::port::Format;
use baudbot_sim::time::SimTime;

/// The time of so many characters on the wire, cut off: no message of them takes less.
pub(super) fn least_ns(link: &Link, bytes: u64) -> u64 {
    match link {
        Link::Uart(_) => link.burst_ns(bytes).saturating_sub(1),
        Link::Ideal | Link::Onboard | Link::Usb(_) => link.burst_ns(bytes),
    }
}

/// The longest wait for the next frame of a USB cable, in nanoseconds.
pub(super) fn frame_ns(link: &Link) -> u64 {
    match link {
        Link::Ideal | Link::Onboard | Link::Uart(_) => 0,
        Link::Usb(usb) => usb.frame_ns,
    }
}

/// The instant at which a burst begins that is ready at an instant.
pub(super) fn start_of_frame(link: &Link, ready: SimTime) -> SimTime {
    ready.up_to(frame_ns(link))
}

/// The least and the most that a radio takes for a packet, in nanoseconds.
pub(super) fn packet_ns(radio: &Bluetooth) -> Range {
    let held_ns = if radio.burst_probability > 0.0 { radio.burst_ns } else { 0 };
    Range { least: radio.latency_ns - radio.spread_ns, most: radio.latency_ns + radio.spread_ns + held_ns }
}

/// The time for which an adapter holds back a byte that comes from the cable. That a radio does so no longer than two
/// packets is asked elsewhere.
pub(super) fn hold_up_ns(link: &Link) -> Range {
    match adapter(link) {
        Adapter::None => Range::default(),
        Adapter::Cdc(frames) => Range { least: frames.least_up_ns(), most: frames.most_up_ns() },
        Adapter::Ftdi(Ftdi { latency_ns, frames, .. }) => {
            Range { least: frames.least_up_ns(), most: latency_ns + frames.most_up_ns() }
        }
        Adapter::Bluetooth(radio) => {
            let packet = packet_ns(&radio);
            Range { least: packet.least, most: 2 * packet.most }
        }
    }
}

/// The same for a byte that a brain writes.
pub(super) fn hold_down_ns(link: &Link) -> Range {
    match adapter(link) {
        Adapter::Cdc(frames) | Adapter::Ftdi(Ftdi { frames, .. }) => {
            Range { least: frames.down_ns.unwrap_or(0), most: frames.most_down_ns() }
        }
        Adapter::None | Adapter::Bluetooth(_) => hold_up_ns(link),
    }
}

/// The radio in the cable's place, if there is one.
pub(super) fn radio(link: &Link) -> Option<Bluetooth> {
    match adapter(link) {
        Adapter::Bluetooth(radio) => Some(radio),
        Adapter::None | Adapter::Cdc(_) | Adapter::Ftdi(_) => None,
    }
}

/// Bytes of a message on a sensor's own cable. Sentences of a receiver are longer and shorter, by where it is.
pub(super) fn port_bytes(sensor: &Sensor) -> Range {
    let Some(port) = &sensor.port else { return Range::default() };
    let usual = port.format.message_len(&sensor.device) as u64;
    match port.format {
        Format::Scip(_) | Format::LineImage => Range { least: usual, most: usual },
        // A GGA, a GSA, three GSV and an RMC.
        Format::Nmea { full } => Range { least: usual / 2, most: if full { 6 * NMEA_MAX } else { NMEA_MAX } },
    }
}

/// Bytes of the longest sentence.
const NMEA_MAX: u64 = baudbot_wire::nmea::MAX_SENTENCE as u64;
