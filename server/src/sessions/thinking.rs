//! Brains' thinking, from a Turn to its answer.

use std::time::{Duration, Instant};

use super::Sessions;
use super::slot::Slot;
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
        match since {
            Since::Wall(begun) => {
                let ns = whole_ns(clock::since(begun));
                robots.iter().for_each(|&robot| thought(&mut self.slots[robot]).wall.note(ns));
            }
            Since::Processor(begun) => {
                let now = robots.first().and_then(|&robot| self.processor.as_ref()?(robot));
                let Some(now) = now else { return };
                session.turns.unaccounted.add(robots, begun, now, |robots, each| {
                    let ns = whole_ns(each);
                    robots.iter().for_each(|&robot| thought(&mut self.slots[robot]).processor.note(ns));
                });
            }
        }
    }
}

fn thought(slot: &mut Slot) -> &mut Thought {
    slot.thought.get_or_insert_default()
}

fn whole_ns(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// Answers of a brain that seems to have used no processor time for them.
///
/// Linux brings the time of another process up to date when its threads go to sleep and at the kernel's ticks, not when
/// it is asked. A brain that has answered and still runs shows nothing then. What it shows later belongs to all its
/// answers since, which share it equally: no time is lost, and none was thought in no time.
#[derive(Default)]
pub(super) struct Unaccounted {
    /// The processor time at the Turn of the first of them.
    since: Duration,
    /// The robots of each, oldest first.
    answers: Vec<Box<[usize]>>,
}

impl Unaccounted {
    /// The most answers that are kept: a clock that stands measures nothing.
    const MAX: usize = 1024;

    /// Adds an answer for these robots of a brain that had used the time `begun` at its Turn, and has used `now`. If that
    /// is more, each answer that is unaccounted for is noted with its robots and its share.
    fn add(
        &mut self,
        robots: Box<[usize]>,
        begun: Duration,
        now: Duration,
        mut note: impl FnMut(&[usize], Duration),
    ) {
        if self.answers.len() == Self::MAX {
            self.answers.clear();
        }
        if self.answers.is_empty() {
            self.since = begun;
        }
        self.answers.push(robots);
        let share = now.saturating_sub(self.since) / u32::try_from(self.answers.len()).unwrap_or(u32::MAX);
        if !share.is_zero() {
            self.answers.drain(..).for_each(|robots| note(&robots, share));
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Oracle: the sum of the shares is all that the clock has shown, and no share is nothing.
    #[test]
    fn answers_that_the_clock_shows_nothing_of_share_what_it_shows_next() {
        let mut unaccounted = Unaccounted::default();
        let mut noted = Vec::new();
        // The processor time at each Turn and at its answer: it stands for two of them, and goes on before the third.
        for (robot, begun_us, now_us) in [(0, 50, 80), (1, 80, 80), (2, 80, 80), (3, 200, 230), (4, 240, 250)]
        {
            let [begun, now] = [begun_us, now_us].map(Duration::from_micros);
            unaccounted
                .add([robot].into(), begun, now, |robots, each| noted.push((robots[0], each.as_micros())));
        }
        assert_eq!(noted, [(0, 30), (1, 50), (2, 50), (3, 50), (4, 10)]);
    }

    #[test]
    fn a_clock_that_stands_measures_nothing_and_fills_no_memory() {
        let mut unaccounted = Unaccounted::default();
        let now = Duration::from_secs(1);
        for _ in 0..=3 * Unaccounted::MAX {
            unaccounted.add([0].into(), now, now, |_, _| panic!("nothing was measured"));
        }
        assert_eq!(unaccounted.answers.len(), 1);
    }
}
