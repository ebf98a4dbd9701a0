//! The answers of brains in their steps, as bytes of the cable or as a command.

use super::{Input, World};
use crate::robot::Written;
use crate::time::SimTime;

/// The answer of a brain in its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<'a> {
    /// See [`Input::robot`].
    pub robot: usize,
    /// See [`Input::at`].
    pub at: SimTime,
    /// The output for its port.
    pub written: Written<'a>,
}

impl<'a> From<Input<'a>> for Answer<'a> {
    fn from(input: Input<'a>) -> Self {
        Self { robot: input.robot, at: input.at, written: Written::Bytes(input.bytes) }
    }
}

impl World {
    /// The same as [`finish`](Self::finish), with answers that may be commands. The state is the same as with the bytes
    /// of these commands, to the last bit; where a cable takes no time and loses nothing, the bytes are only counted.
    pub fn finish_answers(&mut self, answers: &[Answer<'_>]) {
        self.finish_with(answers, |answer| *answer);
    }
}
