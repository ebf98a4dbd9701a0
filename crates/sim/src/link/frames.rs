//! The relation of a USB adapter's bytes to the bus.
//!
//! **Upwards** a byte that comes to the chip at T is at the laptop at
//!
//! ```text
//! B(T) + extra · frame + J
//! ```
//!
//! where B(T) is the next boundary of a frame, a multiple of `frame_ns`, or T if that is one; `extra` is what the chip's
//! own program costs; and J is random, uniform from 0 to `jitter_ns`: what host and driver need after the boundary. J is
//! drawn once for all bytes that come with the same packet, and a packet never overtakes the one before.
//!
//! **Downwards** a byte that the brain writes at T is at the chip at the next boundary or, where `down_ns` is given,
//! that long after T: hosts send at once what is written.
//!
//! So a program that sends its next byte when the last one has come back is locked to the frames: its echoes take whole
//! frames, and their standard deviation is that of the difference of two J, `jitter_ns` / √6. seeraven/arduinoLatency
//! measured 12,000 echoes over each of several adapters: 0.924 ± 0.040 ms (FT232R, timer of 1 ms), 2.178 ± 0.036 (CH340)
//! and 3.177 ± 0.037 (ATmega16U2).
//!
//! *Deviations.* The measured means are up to 0.18 ms off whole milliseconds, as clocks of chips and hosts are not in step
//! with the bus; here they are whole. That a busy host misses a frame now and then is not modelled.

use crate::random::Stream;
use crate::time::SimTime;

/// The relation of a USB adapter's bytes to the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// Length of a USB frame, in nanoseconds.
    pub frame_ns: u64,
    /// Whole frames that each byte to the laptop needs beyond the one that it goes with.
    pub extra: u32,
    /// Longest random delay after a frame's boundary, in nanoseconds.
    pub jitter_ns: u64,
    /// The time from a brain's write until the bytes are at the chip, in nanoseconds; `None` if they wait for the next
    /// frame.
    pub down_ns: Option<u64>,
}

impl Frames {
    /// The frames of an adapter that adds nothing to the bus.
    pub const fn of(frame_ns: u64) -> Self {
        Self { frame_ns, extra: 0, jitter_ns: 0, down_ns: None }
    }

    /// The shortest time, in nanoseconds, from a packet's end at the chip until it is at the laptop.
    pub const fn least_up_ns(&self) -> u64 {
        self.frame_ns * self.extra as u64
    }

    /// The longest.
    pub const fn most_up_ns(&self) -> u64 {
        self.least_up_ns() + self.frame_ns + self.jitter_ns
    }

    /// The longest time, in nanoseconds, from a brain's write until the bytes are at the chip.
    pub fn most_down_ns(&self) -> u64 {
        self.down_ns.unwrap_or(self.frame_ns)
    }

    /// The instant at which that is at the laptop which the chip has at an instant, if so much is drawn for it.
    pub fn at_laptop(&self, at_chip: SimTime, jitter_ns: u64) -> SimTime {
        at_chip.up_to(self.frame_ns) + self.least_up_ns() + jitter_ns
    }

    /// The instant at which that is at the chip which a brain writes at an instant.
    pub(super) fn at_chip(&self, written: SimTime) -> SimTime {
        self.down_ns.map_or_else(|| written.up_to(self.frame_ns), |ns| written + ns)
    }

    pub(super) fn draw(&self, chance: &mut Stream) -> u64 {
        (chance.uniform() * self.jitter_ns as f64) as u64
    }
}
