//! The messages on a line, so that it can be told how old a reading truly is when it arrives.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use crate::time::SimTime;

/// When each of a message's fresh readings was sampled.
pub(super) type Sampled = Vec<(usize, SimTime)>;

/// The messages on their way.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Messages(VecDeque<Sent>);

/// A message of readings on its way.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Sent {
    /// How many bytes will be over when it is.
    end: u64,
    sampled: Sampled,
}

impl Messages {
    /// A message ends with the byte of that number, from 1.
    pub(super) fn push(&mut self, end: u64, sampled: Sampled) {
        self.0.push_back(Sent { end, sampled });
    }

    /// Takes the message that ends with the byte `over`, which is the last that is over.
    pub(super) fn take(&mut self, over: u64) -> Sampled {
        self.forget(over);
        self.0.pop_front_if(|sent| sent.end == over).map_or_else(Vec::new, |sent| sent.sampled)
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
