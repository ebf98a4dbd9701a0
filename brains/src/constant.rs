//! The same signals in every step.

use baudbot_brain::{Action, Brain, Turn};

use crate::parameter::{Parameter, SIGNAL};

/// The signals that are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// Signal of the left motor; 1 is full voltage forwards.
    pub left: f64,
    /// Signal of the right motor; 1 is full voltage forwards.
    pub right: f64,
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter { name: "left", meaning: "signal of the left motor", range: SIGNAL, field: |p| &mut p.left },
    Parameter { name: "right", meaning: "signal of the right motor", range: SIGNAL, field: |p| &mut p.right },
];

/// A brain that sends the same signals in every step.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant(Parameters);

impl Constant {
    /// A brain that sends these signals.
    pub const fn new(parameters: Parameters) -> Self {
        Self(parameters)
    }
}

impl Brain for Constant {
    fn step(&mut self, _: &Turn) -> Action {
        Action::drive(self.0.left, self.0.right)
    }
}
