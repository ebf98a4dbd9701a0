//! The same signals all the time, as often as the cable wants them.

use baudbot_brain::{Action, Brain, Signals, Turn};

use crate::parameter::{Parameter, SIGNAL};
use crate::throttle::CommandThrottle;

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

/// A brain that sends the same signals in answer to each message.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    parameters: Parameters,
    /// `None` before the first turn.
    throttle: Option<CommandThrottle>,
}

impl Constant {
    /// A brain that sends these signals.
    pub const fn new(parameters: Parameters) -> Self {
        Self { parameters, throttle: None }
    }
}

impl Brain for Constant {
    fn step(&mut self, turn: &Turn) -> Action {
        let Parameters { left, right } = self.parameters;
        let throttle = self.throttle.get_or_insert_with(|| CommandThrottle::new(&turn.body));
        throttle.send(turn, Signals { left, right })
    }
}
