//! Characters that the chip has sent.

use arrayvec::ArrayVec;
use baudbot_avr::usart::Frame;
use serde::{Deserialize, Serialize};

/// Characters that can wait for the embedder: 20 ms at 115 200 baud.
const ROOM: usize = 256;

/// A character on its way out of TXD.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sent {
    /// The frame on its way.
    pub frame: Frame,
    /// The instant at which its start bit begins.
    pub start_ns: u64,
    /// The instant at which its last stop bit ends.
    pub end_ns: u64,
}

/// Characters that wait, in the order of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Queue {
    waiting: ArrayVec<Sent, ROOM>,
}

impl Queue {
    /// False: there is no room, and the character is lost.
    pub(crate) fn push(&mut self, sent: Sent) -> bool {
        self.waiting.try_push(sent).is_ok()
    }

    /// Whether all ends come after their beginnings.
    pub(crate) fn is_possible(&self) -> bool {
        self.waiting.iter().all(|sent| sent.start_ns <= sent.end_ns)
    }

    pub(crate) fn drain(&mut self) -> impl Iterator<Item = Sent> {
        self.waiting.drain(..)
    }
}
