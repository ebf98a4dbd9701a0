//! The laptop's end of a brain's ports: what a brain writes is checked when it comes, and becomes a message when the world
//! takes it.

use std::sync::Arc;

use baudbot_sim::drive::Wheels;
use baudbot_sim::link::Link;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Scenario, SimTime, Written};
use baudbot_wire::codec::Pace;
use baudbot_wire::frame::MAX_FRAME;
use tonic::Status;

/// Most bytes that one Step may write to one port.
const MAX_WRITE: usize = 64 << 10;

/// Longest thinking time that a brain may declare: an hour.
const MAX_THINKING_NS: u64 = 3_600_000_000_000;

/// The form of a brain's input and output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Readings and commands.
    Messages,
    /// Bytes of the wire.
    Raw,
    /// The same, as a serial port that passes them on, each at its instant.
    SerialPort,
}

impl Mode {
    /// Whether these are bytes of the wire.
    pub(crate) const fn is_raw(self) -> bool {
        match self {
            Self::Messages => false,
            Self::Raw | Self::SerialPort => true,
        }
    }
}

/// The content that a brain writes to one robot's port.
pub(crate) struct Write {
    /// Place of the robot in the stream.
    pub(crate) slot: usize,
    pub(crate) thinking: Thinking,
    pub(crate) output: Option<Output>,
    pub(crate) until: Option<Until>,
    /// A program has opened the serial port.
    pub(crate) opened: bool,
    /// Bytes for sensors on their own cables, by the sensors' places.
    pub(crate) ports: Vec<(usize, Vec<u8>)>,
}

/// The wish of a brain to be asked only when a message has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Until {
    /// The brain is asked nonetheless at its first step that is not before this instant.
    pub(crate) at_latest: Option<SimTime>,
}

/// The thinking time that a brain declares: as a time, or as operations of the processor on which it runs.
#[derive(Clone, Copy, Default)]
pub(crate) struct Thinking {
    pub(crate) ns: Option<u64>,
    pub(crate) operations: Option<u64>,
}

impl Thinking {
    /// The thinking time, in nanoseconds of simulated time. That of the scenario, if nothing is declared.
    pub(crate) fn on(&self, spec: &RobotSpec) -> u64 {
        let counted = self.operations.and_then(|operations| spec.processor.thinking_ns(operations));
        self.ns.or(counted).unwrap_or(spec.thinking_ns)
    }
}

/// The content that is written to a port.
pub(crate) enum Output {
    Raw(Vec<u8>),
    Command(Signals),
    Poll,
}

/// Signals for the wheels, and for the other actuators unless those keep theirs.
pub(crate) struct Signals {
    pub(crate) wheels: Wheels,
    pub(crate) others: Vec<f64>,
}

/// The ports of one stream, with which its Steps are checked.
pub(crate) struct Endpoint {
    scenario: Arc<Scenario>,
    robots: Vec<usize>,
    mode: Mode,
}

impl Endpoint {
    pub(crate) fn new(scenario: Arc<Scenario>, robots: Vec<usize>, mode: Mode) -> Self {
        Self { scenario, robots, mode }
    }

    /// Checks a Step.
    ///
    /// # Errors
    /// `INVALID_ARGUMENT` with the field that is wrong.
    pub(crate) fn check(&self, writes: &[Write]) -> Result<(), Status> {
        let mut seen = vec![false; self.robots.len()];
        for (i, write) in writes.iter().enumerate() {
            self.check_part(i, write)?;
            if std::mem::replace(&mut seen[write.slot], true) {
                let text = format!("step.robots[{i}].robot: {} is named twice", write.slot);
                return Err(Status::invalid_argument(text));
            }
        }
        Ok(())
    }

    /// Checks the part of a Step in this place.
    ///
    /// # Errors
    /// `INVALID_ARGUMENT` with the field that is wrong.
    pub(crate) fn check_part(&self, place: usize, write: &Write) -> Result<(), Status> {
        self.check_write(write).map_err(|(field, problem)| {
            Status::invalid_argument(format!("step.robots[{place}].{field}: {problem}"))
        })
    }

    fn check_write(&self, write: &Write) -> Result<(), Problem> {
        let Some(&robot) = self.robots.get(write.slot) else {
            let problem = format!("is {}, but this stream has {} robots", write.slot, self.robots.len());
            return Err(("robot", problem));
        };
        let spec = &self.scenario.robots[robot];
        check_thinking(spec, write.thinking)?;
        if write.opened && self.mode != Mode::SerialPort {
            return Err(("opened", "only for serial ports; ask for `serial_port` in the Hello".into()));
        }
        self.check_ports(spec, &write.ports)?;
        match (&write.output, self.mode.is_raw()) {
            (None, _) => Ok(()),
            (Some(Output::Raw(bytes)), true) if bytes.len() <= MAX_WRITE => Ok(()),
            (Some(Output::Raw(bytes)), true) => {
                Err(("raw", format!("has {} bytes, the limit is {MAX_WRITE}", bytes.len())))
            }
            (Some(Output::Raw(_)), false) => {
                Err(("raw", "the stream is in MESSAGES mode; ask for RAW in the Hello".into()))
            }
            (Some(_), true) => Err(("output", "the stream is in RAW mode and takes only `raw`".into())),
            (Some(Output::Command(signals)), false) => check_signals(spec, signals),
            (Some(Output::Poll), false) => check_poll(spec),
        }
    }
}

impl Endpoint {
    fn check_ports(&self, spec: &RobotSpec, ports: &[(usize, Vec<u8>)]) -> Result<(), Problem> {
        if !ports.is_empty() && !self.mode.is_raw() {
            return Err(("ports", "the stream is in MESSAGES mode; ask for RAW in the Hello".into()));
        }
        for (sensor, bytes) in ports {
            if !spec.sensors.ports().contains(sensor) {
                let problem = format!("sensor {sensor} of `{}` has no cable of its own", spec.name);
                return Err(("ports.sensor", problem));
            }
            if bytes.len() > MAX_WRITE {
                return Err(("ports.data", format!("has {} bytes, the limit is {MAX_WRITE}", bytes.len())));
            }
        }
        Ok(())
    }
}

/// The field that is wrong, and the problem.
type Problem = (&'static str, String);

fn check_thinking(spec: &RobotSpec, thinking: Thinking) -> Result<(), Problem> {
    if thinking.ns.is_some_and(|ns| ns > MAX_THINKING_NS) {
        return Err(("thinking_ns", format!("must not exceed {MAX_THINKING_NS}")));
    }
    let Some(operations) = thinking.operations else { return Ok(()) };
    if thinking.ns.is_some() {
        return Err(("operations", "give either this or thinking_ns".into()));
    }
    if !matches!(spec.link, Link::Onboard) {
        let problem = format!("`{}` is not onboard: its brain runs on a laptop; use thinking_ns", spec.name);
        return Err(("operations", problem));
    }
    match spec.processor.thinking_ns(operations) {
        None => Err(("operations", format!("`{}` has no operations_per_s; use thinking_ns", spec.name))),
        Some(ns) if ns > MAX_THINKING_NS => {
            Err(("operations", format!("{operations} would take {ns} ns, the limit is {MAX_THINKING_NS}")))
        }
        Some(_) => Ok(()),
    }
}

fn check_signals(spec: &RobotSpec, Signals { wheels, others }: &Signals) -> Result<(), Problem> {
    let (count, expected) = (others.len(), spec.actuators.len());
    if count != 0 && count != expected {
        let problem = format!("has {count} signals, but `{}` has {expected} other actuators", spec.name);
        return Err(("command.other_signals", problem));
    }
    let wheels = [("command.left_signal", wheels.left), ("command.right_signal", wheels.right)];
    for (field, signal) in wheels.into_iter().chain(others.iter().map(|&s| ("command.other_signals", s))) {
        if !signal.is_finite() {
            return Err((field, format!("must be a finite number, is {signal}")));
        }
        if let Some(limit) = spec.signal_limit.filter(|limit| signal.abs() > *limit) {
            return Err((field, format!("must be between -{limit} and {limit}, is {signal}")));
        }
    }
    Ok(())
}

fn check_poll(spec: &RobotSpec) -> Result<(), Problem> {
    if spec.firmware.protocol.has_poll() {
        return Ok(());
    }
    Err(("poll", "the bare protocol has none; a command asks for readings".into()))
}

/// The writing end of a robot's port, where the server writes messages for its brain.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sender {
    /// The sequence number of the next message. The first one of a Create's, 0, has an opening before it.
    sequence: u8,
    /// Whether its brain writes bytes.
    raw: bool,
    /// The last signals of the actuators besides the wheels; a command without such signals repeats them.
    others: Vec<f64>,
}

impl Sender {
    /// A sender for a new brain, which writes bytes or messages, with these signals of the other actuators in force.
    pub(crate) fn new(others: impl Iterator<Item = f64>, raw: bool) -> Self {
        Self { sequence: 0, raw, others: others.collect() }
    }

    /// A sender as it was: the number of the next message, whether its brain writes bytes, and signals.
    pub(crate) fn from_parts(sequence: u8, raw: bool, others: Vec<f64>) -> Self {
        Self { sequence, raw, others }
    }

    /// The parts that [`from_parts`](Self::from_parts) makes it of.
    pub(crate) fn parts(&self) -> (u8, bool, &[f64]) {
        (self.sequence, self.raw, &self.others)
    }

    /// Whether its brain writes bytes.
    pub(crate) fn is_raw(&self) -> bool {
        self.raw
    }

    /// Gives the bytes for the port of an output that was checked.
    pub(crate) fn send(&mut self, spec: &RobotSpec, output: Option<Output>) -> Sent {
        match output {
            None => Sent::Bytes(self.wait(spec)),
            Some(Output::Raw(bytes)) => Sent::Bytes(bytes),
            Some(Output::Command(signals)) => self.command(spec, signals),
            // `check_poll` has refused it where there is none.
            Some(Output::Poll) => Sent::Bytes(self.poll(spec)),
        }
    }

    /// A brain of messages that is silent lets a robot that has to be opened know once that it is there.
    fn wait(&mut self, spec: &RobotSpec) -> Vec<u8> {
        let opens = !self.raw && spec.firmware.protocol.is_to_be_opened(self.sequence);
        if opens { self.poll(spec) } else { Vec::new() }
    }

    fn poll(&mut self, spec: &RobotSpec) -> Vec<u8> {
        let agreement = spec.firmware.agreement();
        written(|out| agreement.write_poll(&mut self.sequence, out).unwrap_or(0))
    }

    fn command(&mut self, spec: &RobotSpec, Signals { wheels, others }: Signals) -> Sent {
        if !others.is_empty() {
            self.others = others;
        }
        let protocol = spec.firmware.protocol;
        // A brain that writes bytes opens it by itself.
        let is_open = self.raw && protocol.pace() == Pace::Opened;
        let sequence = if is_open { 1 } else { protocol.count(&mut self.sequence) };
        Sent::Command { sequence, signals: Signals { wheels, others: self.others.clone() } }
    }
}

/// The bytes or the command for a robot's port.
pub(crate) enum Sent {
    Bytes(Vec<u8>),
    /// A command with a signal for each actuator. Its bytes are made only for a watcher.
    Command {
        /// The sequence number of the message, if the protocol has one.
        sequence: u8,
        signals: Signals,
    },
}

impl Sent {
    /// The writing in the form that the world takes.
    pub(crate) fn written(&self) -> Written<'_> {
        match self {
            Self::Bytes(bytes) => Written::Bytes(bytes),
            Self::Command { sequence, signals: Signals { wheels, others } } => {
                Written::Command { sequence: *sequence, wheels: *wheels, others }
            }
        }
    }

    /// The bytes on the wire of this robot.
    pub(crate) fn into_bytes(self, spec: &RobotSpec) -> Vec<u8> {
        let (sequence, Signals { wheels, others }) = match self {
            Self::Bytes(bytes) => return bytes,
            Self::Command { sequence, signals } => (sequence, signals),
        };
        let signals = [wheels.left, wheels.right].into_iter().chain(others);
        written(|out| spec.firmware.agreement().write_command(sequence, signals, out).expect(FITS))
    }
}

/// The bytes that `write` puts into a buffer for the longest message.
fn written(write: impl FnOnce(&mut [u8]) -> usize) -> Vec<u8> {
    let mut bytes = [0; MAX_FRAME];
    let len = write(&mut bytes);
    bytes[..len].to_vec()
}

/// The reason why encoding cannot fail: scenario files refuse robots whose commands are longer than a frame or have
/// no form in their protocol, and there are as many signals as the robot has motors and actuators.
const FITS: &str = "a robot's signals fit into a frame";
