//! The laptop's end of a brain's ports: what it writes, checked when it comes, and turned into bytes of the
//! wire when the world takes it.

use std::sync::Arc;

use baudbot_sim::Scenario;
use baudbot_sim::drive::Wheels;
use baudbot_sim::firmware::Protocol;
use baudbot_sim::robot::RobotSpec;
use baudbot_wire::{frame, message, write_command, write_values};
use tonic::Status;

/// Most bytes that one Step may write to one port.
const MAX_WRITE: usize = 64 << 10;

/// Longest thinking time that a brain may declare: an hour.
const MAX_THINKING_NS: u64 = 3_600_000_000_000;

/// What a brain writes to one robot's port.
pub(crate) struct Write {
    /// Place of the robot in the stream.
    pub(crate) slot: usize,
    pub(crate) thinking_ns: Option<u64>,
    pub(crate) output: Option<Output>,
}

pub(crate) enum Output {
    Raw(Vec<u8>),
    Command(Wheels),
    Poll,
}

/// The ports of one stream.
pub(crate) struct Endpoint {
    scenario: Arc<Scenario>,
    robots: Vec<usize>,
    raw: bool,
}

impl Endpoint {
    pub(crate) fn new(scenario: Arc<Scenario>, robots: Vec<usize>, raw: bool) -> Self {
        Self { scenario, robots, raw }
    }

    /// Whether a Step makes sense. What is wrong with it is the brain's to mend, so the error names the field.
    pub(crate) fn check(&self, writes: &[Write]) -> Result<(), Status> {
        let mut seen = vec![false; self.robots.len()];
        for (i, write) in writes.iter().enumerate() {
            self.check_write(write).map_err(|(field, problem)| {
                Status::invalid_argument(format!("step.robots[{i}].{field}: {problem}"))
            })?;
            if std::mem::replace(&mut seen[write.slot], true) {
                let text = format!("step.robots[{i}].robot: {} is named twice", write.slot);
                return Err(Status::invalid_argument(text));
            }
        }
        Ok(())
    }

    fn check_write(&self, write: &Write) -> Result<(), Problem> {
        let Some(&robot) = self.robots.get(write.slot) else {
            let problem = format!("is {}, but this stream has {} robots", write.slot, self.robots.len());
            return Err(("robot", problem));
        };
        if write.thinking_ns.is_some_and(|ns| ns > MAX_THINKING_NS) {
            return Err(("thinking_ns", format!("must not exceed {MAX_THINKING_NS}")));
        }
        let spec = &self.scenario.robots()[robot];
        match (&write.output, self.raw) {
            (None, _) => Ok(()),
            (Some(Output::Raw(bytes)), true) if bytes.len() <= MAX_WRITE => Ok(()),
            (Some(Output::Raw(bytes)), true) => {
                Err(("raw", format!("has {} bytes, the limit is {MAX_WRITE}", bytes.len())))
            }
            (Some(Output::Raw(_)), false) => {
                Err(("raw", "the stream is in MESSAGES mode; ask for RAW in the Hello".into()))
            }
            (Some(_), true) => Err(("output", "the stream is in RAW mode and takes only `raw`".into())),
            (Some(Output::Command(signals)), false) => check_signals(spec, *signals),
            (Some(Output::Poll), false) => check_poll(spec),
        }
    }
}

/// The field that is wrong, and how.
type Problem = (&'static str, String);

fn check_signals(spec: &RobotSpec, signals: Wheels) -> Result<(), Problem> {
    for (field, signal) in [("command.left_signal", signals.left), ("command.right_signal", signals.right)] {
        if !signal.is_finite() {
            return Err((field, format!("must be a finite number, is {signal}")));
        }
        if let Some(limit) = spec.signal_limit.filter(|limit| signal.abs() > *limit) {
            return Err((field, format!("must be within -{limit} and {limit}, is {signal}")));
        }
    }
    Ok(())
}

fn check_poll(spec: &RobotSpec) -> Result<(), Problem> {
    match spec.firmware.protocol {
        Protocol::Bare { .. } => {
            Err(("poll", "the bare protocol has none; a command asks for readings".into()))
        }
        Protocol::Framed { .. } => Ok(()),
    }
}

/// The bytes of an output that was checked; `sequence` is that of the robot's next message.
pub(crate) fn encode(spec: &RobotSpec, sequence: &mut u8, output: Option<Output>) -> Vec<u8> {
    match output {
        None => Vec::new(),
        Some(Output::Raw(bytes)) => bytes,
        Some(Output::Command(signals)) => encode_command(spec, sequence, signals),
        Some(Output::Poll) => in_frame(&message::poll(next(sequence))),
    }
}

fn encode_command(spec: &RobotSpec, sequence: &mut u8, signals: Wheels) -> Vec<u8> {
    let signals = [signals.left, signals.right];
    let layout = spec.firmware.layout();
    let mut payload = [0; frame::MAX_PAYLOAD];
    match spec.firmware.protocol {
        Protocol::Bare { .. } => {
            let n = write_values(layout.motors, signals, &mut payload).expect(FITS);
            payload[..n].to_vec()
        }
        Protocol::Framed { .. } => {
            let n = write_command(&layout, next(sequence), signals, &mut payload).expect(FITS);
            in_frame(&payload[..n])
        }
    }
}

fn in_frame(payload: &[u8]) -> Vec<u8> {
    let mut bytes = [0; frame::MAX_FRAME];
    let n = frame::encode(payload, &mut bytes).expect(FITS);
    bytes[..n].to_vec()
}

fn next(sequence: &mut u8) -> u8 {
    let now = *sequence;
    *sequence = now.wrapping_add(1);
    now
}

/// Why encoding cannot fail: two signals of at most eight bytes each are far shorter than a frame.
const FITS: &str = "two motor signals fit into a frame";
