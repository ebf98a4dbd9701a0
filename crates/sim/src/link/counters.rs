//! The counters of a line.

use serde::{Deserialize, Serialize};

/// The counters of one direction of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineCounters {
    /// Bytes that went over the line, lost ones included.
    pub bytes: u64,
    /// Bytes that arrived with a wrong bit.
    pub corrupted_bytes: u64,
    /// Bytes lost because the receiver had no room.
    pub overrun_bytes: u64,
    /// Bytes not taken because the sender's buffer was full.
    pub refused_bytes: u64,
    /// Messages that arrived whole.
    pub messages: u64,
    /// Frames thrown away for their checksum, their coding or their length.
    pub bad_frames: u64,
    /// Sound frames whose content made no sense, and messages cut short by silence.
    pub bad_messages: u64,
    /// Bytes lost because the cable was out, or the microcontroller's bootloader still waited. A byte is counted when the line is next in use.
    pub lost_bytes: u64,
}

impl LineCounters {
    pub(super) fn is_sound(&self) -> bool {
        let counts = [self.bytes, self.corrupted_bytes, self.overrun_bytes, self.refused_bytes];
        let others = [self.messages, self.bad_frames, self.bad_messages, self.lost_bytes];
        counts.into_iter().chain(others).all(crate::sound::count)
    }

    /// Bytes that did not arrive as they were sent, for whatever reason.
    pub fn lost(&self) -> u64 {
        self.corrupted_bytes + self.overrun_bytes + self.refused_bytes + self.lost_bytes
    }
}
