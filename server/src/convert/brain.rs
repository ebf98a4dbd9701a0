//! Messages to and from a brain.

use baudbot_brain::{Action, Body};
use baudbot_proto::v1;
use baudbot_sim::SimTime;
use baudbot_sim::drive::Wheels;
use baudbot_sim::model::RobotSpec;
use bytes::Bytes;
use tonic::Status;

use crate::endpoint::{Output, Signals, Thinking, Until, Write};
use crate::message::{Attached, Delivery};

/// A brain's description of its robots.
pub(crate) fn welcome(attached: &Attached) -> v1::Welcome {
    let scenario = &attached.scenario;
    let robots = attached.robots.iter().map(|&i| description(&scenario.robots[i])).collect();
    v1::Welcome { step_ns: scenario.step_ns, lockstep: attached.lockstep, robots }
}

/// The first response on a brain's stream.
pub(crate) fn first_response(attached: &Attached) -> AttachResponse {
    response(v1::attach_response::Response::Welcome(welcome(attached)))
}

fn response(response: v1::attach_response::Response) -> AttachResponse {
    AttachResponse::Other(Box::new(v1::AttachResponse { response: Some(response) }))
}

/// A robot's data sheet.
pub(super) fn description(spec: &RobotSpec) -> v1::RobotDescription {
    (&Body::from(spec)).into()
}

/// The content of a brain's Step, for the ports.
pub(crate) fn writes(steps: Vec<v1::RobotStep>) -> Vec<Write> {
    let output = |output| match output {
        v1::robot_step::Output::Raw(bytes) => Output::Raw(bytes),
        v1::robot_step::Output::Command(v1::Command { left_signal, right_signal, other_signals }) => {
            let wheels = Wheels { left: left_signal, right: right_signal };
            Output::Command(Signals { wheels, others: other_signals })
        }
        v1::robot_step::Output::Poll(_) => Output::Poll,
    };
    let write = |step: v1::RobotStep| Write {
        slot: step.robot as usize,
        thinking: Thinking { ns: step.thinking_ns, operations: step.operations },
        output: step.output.map(output),
        until: step.until_message.map(|until| Until { at_latest: until.at_latest_ns.map(SimTime::from_ns) }),
        opened: step.opened,
        ports: step.ports.into_iter().map(|port| (port.sensor as usize, port.data)).collect(),
    };
    steps.into_iter().map(write).collect()
}

/// The output of the brain of the robot in this place that has no stream.
pub(crate) fn write(robot: usize, action: Action) -> Write {
    let Action { signals, others, thinking, operations, poll, until } = action;
    let output = match signals {
        Some(baudbot_brain::Signals { left, right }) => {
            Some(Output::Command(Signals { wheels: Wheels { left, right }, others }))
        }
        None => poll.then_some(Output::Poll),
    };
    let ns = thinking.map(|time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
    let until = until.map(|until| Until { at_latest: until.at_latest_ns.map(SimTime::from_ns) });
    Write {
        slot: robot,
        thinking: Thinking { ns, operations },
        output,
        until,
        opened: false,
        ports: Vec::new(),
    }
}

/// A response on a brain's stream.
pub(crate) enum AttachResponse {
    /// A Turn, in the bytes of the contract's `AttachResponse`.
    Turn(Bytes),
    Other(Box<v1::AttachResponse>),
}

/// A delivery for a brain's stream, or the stream's end.
pub(crate) fn delivery(delivery: Delivery) -> Result<AttachResponse, Status> {
    match delivery {
        Delivery::Close(status) => Err(status),
        Delivery::Ended { tick } => Ok(response(v1::attach_response::Response::Ended(v1::Ended { tick }))),
        Delivery::Turn { turn, .. } => Ok(AttachResponse::Turn(turn)),
    }
}
