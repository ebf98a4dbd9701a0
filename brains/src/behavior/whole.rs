//! Any brain of this crate as a motor behaviour of a larger one: its signals count while it is active.

use baudbot_client::{Brain, Signals};

use crate::process::{Moment, MotorBehavior};

/// A brain that is a part of another. Each time that it is activated it goes on where it was.
pub struct Whole<B>(pub B);

impl<B: Brain + Send> MotorBehavior for Whole<B> {
    fn enter(&mut self, _: &mut Moment<'_>) {}

    fn step(&mut self, moment: &mut Moment<'_>) -> Option<Signals> {
        self.0.step(moment.turn).signals
    }
}
