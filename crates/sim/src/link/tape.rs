//! The bytes that have come over a line, for people who look at the cable. Nothing in the world reads it: it is no
//! part of the state, and a line that keeps none makes the same run.

use alloc::collections::VecDeque;

use crate::time::SimTime;

/// A cable of a robot's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cable {
    /// The cable from the robot's microcontroller to the laptop.
    Robot,
    /// The cable of a sensor's own, by the sensor's place among the sensors of the robot's
    /// [model](crate::model::RobotModel).
    Sensor(usize),
}

/// A byte that has come over a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taped {
    /// The instant at which it was at the line's end: at the laptop with its adapter, or in the microcontroller's
    /// receiver.
    pub at: SimTime,
    /// The byte, as it came.
    pub byte: u8,
    /// The end of the byte's message, as [`Event::end`](crate::timeline::Event::end); `None` if it belongs to none that
    /// is known.
    pub message_until: Option<SimTime>,
}

/// The last bytes of a line that were taken at its end, oldest first. Those that its receiver had no room for, and those that
/// an outage took, are not among them.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    bytes: VecDeque<Taped>,
    room: usize,
    total: u64,
}

impl Tape {
    /// An empty one that keeps so many bytes.
    pub(crate) fn with_room(room: usize) -> Self {
        Self { room, ..Self::default() }
    }

    /// Notes a byte, in place of the oldest if there is no room.
    pub(super) fn push(&mut self, taped: Taped) {
        self.total += 1;
        if self.bytes.len() >= self.room {
            self.bytes.pop_front();
        }
        if self.room > 0 {
            self.bytes.push_back(taped);
        }
    }

    /// The number of all bytes.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The bytes of number `first` and later, numbered from 0, and how many of them are no longer kept.
    pub fn since(&self, first: u64) -> (u64, impl Iterator<Item = &Taped>) {
        let kept_from = self.total - self.bytes.len() as u64;
        let skipped = usize::try_from(first.saturating_sub(kept_from)).unwrap_or(usize::MAX);
        (kept_from.saturating_sub(first), self.bytes.iter().skip(skipped))
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    #[test]
    fn the_last_bytes_are_kept_and_what_is_gone_is_counted() {
        let mut tape = Tape::with_room(3);
        for byte in 0..5 {
            tape.push(Taped { at: SimTime::ZERO, byte, message_until: None });
        }
        let since = |first| {
            let (gone, bytes) = tape.since(first);
            (gone, bytes.map(|taped| taped.byte).collect::<Vec<_>>())
        };
        assert_eq!(
            (since(0), since(3), since(9)),
            ((2, [2, 3, 4].into()), (0, [3, 4].into()), (0, [].into()))
        );
        assert_eq!(tape.total(), 5);
    }
}
