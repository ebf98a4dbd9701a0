//! A new brain for each run.

use crate::action::Action;
use crate::belief::Belief;
use crate::body::Body;
use crate::brain::Brain;
use crate::turn::Turn;

/// A brain that is made anew for each run, so that nothing in a run depends on the runs before it.
///
/// An operator may reset or restore a world while brains hold its robots. They get no message, but time goes back: a
/// brain steps once in a tick at most, so that a step in the same tick or an earlier one is of another run. Instants
/// would not do, as a step at a tick's end and one at the start of the next are at the same. A state that is restored
/// from a later tick is not noticed.
#[derive(Clone, Debug)]
pub struct EachRun<B, F> {
    make: F,
    /// `None` if it could not be made again: then its robot is not driven any more.
    brain: Option<B>,
    last_tick: Option<u64>,
}

impl<B: Brain, F: FnMut(&Body) -> Option<B>> EachRun<B, F> {
    /// Begins with this brain; `make` makes those of later runs from the robot's data sheet.
    pub fn new(brain: B, make: F) -> Self {
        Self { make, brain: Some(brain), last_tick: None }
    }
}

impl<B: Brain, F: FnMut(&Body) -> Option<B>> Brain for EachRun<B, F> {
    fn step(&mut self, turn: &Turn) -> Action {
        if self.last_tick.replace(turn.tick).is_some_and(|last_tick| turn.tick <= last_tick) {
            self.brain = (self.make)(&turn.body);
        }
        self.brain.as_mut().map_or_else(Action::wait, |brain| brain.step(turn))
    }

    fn belief(&mut self) -> Option<Belief> {
        self.brain.as_mut()?.belief()
    }
}
