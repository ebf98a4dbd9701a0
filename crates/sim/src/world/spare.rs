//! Memory that is used again from tick to tick.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::Turn;
use super::inputs_by_robot::InputsByRobot;
use super::motion::Lists;
use super::starts::Starts;
use crate::scene::Frozen;
use crate::time::SimTime;

/// Memory that ticks use again and again, boxed where it is large, as it is taken and put back. A clone begins with none.
#[derive(Debug, Default)]
pub(super) struct Spare {
    pub(super) frozen: Option<Box<Frozen>>,
    /// Rows of trails as they were before the step.
    pub(super) rows: [Vec<f64>; 2],
    pub(super) lists: Option<Box<Lists>>,
    /// The instants at which each robot's brain steps in the tick, if it does.
    pub(super) steps: Vec<Option<SimTime>>,
    pub(super) inputs_by_robot: InputsByRobot,
    pub(super) starts: Starts,
}

impl Spare {
    pub(super) fn note_steps(&mut self, turns: &[Turn], robots: usize) {
        self.steps.clear();
        self.steps.resize(robots, None);
        for turn in turns {
            self.steps[turn.robot] = Some(turn.at);
        }
    }
}

impl Clone for Spare {
    fn clone(&self) -> Self {
        Self::default()
    }
}
