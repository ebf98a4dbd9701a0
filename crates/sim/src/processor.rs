//! The processor of a microcontroller: what its tasks cost.

use crate::time::SECOND_NS;

/// The timing of the processor; reading a sensor is that sensor's acquisition time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Processor {
    /// The time to frame readings, for each byte that goes on the wire, in nanoseconds.
    pub framing_ns_per_byte: u64,
    /// The time to take a byte from the receiver, in nanoseconds.
    pub receiving_ns_per_byte: u64,
    /// The time to obey a command, once its last byte is taken, in nanoseconds.
    pub obeying_ns: u64,
    /// The operations of a brain's program a second, if it is to run one.
    pub operations_per_s: Option<f64>,
    /// Memory for a brain's variables, in bytes, if that matters.
    pub ram_bytes: Option<u64>,
    /// The time for which its bootloader waits at the start of a run before it starts the firmware, in nanoseconds:
    /// opening a serial port pulls DTR, and on many boards that resets the chip. Until then nothing is read, sent,
    /// taken or obeyed, and bytes that come are lost. Schedules begin with the firmware: their phases have this time
    /// in them.
    pub bootloader_ns: u64,
}

impl Processor {
    /// The time of so many operations, in nanoseconds.
    pub fn thinking_ns(&self, operations: u64) -> Option<u64> {
        let per_s = self.operations_per_s?;
        Some((operations as f64 / per_s * SECOND_NS as f64 + 0.5) as u64)
    }
}
