//! The readings of a message, and their instants.

use alloc::vec::Vec;

use baudbot_wire::{Encoding, khepera};

use super::Microcontroller;
use crate::firmware::Firmware;
use crate::link::Message as Tag;
use crate::time::SimTime;

/// The part of the readings that a message has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tells {
    Nothing,
    /// The position counters of a Khepera or an e-puck alone. No control cycle begins with them.
    Positions,
    /// All readings of a Khepera or an e-puck but its position counters.
    Levels,
    /// All readings.
    Readings,
}

impl Tells {
    /// What a message tells that has these.
    pub(super) fn of(positions: bool, levels: bool) -> Self {
        match (positions, levels) {
            (false, false) => Self::Nothing,
            (true, false) => Self::Positions,
            (false, true) => Self::Levels,
            (true, true) => Self::Readings,
        }
    }

    /// Whether those of a sensor with these components are among them.
    pub(super) fn has(self, components: &[Encoding]) -> bool {
        let counted = || khepera::counted(components, [0; 2]).is_some();
        match self {
            Self::Nothing => false,
            Self::Positions => counted(),
            Self::Levels => !counted(),
            Self::Readings => true,
        }
    }
}

impl Microcontroller {
    /// Notes that these readings are in a message that was begun at `now`.
    pub(super) fn note_told(
        &mut self,
        firmware: &Firmware,
        now: SimTime,
        tells: Tells,
        mut sampled: Vec<(usize, SimTime)>,
    ) -> Tag {
        if tells == Tells::Nothing {
            return Tag::default();
        }
        let (layout, repeats) = (firmware.layout(), firmware.protocol.repeats());
        let mut reading_ns = 0;
        sampled.clear();
        for (i, channel) in self.channels.iter_mut().enumerate().take(layout.counts.len()) {
            // Messages of a Khepera and an e-puck alone have a part of them.
            if tells != Tells::Readings && !layout.sensors().nth(i).is_some_and(|own| tells.has(own)) {
                continue;
            }
            let fresh = core::mem::take(&mut channel.fresh);
            reading_ns += if fresh { channel.took_ns } else { 0 };
            if fresh || (repeats && channel.samples > 0) {
                sampled.push((i, channel.measured_at));
            }
        }
        if tells == Tells::Positions {
            return Tag { sampled, ..Tag::default() };
        }
        self.sequence = self.sequence.wrapping_add(1);
        let cycle = SimTime::from_ns(now.as_ns().saturating_sub(reading_ns));
        Tag { sampled, cycle: Some(cycle), ..Tag::default() }
    }
}
