//! The messages on a line: what is to be known of them when they arrive, and does not travel with them.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::time::SimTime;

/// A message on its way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Message {
    /// The instants at which each of its fresh readings was truly sampled.
    pub(crate) sampled: Vec<(usize, SimTime)>,
    /// The instant at which the control cycle began that it belongs to, if it belongs to one.
    pub(crate) cycle: Option<SimTime>,
    /// The instant at which its last byte is at the end of the wire.
    pub(crate) on_wire_until: SimTime,
}

/// The messages on their way.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Messages(VecDeque<Sent>);

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Sent {
    /// The number of bytes that were sent before it.
    begin: u64,
    /// The number of bytes that will be over when it is.
    end: u64,
    message: Message,
}

impl Messages {
    /// Whether they can be on a line on which so many bytes have been put, with readings of so many sensors: each ends
    /// behind the one before it, and will be over.
    pub(super) fn are_sound(&self, sent: u64, sensors: usize) -> bool {
        let mut ends = self.0.iter().map(|sent| sent.end);
        ends.clone().is_sorted()
            && ends.next_back().is_none_or(|end| end <= sent)
            && self.0.iter().all(|sent| {
                let known = sent.message.sampled.iter().all(|(i, _)| *i < sensors);
                known && sent.begin <= sent.end
            })
    }

    /// A message has the bytes of these numbers, from 1: those behind `begin`, and `end` as the last.
    pub(super) fn push(&mut self, (begin, end): (u64, u64), message: Message) {
        self.0.push_back(Sent { begin, end, message });
    }

    /// The byte of this number was lost on its way, and will never be over: all behind it move up.
    pub(super) fn drop_byte(&mut self, number: u64) {
        for sent in self.0.iter_mut().rev().take_while(|sent| sent.end >= number) {
            sent.end -= 1;
            sent.begin -= u64::from(sent.begin >= number);
        }
    }

    /// Takes the message that ends with the byte `over`, which is the last that is over.
    pub(super) fn take(&mut self, over: u64) -> Option<Message> {
        self.forget(over);
        self.0.pop_front_if(|sent| sent.end == over).map(|sent| sent.message)
    }

    /// The message that the byte `over` is of, which is the last that is over.
    pub(super) fn around(&mut self, over: u64) -> Option<&Message> {
        self.forget(over);
        self.0.front().filter(|sent| sent.begin < over).map(|sent| &sent.message)
    }

    /// The same, and nothing is forgotten.
    pub(super) fn holding(&self, over: u64) -> Option<&Message> {
        self.0.iter().find(|sent| sent.begin < over && over <= sent.end).map(|sent| &sent.message)
    }

    /// Drops a message whose last byte is over and which was not asked about then: it was not understood.
    pub(super) fn forget(&mut self, over: u64) {
        while self.0.pop_front_if(|sent| sent.end < over).is_some() {}
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
