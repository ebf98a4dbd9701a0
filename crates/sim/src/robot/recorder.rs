//! The notes on a robot's timeline. It is no part of the robot's state.

use crate::microcontroller::Taken;
use crate::time::SimTime;
use crate::timeline::{Event, Timeline, What};

/// Notes what happens on a robot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recorder {
    pub(crate) timeline: Timeline,
    /// Since when the microcontroller has been taking a message from its receiver.
    receiving_since: Option<SimTime>,
    /// The number of bytes that were lost by the last look.
    lost: u64,
}

impl Recorder {
    /// Begins to look when `lost` bytes have been lost so far.
    pub(crate) fn new(room: usize, lost: u64) -> Self {
        Self { timeline: Timeline::with_room(room), lost, ..Self::default() }
    }

    #[inline]
    pub(crate) fn note(&mut self, start: SimTime, end: SimTime, what: What) {
        self.timeline.push(Event { start, end, what });
    }

    /// The microcontroller takes a byte at `now`, and is busy with it until `until`.
    pub(super) fn receive(&mut self, now: SimTime, taken: Taken, until: SimTime) {
        let since = *self.receiving_since.get_or_insert(now);
        match taken {
            Taken::Part => {}
            Taken::Nonsense => self.receiving_since = None,
            Taken::Poll | Taken::Command(_) => {
                self.receiving_since = None;
                self.note(since, until, What::Obey);
            }
        }
    }

    /// Notes at the end of a tick that so many bytes have been lost on the robot's cables so far.
    pub(super) fn note_losses(&mut self, now: SimTime, lost: u64) {
        let bytes =
            u32::try_from(lost.saturating_sub(core::mem::replace(&mut self.lost, lost))).unwrap_or(u32::MAX);
        if bytes > 0 {
            self.note(now, now, What::Lost { bytes });
        }
    }
}
