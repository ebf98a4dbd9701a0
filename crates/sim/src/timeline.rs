//! The timeline: the timing diagram (Fig. 3.2) of a run, as far back as memory is given to it.
//!
//! Each robot keeps its last events in a ring. They are for people and for measuring: nothing in the world reads
//! them, they are no part of its state, and a world that keeps none makes the same run.

use alloc::vec::Vec;

use crate::time::SimTime;

/// Something that happened on a robot, its cables, or its brain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// The instant at which it began.
    pub start: SimTime,
    /// The instant at which it was over; equal to `start` for what takes no time.
    pub end: SimTime,
    /// The event.
    pub what: What,
}

/// An event. Sensors go by their place in [`RobotModel::sensors`](crate::model::RobotModel::sensors), faults by
/// theirs in [`RobotModel::faults`](crate::model::RobotModel::faults).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// The microcontroller read a sensor.
    Acquire {
        /// The sensor.
        sensor: u16,
    },
    /// A device with a clock of its own measured; at the end its value was at its output.
    Measure {
        /// The sensor.
        sensor: u16,
    },
    /// The microcontroller laid out readings for its wire.
    Frame {
        /// Bytes of the message.
        bytes: u32,
    },
    /// The microcontroller waited until its transmitter had taken them.
    Block,
    /// A message of readings was on the wire, as characters that follow each other.
    Up {
        /// The number of bytes.
        bytes: u32,
    },
    /// After the wire: the message waited in an adapter, or was in the air, until it was at the laptop whole.
    Adapter,
    /// A sensor's message was on the wire of its own.
    Port {
        /// The sensor.
        sensor: u16,
        /// The number of bytes.
        bytes: u32,
    },
    /// Bytes to a device were on their way, on the cable of the sensor's own.
    PortDown {
        /// The sensor.
        sensor: u16,
        /// The number of bytes.
        bytes: u32,
    },
    /// The brain stepped and thought.
    Think {
        /// Whether a message had come since its last step.
        informed: bool,
    },
    /// The brain's bytes were on their way to the microcontroller, adapter and wire.
    Down {
        /// The number of bytes.
        bytes: u32,
    },
    /// The microcontroller took a message from its receiver byte by byte, and obeyed it.
    Obey,
    /// The actuators took a command up.
    Act,
    /// A cycle was not closed by its deadline.
    Late,
    /// A read of a sensor, or with none a frame, fell due while the processor was busy and was left out.
    Missed {
        /// The sensor; [`u16::MAX`] stands for a frame.
        sensor: u16,
    },
    /// Bytes were lost, damaged or refused on the cable since the last tick.
    Lost {
        /// The number of bytes.
        bytes: u32,
    },
    /// A fault of the scenario's was in force.
    Fault {
        /// The fault.
        fault: u16,
    },
}

/// The last events of a robot, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    events: Vec<Event>,
    /// Place of the oldest once the ring is full.
    oldest: usize,
    room: usize,
    total: u64,
}

impl Timeline {
    /// An empty one that keeps so many events.
    pub fn with_room(room: usize) -> Self {
        Self { room, ..Self::default() }
    }

    /// One without events, of which there were as many.
    pub(crate) fn emptied(&self) -> Self {
        Self { total: self.total, ..Self::default() }
    }

    /// The bytes that its events take once there are as many as it keeps.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.room * size_of::<Event>()
    }

    /// Keeps the last so many events, from now on.
    pub fn set_room(&mut self, room: usize) {
        if room == self.room {
            return;
        }
        let gone = self.events.len().saturating_sub(room);
        self.events = self.events().skip(gone).copied().collect();
        (self.oldest, self.room) = (0, room);
    }

    /// Notes an event, in place of the oldest if there is no room.
    #[inline]
    pub fn push(&mut self, event: Event) {
        self.total += 1;
        if self.events.len() < self.room {
            self.events.push(event);
        } else if self.room > 0 {
            self.events[self.oldest] = event;
            self.oldest = (self.oldest + 1) % self.room;
        }
    }

    /// The number of all events.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The events that are kept, in the order in which they were noted: by when they were known, which is not quite
    /// the order of their beginnings.
    pub fn events(&self) -> impl Iterator<Item = &Event> {
        let (new, old) = self.events.split_at(self.oldest);
        old.iter().chain(new)
    }

    /// The events of number `first` and later, numbered from 0 in the order in which they were noted, and how many of
    /// them are no longer kept.
    pub fn since(&self, first: u64) -> (u64, impl Iterator<Item = &Event>) {
        let kept_from = self.total - self.events.len() as u64;
        let skipped = first.saturating_sub(kept_from);
        (kept_from.saturating_sub(first), self.events().skip(skipped as usize))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(ns: u64) -> Event {
        Event { start: SimTime::from_ns(ns), end: SimTime::from_ns(ns + 1), what: What::Act }
    }

    fn starts<'a>(events: impl Iterator<Item = &'a Event>) -> Vec<u64> {
        events.map(|event| event.start.as_ns()).collect()
    }

    #[test]
    fn the_last_events_are_kept_and_what_is_gone_is_counted() {
        let mut timeline = Timeline::with_room(3);
        (0..2).for_each(|ns| timeline.push(event(ns)));
        assert_eq!((starts(timeline.events()), timeline.total()), (Vec::from([0, 1]), 2));
        (2..5).for_each(|ns| timeline.push(event(ns)));
        assert_eq!((starts(timeline.events()), timeline.total()), (Vec::from([2, 3, 4]), 5));
        let (gone, rest) = timeline.since(3);
        assert_eq!((gone, starts(rest)), (0, Vec::from([3, 4])));
        let (gone, rest) = timeline.since(1);
        assert_eq!((gone, starts(rest)), (1, Vec::from([2, 3, 4])));
        assert_eq!(timeline.since(5).1.count(), 0);
    }

    #[test]
    fn with_more_room_nothing_is_lost_and_with_less_the_oldest() {
        let mut timeline = Timeline::with_room(3);
        (0..5).for_each(|ns| timeline.push(event(ns)));
        timeline.set_room(4);
        timeline.push(event(5));
        assert_eq!((starts(timeline.events()), timeline.total()), (Vec::from([2, 3, 4, 5]), 6));
        timeline.push(event(6));
        timeline.set_room(2);
        timeline.push(event(7));
        assert_eq!((starts(timeline.events()), timeline.total()), (Vec::from([6, 7]), 8));
    }

    #[test]
    fn without_room_nothing_is_kept() {
        let mut timeline = Timeline::default();
        timeline.push(event(0));
        assert_eq!((timeline.events().count(), timeline.total()), (0, 1));
    }
}
