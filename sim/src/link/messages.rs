//! The messages on a line: what is to be known of them when they arrive, and does not travel with them.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::time::SimTime;

/// A message on its way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Message {
    /// When each of its fresh readings was truly sampled.
    pub(crate) sampled: Vec<(usize, SimTime)>,
    /// When the control cycle began that it belongs to, if it belongs to one.
    pub(crate) cycle: Option<SimTime>,
    /// When its last byte is at the end of the wire.
    pub(crate) on_wire_until: SimTime,
}

/// The messages on their way.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Messages(VecDeque<Sent>);

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Sent {
    /// How many bytes will be over when it is.
    end: u64,
    message: Message,
}

impl Messages {
    /// A message ends with the byte of that number, from 1.
    pub(super) fn push(&mut self, end: u64, message: Message) {
        self.0.push_back(Sent { end, message });
    }

    /// Takes the message that ends with the byte `over`, which is the last that is over.
    pub(super) fn take(&mut self, over: u64) -> Option<Message> {
        self.forget(over);
        self.0.pop_front_if(|sent| sent.end == over).map(|sent| sent.message)
    }

    /// Takes the message that the byte `over` is of, which is the last that is over.
    pub(super) fn take_around(&mut self, over: u64) -> Option<Message> {
        self.forget(over);
        self.0.pop_front().map(|sent| sent.message)
    }

    /// A message of which the last byte is over, and that nobody asked about then, was not understood.
    pub(super) fn forget(&mut self, over: u64) {
        while self.0.pop_front_if(|sent| sent.end < over).is_some() {}
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
