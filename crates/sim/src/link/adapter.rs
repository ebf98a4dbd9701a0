//! The adapter between a UART and the laptop's USB port.
//!
//! **Frames** (`Cdc`, and part of `Ftdi`). The laptop's host moves bytes at the boundaries of USB's frames, the
//! multiples of 1 ms: see `frames`.
//!
//! **Packets and the latency timer** (`Ftdi`, upwards). The chip collects what arrives. It sends a packet
//!
//! - when `packet_bytes` are in it (an FTDI packet has 64 bytes, of which 2 are status), or
//! - when the latency timer expires with anything in it: what is in it then.
//!
//! Each packet restarts the timer; an expiry with an empty chip restarts it, too, so that it expires each
//! `latency_ns` after the last packet. (FTDI, AN232B-04 "Data Throughput, Latency and Handshaking": 16 ms by
//! default, 1 to 255 ms.) So a brain that answers each message at once meets a timer that its last message
//! restarted, and has at most 1 / `latency_ns` exchanges a second over any cable, 62.5 at 16 ms, unless its messages
//! fill packets.
//!
//! *Deviations.* The chip's memory and the bus are never full: scenario files refuse cables that are faster than
//! 19 packets a frame. Event characters and modem lines, which also make a chip send, are not modelled. The
//! first period of the timer begins with the run. All robots' frames are in step.

use super::{Bluetooth, Frames};
use crate::time::SimTime;

/// The adapter that a UART's bytes pass at the laptop's end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Adapter {
    /// The link has no adapter: a serial port of its own.
    None,
    /// A USB serial port without a latency timer, as CP210x, CH340 or a CDC-ACM device.
    Cdc(Frames),
    /// A USB serial port with packets and a latency timer.
    Ftdi(Ftdi),
    /// A radio in the cable's place.
    Bluetooth(Bluetooth),
}

/// An FTDI chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ftdi {
    /// Period of the latency timer, in nanoseconds.
    pub latency_ns: u64,
    /// Bytes that make it send a packet at once.
    pub packet_bytes: u32,
    /// The relation of its packets to the bus.
    pub frames: Frames,
}

/// A packet on its way to the laptop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Packet {
    /// The instant at which the packet was closed, with the bytes that were in the chip then.
    pub(super) closed: SimTime,
    /// The instant at which the laptop has the packet.
    pub(super) at: SimTime,
}

impl Adapter {
    /// Most bytes of a packet to the laptop.
    pub(super) fn packet_bytes(&self) -> u32 {
        match self {
            // Bytes of the same frame have the same jitter.
            Self::Cdc(frames) if frames.jitter_ns > 0 => u32::MAX,
            Self::None | Self::Cdc(_) => 1,
            Self::Ftdi(ftdi) => ftdi.packet_bytes,
            Self::Bluetooth(bluetooth) => bluetooth.packet_bytes,
        }
    }

    /// The instant at which that is at the chip which a brain writes at an instant, but by radio.
    pub(super) fn at_chip(&self, written: SimTime) -> SimTime {
        match self {
            Self::None | Self::Bluetooth(_) => written,
            Self::Cdc(frames) | Self::Ftdi(Ftdi { frames, .. }) => frames.at_chip(written),
        }
    }

    /// The longest time, in nanoseconds, that a byte waits which has come to the chip just behind a packet, either way.
    pub(crate) fn hold_ns(&self) -> u64 {
        match self {
            Self::None => 0,
            Self::Cdc(frames) => frames.most_up_ns().max(frames.most_down_ns()),
            Self::Ftdi(ftdi) => (ftdi.latency_ns + ftdi.frames.most_up_ns()).max(ftdi.frames.most_down_ns()),
            Self::Bluetooth(radio) => radio.latency_ns + radio.spread_ns + radio.burst_ns,
        }
    }

    /// The next packet to the laptop, if bytes come to the chip at these instants. `since` is when the last
    /// one was sent, and `drawn_ns` what chance adds to this one.
    pub(super) fn packet(
        &self,
        since: SimTime,
        drawn_ns: u64,
        mut chip: impl Iterator<Item = SimTime>,
    ) -> Option<Packet> {
        let first = chip.next()?;
        let (closed, at) = match self {
            Self::None => (first, first),
            Self::Cdc(frames) => {
                let closed = if frames.jitter_ns > 0 { first.up_to(frames.frame_ns) } else { first };
                (closed, frames.at_laptop(closed, drawn_ns))
            }
            Self::Ftdi(ftdi) => {
                let expiry = ftdi.expiry(since, first);
                let full = match ftdi.packet_bytes {
                    0 | 1 => Some(first),
                    n => chip.nth(n as usize - 2),
                };
                let closed = full.map_or(expiry, |full| full.min(expiry));
                (closed, ftdi.frames.at_laptop(closed, drawn_ns))
            }
            Self::Bluetooth(_) => {
                let start = first.max(since);
                (start, start + drawn_ns)
            }
        };
        Some(Packet { closed, at })
    }
}

impl Ftdi {
    /// The first expiry of the timer that was started at `since`, from `first` on.
    fn expiry(&self, since: SimTime, first: SimTime) -> SimTime {
        let periods = first.since(since).div_ceil(self.latency_ns).max(1);
        since + periods.saturating_mul(self.latency_ns)
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;
    use crate::link::properties::{delivered, down, line, uart, with_adapter};

    const MS: u64 = 1_000_000;

    fn ftdi(latency_ms: u64, packet_bytes: u32) -> Adapter {
        Adapter::Ftdi(Ftdi { latency_ns: latency_ms * MS, packet_bytes, frames: Frames::of(MS) })
    }

    #[test]
    fn the_timer_sends_what_is_there_and_its_packets_restart_it() {
        // A character takes 0.1 ms.
        let link = with_adapter(uart(100_000, 10), ftdi(16, 62));
        let mut line = line(&link);
        line.send(&link, SimTime::ZERO, &[1, 2, 3]);
        assert_eq!(line.arrival(&link), SimTime::from_ns(16 * MS));
        // One byte is in the chip at 16.0 ms exactly, the other only at 16.1 ms.
        line.send(&link, SimTime::from_ns(15_900_000), &[4, 5]);
        assert_eq!(delivered(&mut line, &link, 17 * MS), [(16 * MS, vec![1, 2, 3, 4])]);
        assert_eq!(line.arrival(&link), SimTime::from_ns(32 * MS));
        assert_eq!(delivered(&mut line, &link, 100 * MS), [(32 * MS, vec![5])]);
        // Nothing at 48, 64, 80, 96 ms.
        line.send(&link, SimTime::from_ns(97 * MS), &[6]);
        assert_eq!(delivered(&mut line, &link, 200 * MS), [(112 * MS, vec![6])]);
    }

    #[test]
    fn a_full_packet_goes_at_the_next_frame_and_restarts_the_timer() {
        let link = with_adapter(uart(100_000, 10), ftdi(16, 4));
        let mut line = line(&link);
        line.send(&link, SimTime::from_ns(2_050_000), &[1, 2, 3]);
        assert_eq!(line.arrival(&link), SimTime::from_ns(16 * MS));
        line.send(&link, SimTime::from_ns(2_900_000), &[4, 5]);
        // Full at 3.0 ms, which is a boundary; the rest 16 ms later.
        let expected = [(3 * MS, vec![1, 2, 3, 4]), (19 * MS, vec![5])];
        assert_eq!(delivered(&mut line, &link, 100 * MS), expected);
        line.send(&link, SimTime::from_ns(100_700_000), &[6; 8]);
        // Full at 101.1 and at 101.5 ms: both with the frame at 102 ms.
        assert_eq!(delivered(&mut line, &link, 200 * MS), [(102 * MS, vec![6; 8])]);
    }

    #[test]
    fn without_a_timer_a_byte_waits_for_the_next_frame_only() {
        let link = with_adapter(uart(100_000, 10), Adapter::Cdc(Frames::of(MS)));
        let mut line = line(&link);
        line.send(&link, SimTime::from_ns(1_800_000), &[1, 2, 3]);
        let expected = [(2 * MS, vec![1, 2]), (3 * MS, vec![3])];
        assert_eq!(delivered(&mut line, &link, 10 * MS), expected);
    }

    #[test]
    fn what_a_brain_writes_is_at_the_chip_with_the_next_frame() {
        for adapter in [Adapter::Cdc(Frames::of(MS)), ftdi(16, 62)] {
            let link = with_adapter(uart(100_000, 10), adapter);
            let mut line = down(&link);
            line.send(&link, SimTime::from_ns(1_200_000), &[1, 2]);
            line.send(&link, SimTime::from_ns(1_700_000), &[3]);
            line.send(&link, SimTime::from_ns(5 * MS), &[4]);
            assert_eq!(line.waiting(&link, SimTime::from_ns(2 * MS)), 4);
            let at: Vec<_> = delivered(&mut line, &link, 10 * MS).into_iter().map(|(at, _)| at).collect();
            assert_eq!(at, [2_100_000, 2_200_000, 2_300_000, 5_100_000]);
        }
    }
}
