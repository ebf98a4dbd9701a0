//! The link between microcontroller and laptop: two lines, one each way.
//!
//! The parts that a byte passes on its way, and the modules that compute them:
//!
//! | link | up, to the laptop | down, to the microcontroller |
//! |---|---|---|
//! | ideal | nothing: no time, no loss | the same |
//! | UART | the wire (`transmission`) | the same |
//! | UART with an adapter | the wire, then the adapter (`adapter`, `frames`, `radio`) | the adapter, then the wire |
//! | half duplex | a wire that both lines share (`duplex`) | the same |
//! | USB | frames (`transmission`) | the same |
//! | onboard | nothing: the brain is the microcontroller's program | the same |
//!
//! A UART sends characters of so many bits, back to back. The notes count 8 bits a character (§3.2.1); a start
//! and a stop bit make it 10 (8N1), parity or a second stop bit 11. The ideal link, for goldens and for telling
//! the effect of the cable from that of the rest, carries any number of bytes in no time and loses none.

mod adapter;
mod counters;
mod duplex;
mod frames;
mod latencies;
mod line;
mod lookahead;
mod messages;
mod outage;
mod radio;
mod tape;
mod transmission;
mod transport_path;

#[cfg(test)]
mod echoes;
#[cfg(test)]
mod properties;

use alloc::vec::Vec;

pub use adapter::{Adapter, Ftdi};
pub use counters::LineCounters;
pub use frames::Frames;
pub(crate) use line::Command;
pub use line::Line;
pub(crate) use messages::Message;
pub use outage::Outage;
pub use radio::Bluetooth;
pub use tape::{Cable, Tape, Taped};
pub(crate) use transport_path::Direction;

use crate::fault::When;
use crate::time::{SECOND_NS, SimTime};

/// The model of a link.
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    /// No time, no loss.
    Ideal,
    /// A serial cable.
    Uart(Uart),
    /// A USB cable to a microcontroller that speaks USB itself.
    Usb(Usb),
    /// None: the brain is the microcontroller's program (Fig. 1.19), and its thinking takes that processor's time.
    Onboard,
}

/// A serial cable and the buffers at its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Uart {
    /// Bits a second.
    pub baud: u32,
    /// Bits a character, start and stop bits included: 8, 10 or 11.
    pub bits_per_character: u8,
    /// Characters that the microcontroller can hold unread; more are lost.
    pub receive_depth: usize,
    /// Characters that the microcontroller can hold unsent, the one being sent included; when all are taken
    /// it waits.
    pub transmit_depth: usize,
    /// Bytes that the laptop's driver holds each way: more to be sent are refused, and more that a brain
    /// leaves unread are lost.
    pub laptop_buffer_bytes: usize,
    /// Probability that a byte arrives with one bit wrong.
    pub byte_error_rate: f64,
    /// The adapter between the cable and the laptop.
    pub adapter: Adapter,
    /// Both directions share the wire; the pause, in nanoseconds, from the end of one side's last byte to the
    /// start of the other's first. `None` is full duplex.
    pub turnaround_ns: Option<u64>,
    /// The times at which the cable is out, in their order and apart.
    pub outages: Vec<Outage>,
    /// Faults that take the cable out.
    pub cuts: Vec<When>,
    /// Faults that damage bytes, each with its probability for a byte; the largest counts.
    pub error_bursts: Vec<(When, f64)>,
}

/// A full-speed USB cable. It has neither byte errors, which USB finds and corrects itself, nor overruns at the
/// microcontroller, which makes the laptop wait.
#[derive(Clone, Debug, PartialEq)]
pub struct Usb {
    /// Length of a frame, in nanoseconds: 1 ms (USB 2.0, 5.3.3).
    pub frame_ns: u64,
    /// Bytes each way in a frame. At most 19 packets of 64 bytes fit into one (USB 2.0, table 5-9).
    pub bytes_per_frame: u32,
    /// See [`Uart::laptop_buffer_bytes`].
    pub laptop_buffer_bytes: usize,
    /// See [`Uart::outages`].
    pub outages: Vec<Outage>,
    /// See [`Uart::cuts`].
    pub cuts: Vec<When>,
}

impl Uart {
    /// The greatest rate that what stands between the cable and the laptop keeps up with: the memory of its chip has no
    /// end in the model, so the bus must not be what limits it.
    pub fn most_baud(&self) -> u64 {
        let (packet_bytes, frame_ns) = match self.adapter {
            Adapter::None | Adapter::Bluetooth(_) => return MOST_BAUD,
            Adapter::Cdc(frames) => (64, frames.frame_ns),
            Adapter::Ftdi(Ftdi { packet_bytes, frames, .. }) => (packet_bytes, frames.frame_ns),
        };
        let bits = PACKETS_PER_FRAME * u64::from(packet_bytes) * u64::from(self.bits_per_character);
        let most = u128::from(bits) * u128::from(SECOND_NS) / u128::from(frame_ns);
        u64::try_from(most).unwrap_or(u64::MAX).min(MOST_BAUD)
    }
}

impl Link {
    /// Nanoseconds from the start of a burst to the arrival of its `n`-th character (from 1): the sum of §3.2.1.
    pub fn burst_ns(&self, n: u64) -> u64 {
        match self {
            Self::Ideal | Self::Onboard => 0,
            Self::Uart(uart) => {
                let bit_ns = u64::from(uart.bits_per_character) * SECOND_NS;
                // Seldom are there so many characters that 64 bits are too few.
                if let Some(bits_ns) = n.checked_mul(bit_ns) {
                    return bits_ns.div_ceil(u64::from(uart.baud));
                }
                let ns = (u128::from(n) * u128::from(bit_ns)).div_ceil(u128::from(uart.baud));
                u64::try_from(ns).unwrap_or(u64::MAX)
            }
            Self::Usb(usb) => n.div_ceil(u64::from(usb.bytes_per_frame)).saturating_mul(usb.frame_ns),
        }
    }

    /// The longest silence between two bytes of a message on their way to the decoder, in nanoseconds: a
    /// character, and what an adapter can hold a byte back.
    pub fn pause_ns(&self) -> u64 {
        self.burst_ns(1) + self.adapter().hold_ns()
    }

    /// See [`Uart::receive_depth`]; the other links lose nothing.
    pub(crate) fn receive_depth(&self) -> usize {
        match self {
            Self::Ideal | Self::Onboard | Self::Usb(_) => usize::MAX,
            Self::Uart(uart) => uart.receive_depth,
        }
    }

    /// See [`Uart::transmit_depth`]. Of a USB microcontroller it is a guess: as much as a frame carries.
    pub fn transmit_depth(&self) -> usize {
        match self {
            Self::Ideal | Self::Onboard => usize::MAX,
            Self::Uart(uart) => uart.transmit_depth,
            Self::Usb(usb) => usb.bytes_per_frame as usize,
        }
    }

    /// See [`Uart::laptop_buffer_bytes`].
    pub fn laptop_buffer(&self) -> usize {
        match self {
            Self::Ideal | Self::Onboard => IDEAL_BUFFER,
            Self::Uart(uart) => uart.laptop_buffer_bytes,
            Self::Usb(usb) => usb.laptop_buffer_bytes,
        }
    }

    /// The error rate of a byte that is put on the wire at this instant.
    fn byte_error_rate(&self, at: SimTime) -> f64 {
        match self {
            Self::Ideal | Self::Onboard | Self::Usb(_) => 0.0,
            Self::Uart(uart) => {
                let transmissions = uart.error_bursts.iter().filter(|(when, _)| when.until(at).is_some());
                transmissions.fold(uart.byte_error_rate, |rate, (_, transmission)| rate.max(*transmission))
            }
        }
    }

    /// Length of the frames that bursts begin with, in nanoseconds; 0 where they begin at once.
    fn frame_ns(&self) -> u64 {
        match self {
            Self::Ideal | Self::Onboard | Self::Uart(_) => 0,
            Self::Usb(usb) => usb.frame_ns,
        }
    }

    fn adapter(&self) -> &Adapter {
        match self {
            Self::Ideal | Self::Onboard | Self::Usb(_) => &Adapter::None,
            Self::Uart(uart) => &uart.adapter,
        }
    }

    fn turnaround_ns(&self) -> Option<u64> {
        match self {
            Self::Ideal | Self::Onboard | Self::Usb(_) => None,
            Self::Uart(uart) => uart.turnaround_ns,
        }
    }

    fn outages(&self) -> &[Outage] {
        match self {
            Self::Ideal | Self::Onboard => &[],
            Self::Uart(uart) => &uart.outages,
            Self::Usb(usb) => &usb.outages,
        }
    }

    fn cuts(&self) -> &[When] {
        match self {
            Self::Ideal | Self::Onboard => &[],
            Self::Uart(uart) => &uart.cuts,
            Self::Usb(usb) => &usb.cuts,
        }
    }

    /// Whether the cable has been pulled by hand, and not plugged in again.
    pub fn is_pulled(&self) -> bool {
        self.cuts().iter().any(|when| matches!(when, When::Once { until: SimTime::NEVER, .. }))
    }

    /// Pulls the cable by hand at this instant, or plugs it in.
    pub(crate) fn pull(&mut self, now: SimTime, pulled: bool) {
        let (Self::Uart(Uart { cuts, .. }) | Self::Usb(Usb { cuts, .. })) = self else { return };
        if pulled {
            cuts.push(When::Once { from: now, until: SimTime::NEVER });
        }
        for when in cuts.iter_mut().filter(|_| !pulled) {
            if let When::Once { until: until @ SimTime::NEVER, .. } = when {
                *until = now;
            }
        }
    }

    /// The link's baud rate, if it has one.
    pub fn baud(&self) -> Option<u32> {
        match self {
            Self::Uart(uart) => Some(uart.baud),
            Self::Ideal | Self::Usb(_) | Self::Onboard => None,
        }
    }

    /// Whether the cable is out at that instant.
    fn is_out(&self, at: SimTime) -> bool {
        outage::covers(self.outages(), at) || self.cuts().iter().any(|when| when.until(at).is_some())
    }

    /// Whether the cable is ever out.
    fn has_outages(&self) -> bool {
        !self.outages().is_empty() || !self.cuts().is_empty()
    }

    /// Whether a byte passes more than the wire.
    fn has_detour(&self) -> bool {
        *self.adapter() != Adapter::None || self.turnaround_ns().is_some() || self.has_outages()
    }
}

/// Least baud rate of a cable.
pub const LEAST_BAUD: u64 = 50;

/// Greatest baud rate of a cable.
pub const MOST_BAUD: u64 = 100_000_000;

/// Packets that a USB bus carries in a frame (USB 2.0, table 5-9).
pub const PACKETS_PER_FRAME: u64 = 19;

/// Bytes that the driver of an ideal link holds: enough for any brain, and yet an end for one that never reads.
const IDEAL_BUFFER: usize = 1 << 20;
