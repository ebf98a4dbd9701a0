//! Any brain of this crate as a motor behaviour of a larger one: its signals count while it is active.

use baudbot_brain::{Brain, Signals};

use crate::process::{Moment, MotorBehavior};

/// A brain that is a part of another. Each time that it is activated it goes on where it was. What it sends to lamps, turrets
/// and speakers is not passed on.
pub struct Whole<B> {
    brain: B,
    /// What it wanted last: it need not say it again when it is activated again.
    signals: Option<Signals>,
}

impl<B> Whole<B> {
    /// Of this brain.
    pub fn new(brain: B) -> Self {
        Self { brain, signals: None }
    }
}

impl<B: Brain + Send> MotorBehavior for Whole<B> {
    fn step(&mut self, moment: &mut Moment<'_>) -> Option<Signals> {
        self.signals = self.brain.step(moment.turn).signals.or(self.signals);
        self.signals
    }
}
