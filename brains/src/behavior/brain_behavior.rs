//! Any brain of this crate as a motor behaviour of a larger one: its signals count while it is active.

use baudbot_brain::{Brain, Signals};

use crate::process::{MotorBehavior, StepContext};

/// A brain that is a part of another. Each time that it is activated it goes on where it was. What it sends to lamps, turrets
/// and speakers is not passed on.
pub struct BrainBehavior<B> {
    brain: B,
    /// The last signals, which the brain need not repeat when it is activated again.
    signals: Option<Signals>,
}

impl<B> BrainBehavior<B> {
    /// A `BrainBehavior` of this brain.
    pub fn new(brain: B) -> Self {
        Self { brain, signals: None }
    }
}

impl<B: Brain + Send> MotorBehavior for BrainBehavior<B> {
    fn step(&mut self, context: &mut StepContext<'_>) -> Option<Signals> {
        self.signals = self.brain.step(context.turn).signals.or(self.signals);
        self.signals
    }
}
