//! The trait of all brains.

use alloc::boxed::Box;

use crate::action::Action;
use crate::belief::Belief;
use crate::turn::Turn;

/// Turns what has arrived into what is done. A brain has no clock and does no input or output: whatever it
/// knows it has from its turns, so the same turns give the same actions, and a test can make them up.
pub trait Brain {
    /// One step. It is called once a turn, in order.
    fn step(&mut self, turn: &Turn) -> Action;

    /// The brain's beliefs and intentions, for observers; `None`: none. The program that runs the brain asks for it
    /// after a step, some 20 times a simulated second by default, and publishes it.
    fn belief(&mut self) -> Option<Belief> {
        None
    }
}

impl<B: Brain + ?Sized> Brain for &mut B {
    fn step(&mut self, turn: &Turn) -> Action {
        (**self).step(turn)
    }

    fn belief(&mut self) -> Option<Belief> {
        (**self).belief()
    }
}

impl<B: Brain + ?Sized> Brain for Box<B> {
    fn step(&mut self, turn: &Turn) -> Action {
        (**self).step(turn)
    }

    fn belief(&mut self) -> Option<Belief> {
        (**self).belief()
    }
}
