//! The random part of a packet's way: the latencies of a radio, the jitter of USB.

use serde::{Deserialize, Serialize};

use super::adapter::{Adapter, Ftdi};
use crate::random::Stream;

/// The chance of one direction of an adapter.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Latencies {
    pub(super) chance: Stream,
    /// The latency of the next packet, in nanoseconds: drawn ahead, so that its arrival can be known.
    pub(super) next_ns: u64,
}

impl Latencies {
    pub(super) fn new(adapter: &Adapter, mut chance: Stream) -> Self {
        Self { next_ns: draw(adapter, &mut chance), chance }
    }

    pub(super) fn are_sound(&self, adapter: &Adapter) -> bool {
        let longest_ns = match adapter {
            Adapter::None => 0,
            Adapter::Cdc(frames) | Adapter::Ftdi(Ftdi { frames, .. }) => frames.jitter_ns,
            Adapter::Bluetooth(radio) => {
                radio.latency_ns.saturating_add(radio.spread_ns).saturating_add(radio.burst_ns)
            }
        };
        self.next_ns <= longest_ns && self.chance.is_sound()
    }

    /// The next packet's latency is used up.
    pub(super) fn take(&mut self, adapter: &Adapter) -> u64 {
        core::mem::replace(&mut self.next_ns, draw(adapter, &mut self.chance))
    }
}

fn draw(adapter: &Adapter, chance: &mut Stream) -> u64 {
    match adapter {
        Adapter::None => 0,
        Adapter::Cdc(frames) | Adapter::Ftdi(Ftdi { frames, .. }) => frames.draw(chance),
        Adapter::Bluetooth(radio) => radio.draw(chance),
    }
}
