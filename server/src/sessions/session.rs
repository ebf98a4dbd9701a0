//! A session: the stream of one brain program.

use std::collections::VecDeque;

use baudbot_sim::{SimTime, Turn, World};
use bytes::Bytes;

use super::debt::{Debt, OpenTurn};
use super::quota::Quota;
use super::slot::Slot;
use super::thinking::{Thinking, Unaccounted};
use crate::convert::{self, RobotTurn};
use crate::endpoint::Mode;
use crate::measures::Answering;
use crate::message::{Recipient, Truth};
use crate::pace::Terms;
use crate::thinking::ProcessorTime;

/// Places in a brain's stream that Turns leave free, so that the news of an end always finds room.
pub(crate) const RESERVED: usize = 8;

/// Turns that a brain may leave unanswered while the world goes on without it.
const MAX_OPEN: usize = 256;

/// The stream of a brain program.
pub(super) struct Session {
    /// The name of the brain.
    pub(super) brain: String,
    /// The form of its input and output.
    pub(super) mode: Mode,
    /// Whether it has promised to think as long as the scenario states.
    pub(super) thinks_as_scenario: bool,
    /// Indices of its robots in the world.
    pub(super) robots: Vec<usize>,
    pub(super) recipient: Recipient,
    pub(super) turns: Turns,
    /// The number of collisions of each of its robots when the present era began.
    pub(super) collisions: Vec<u64>,
    pub(super) debt: Debt,
    pub(super) answering: Answering,
    pub(super) quota: Quota,
}

/// The numbers of the Turns of a session. They begin with 1.
#[derive(Default)]
pub(super) struct Turns {
    /// The last Turn that was given.
    last: u64,
    /// The last Turn before a reset, or before a change of pace. Answers to it and to earlier ones are thrown away.
    void: u64,
    /// The last Turn that was answered, and whether none before it was left out.
    answered: u64,
    leaves_out: bool,
    /// The counter of what makes Turns void in this world.
    pub(super) era: u64,
    /// The last Turns that were given; oldest first.
    given: VecDeque<Given>,
    pub(super) unaccounted: Unaccounted,
}

/// A Turn that was given.
struct Given {
    number: u64,
    tick: u64,
    /// The thinking until it is answered.
    thinking: Option<Thinking>,
}

impl Turns {
    /// None yet, of a session that begins in this era.
    pub(super) fn of_era(era: u64) -> Self {
        Self { era, ..Self::default() }
    }

    fn give(&mut self, given: Given) {
        self.last = given.number;
        if self.given.len() == MAX_OPEN {
            self.given.pop_front();
        }
        self.given.push_back(given);
    }

    /// All Turns up to now are void: another era begins.
    fn void(&mut self, era: u64) {
        self.void = self.last;
        self.era = era;
        self.given.clear();
        self.unaccounted = Unaccounted::default();
    }

    /// A Step answers the Turn of this number; 0 for none. Void ones may have been taken back before they were given.
    pub(super) fn note_answer(&mut self, number: u64) {
        if number > self.answered {
            self.leaves_out |= number > self.void && number != self.answered.max(self.void) + 1;
            self.answered = number;
        }
    }

    /// Turns that a brain which answers each of them has still to answer: they may be with the network, which takes
    /// thousands. The number is unknown of a brain that answers none, or some.
    fn unanswered(&self) -> u64 {
        let answers_each = self.answered > 0 && !self.leaves_out;
        if answers_each { self.last.saturating_sub(self.answered) } else { 0 }
    }

    pub(super) fn is_void(&self, number: u64) -> bool {
        number != 0 && number <= self.void
    }

    /// The tick of the Turn of this number, if it is not too long ago.
    pub(super) fn tick_of(&self, number: u64) -> Option<u64> {
        self.given.iter().rev().find(|given| given.number == number).map(|given| given.tick)
    }

    /// The Turn of this number is answered: gives what the brain was thinking about it, the first time.
    pub(super) fn answered(&mut self, number: u64) -> Option<Thinking> {
        self.given.iter_mut().rev().find(|given| given.number == number)?.thinking.take()
    }
}

impl Session {
    /// Another era begins with this world: Turns up to now are void, and no answer is owed.
    pub(super) fn begin_era(&mut self, era: u64, world: &World) {
        self.turns.void(era);
        self.recipient.void(self.turns.void);
        self.debt = Debt::Settled;
        let collisions = self.robots.iter().map(|&robot| world.robot(robot).counters().collisions);
        self.collisions = collisions.collect();
    }

    /// Gives the brain the Turn of those of its robots that step in this tick, `at` by robot. If the world waits for it, the
    /// brain owes an answer.
    ///
    /// A stream is bounded and a world never waits for one. If the brain does not read, so that its stream is full, the
    /// Turn is lost: that is counted, and no answer to it is owed, since the brain does not know of it. [`RESERVED`] places
    /// stay free for the news that the run or the stream has ended, which must not be lost.
    pub(super) fn deliver(
        &mut self,
        world: &World,
        at: &[Option<SimTime>],
        terms: Terms,
        processor: Option<&ProcessorTime>,
        slots: &mut [Slot],
    ) {
        let steps = self.steps(at);
        if steps.is_empty() {
            return;
        }
        let number = self.turns.last + 1;
        let begun = terms.owed_since();
        // A world that waits has one open Turn, and a lost one would not be waited for.
        let is_ahead = begun.is_none() && self.turns.unanswered() >= MAX_OPEN as u64;
        let has_room = self.recipient.capacity() > RESERVED && self.debt.count() < MAX_OPEN && !is_ahead;
        let truth = || self.truth(world, begun.is_some());
        // The brain may answer before this returns.
        let thinking = Thinking::begin(terms, processor, steps.iter().map(|turn| turn.robot));
        if !has_room || !self.recipient.turn(number, self.turn(world, at, number, terms), truth) {
            self.robots.iter().for_each(|&robot| slots[robot].lost_deliveries += 1);
            return;
        }
        self.turns.give(Given { number, tick: world.tick(), thinking });
        // The brain is asked now, whatever it was waiting for.
        steps.iter().for_each(|turn| slots[turn.robot].set_until(None));
        if let Some(begun) = begun {
            self.debt.add(OpenTurn { number, begun, steps });
        }
    }

    /// Sends the end of the run.
    pub(super) fn tell_ended(&self, world: &World) {
        self.recipient.ended(world.tick(), || self.truth(world, true));
    }

    fn truth(&self, world: &World, lockstep: bool) -> Truth {
        let standing = convert::standing(world, &self.robots);
        let (era, ending) = (self.turns.era, world.ending().cloned());
        Truth { era, lockstep, standing, ending, collisions_before: self.collisions.clone() }
    }

    /// The Turn of this number for its robots that step, `at` by robot.
    fn turn(&self, world: &World, at: &[Option<SimTime>], number: u64, terms: Terms) -> Bytes {
        let places = self.robots.iter().enumerate();
        let robots = places.filter_map(|(place, &robot)| Some(RobotTurn { place, robot, at: at[robot]? }));
        convert::turn(world, number, &robots.collect::<Vec<_>>(), (self.mode, terms))
    }

    /// The steps of its robots, `at` by robot.
    pub(super) fn steps(&self, at: &[Option<SimTime>]) -> Vec<Turn> {
        self.robots.iter().filter_map(|&robot| Some(Turn { robot, at: at[robot]? })).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turns(given: u64) -> Turns {
        let mut turns = Turns::default();
        (1..=given).for_each(|number| turns.give(Given { number, tick: number, thinking: None }));
        turns
    }

    #[test]
    fn a_brain_that_answers_each_turn_has_so_many_to_answer() {
        let mut turns = turns(1000);
        assert_eq!(turns.unanswered(), 0, "it may be one that only listens");
        (1..=3).for_each(|number| turns.note_answer(number));
        turns.note_answer(0);
        turns.note_answer(3);
        assert_eq!(turns.unanswered(), 997);
        turns.note_answer(5);
        assert_eq!(turns.unanswered(), 0, "it answers some only");
    }

    #[test]
    fn turns_of_a_run_that_is_over_need_no_answer() {
        let mut turns = turns(10);
        turns.note_answer(1);
        turns.void(1);
        turns.give(Given { number: 11, tick: 0, thinking: None });
        // Some of them had been given already, and are answered.
        turns.note_answer(4);
        assert_eq!(turns.unanswered(), 7);
        turns.note_answer(11);
        assert_eq!((turns.unanswered(), turns.leaves_out), (0, false));
    }
}
