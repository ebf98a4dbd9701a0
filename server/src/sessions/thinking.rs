//! Brains' thinking, from a Turn to its answer.

use std::time::{Duration, Instant};

use super::Sessions;
use crate::clock;
use crate::pace::Terms;
use crate::thinking::{ProcessorTime, Thought};

/// A Turn that the brain has not answered yet.
pub(super) struct Thinking {
    since: Since,
    /// The robots that step in the tick.
    robots: Box<[usize]>,
}

enum Since {
    Wall(Instant),
    Processor(Duration),
}

impl Sessions {
    /// Sets the source of the brains' processor time from now on.
    pub(crate) fn time_by(&mut self, processor: Option<ProcessorTime>) {
        self.processor = processor;
    }

    /// The measurements of the brains of each robot, if there are any.
    pub(crate) fn thought(&self) -> impl Iterator<Item = Option<&Thought>> {
        self.slots.iter().map(|slot| slot.thought.as_deref())
    }

    /// A run begins anew.
    pub(crate) fn forget_thought(&mut self) {
        self.slots.iter_mut().for_each(|slot| slot.thought = None);
    }

    /// Notes that a brain has answered the Turn of this number.
    pub(super) fn note_thought(&mut self, session: u64, turn: u64) {
        let Some(session) = self.by_number.get_mut(&session) else { return };
        let Some(Thinking { since, robots }) = session.turns.answered(turn) else { return };
        let (wall, took) = match since {
            Since::Wall(begun) => (true, Some(clock::since(begun))),
            Since::Processor(begun) => (false, used(self.processor.as_ref(), &robots, begun)),
        };
        let Some(ns) = took.and_then(|took| u64::try_from(took.as_nanos()).ok()) else { return };
        for &robot in &robots {
            let thought = self.slots[robot].thought.get_or_insert_default();
            let histogram = if wall { &mut thought.wall } else { &mut thought.processor };
            histogram.note(ns);
        }
    }
}

fn used(processor: Option<&ProcessorTime>, robots: &[usize], begun: Duration) -> Option<Duration> {
    Some(processor?(*robots.first()?)?.saturating_sub(begun))
}

impl Thinking {
    /// A Turn is given to the brain of these robots, all of one program. `None` if nothing can be measured.
    pub(super) fn begin(
        terms: Terms,
        processor: Option<&ProcessorTime>,
        robots: impl Iterator<Item = usize>,
    ) -> Option<Self> {
        let mut robots = robots.peekable();
        let since = match terms {
            Terms::FollowsClock { now, .. } => Since::Wall(now),
            Terms::Waits(_) | Terms::GoesOn => Since::Processor(processor?(*robots.peek()?)?),
        };
        Some(Self { since, robots: robots.collect() })
    }
}
