//! The Steps of brains.

use baudbot_brain::{Action, Signals, Until};

use crate::v1;
use crate::v1::robot_step::Output;

/// The first robot of a stream; that of another is `RobotStep { robot, ..RobotStep::from(action) }`.
impl From<&Action> for v1::RobotStep {
    fn from(action: &Action) -> Self {
        Self {
            robot: 0,
            thinking_ns: action.thinking.map(|time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)),
            output: output(action),
            operations: action.operations,
            until_message: action.until.map(Into::into),
            opened: false,
            ports: Vec::new(),
        }
    }
}

fn output(action: &Action) -> Option<Output> {
    match action.signals {
        Some(Signals { left, right }) => Some(Output::Command(v1::Command {
            left_signal: left,
            right_signal: right,
            other_signals: action.others.clone(),
        })),
        None => action.poll.then_some(Output::Poll(v1::Poll {})),
    }
}

impl From<Until> for v1::UntilMessage {
    fn from(Until { at_latest_ns }: Until) -> Self {
        Self { at_latest_ns }
    }
}
