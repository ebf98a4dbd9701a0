//! What is noted on a robot's timeline. It is no part of the robot's state.

use crate::link::LineCounters;
use crate::time::SimTime;
use crate::timeline::{Event, Timeline, What};

/// Notes what happens on a robot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Recorder {
    pub(crate) timeline: Timeline,
    /// Since when the microcontroller has been taking a message from its receiver.
    receiving_since: Option<SimTime>,
    /// How many bytes were lost by the last look.
    lost: u64,
}

impl Recorder {
    pub(crate) fn with_room(room: usize) -> Self {
        Self { timeline: Timeline::with_room(room), ..Self::default() }
    }

    #[inline]
    pub(super) fn note(&mut self, start: SimTime, end: SimTime, what: What) {
        self.timeline.push(Event { start, end, what });
    }

    /// The microcontroller takes a byte at `now`, and with it has a message or not.
    pub(super) fn receive(&mut self, now: SimTime, whole: bool, until: SimTime) {
        let since = *self.receiving_since.get_or_insert(now);
        if whole {
            self.receiving_since = None;
            self.note(since, until, What::Obey);
        }
    }

    /// Looks at the cables when a tick ends.
    pub(super) fn look_for_losses<'a>(
        &mut self,
        now: SimTime,
        cables: impl Iterator<Item = &'a LineCounters>,
    ) {
        let lost = cables.map(LineCounters::lost).sum();
        let bytes = u32::try_from(lost - self.lost.min(lost)).unwrap_or(u32::MAX);
        if bytes > 0 {
            self.note(now, now, What::Lost { bytes });
            self.lost = lost;
        }
    }
}
