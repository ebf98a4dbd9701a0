//! The timing of a robot's scenario, in the form in which the rest of the budget needs it: the cost of each task of
//! the microcontroller, and the length of each message.

use alloc::vec::Vec;

use baudbot_wire::codec::Pace;
use baudbot_wire::frame;

use baudbot_sim::Scenario;
use baudbot_sim::firmware::Mode;
use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::model::{RobotSpec, Writes};
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::{Device, OwnClock, Sensor};

use super::report::Thinking;

/// The least and the most of something, in nanoseconds or bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Range {
    pub(super) least: u64,
    pub(super) most: u64,
}

impl Range {
    const fn of([least, most]: [usize; 2]) -> Self {
        Self { least: least as u64, most: most as u64 }
    }

    pub(super) const fn middle(self) -> u64 {
        self.least + (self.most - self.least) / 2
    }

    pub(super) const fn width(self) -> u64 {
        self.most - self.least
    }
}

/// A robot and the step that it is held to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<'a> {
    pub(super) spec: &'a RobotSpec,
    /// Δt, in nanoseconds.
    pub(super) step_ns: u64,
    /// Whether chance decides when devices with clocks of their own begin.
    pub(super) noise: bool,
    /// The measured thinking time of its brain.
    pub(super) measured: Option<Thinking>,
}

impl<'a> Plan<'a> {
    /// The plan of a robot of a scenario.
    pub(super) fn of(scenario: &Scenario, spec: &'a RobotSpec) -> Self {
        Self { spec, step_ns: scenario.step_ns, noise: scenario.noise, measured: None }
    }

    /// The writing of the brain: as the scenario states, or in answer to messages only.
    pub(super) fn writes(&self) -> Writes {
        self.spec.writes.unwrap_or_default()
    }

    /// The most commands that its brain writes in a turn.
    pub(super) fn commands_in_a_turn(&self) -> u64 {
        self.writes().in_a_turn(self.step_ns)
    }

    /// The least time between two steps in which its brain writes, as far as it is the brain that sees to that.
    pub(super) fn pause_ns(&self) -> u64 {
        match self.writes() {
            Writes::OnMessage | Writes::EveryTick => 0,
            Writes::WhenFree => self.spec.command_time_ns(),
            Writes::AtMost(frequency) if self.commands_in_a_turn() == 1 => frequency.period_ns(),
            Writes::AtMost(_) => 0,
        }
    }

    /// The thinking time of the brain: as measured, or as in the scenario. On board it takes the processor as long as
    /// the scenario states.
    pub(super) fn thinking(&self) -> Thinking {
        let measured = self.measured.filter(|_| !self.spec.is_onboard());
        measured.unwrap_or_else(|| Thinking::exactly(self.spec.thinking_ns))
    }

    /// The least time from the arrival of a command's last byte until the command is obeyed: a receiver that is slower than
    /// the wire has other bytes before it.
    pub(super) fn least_obeying_ns(&self) -> u64 {
        let byte = self.receiving_ns();
        // A longer command need not take longer: its end may come with a later frame of USB.
        let commands = self.command_bytes();
        let least = (commands.least..=commands.most).map(|bytes| {
            let apart = self.spec.link.burst_ns(bytes) - self.spec.link.burst_ns(bytes.min(1));
            (bytes * byte).saturating_sub(apart).max(byte)
        });
        least.min().unwrap_or(byte) + self.spec.processor.obeying_ns
    }

    /// The sensors that the microcontroller reads; they are the first.
    pub(super) fn on_wire(&self) -> &'a [Sensor] {
        let wired = self.spec.firmware.layout().counts.len();
        self.spec.sensors.get(..wired).unwrap_or_default()
    }

    pub(super) fn polls(&self) -> bool {
        self.spec.firmware.mode == Mode::Poll
    }

    pub(super) fn has_ports(&self) -> bool {
        !self.spec.sensors.ports().is_empty()
    }

    /// Whether each message has all sensors, new or not.
    pub(super) fn repeats(&self) -> bool {
        self.spec.firmware.protocol.repeats()
    }

    /// The processor time of a read of a sensor.
    pub(super) fn read_ns(&self, sensor: &Sensor) -> Range {
        let most = sensor.device.longest_wait_ns();
        let wait = if sensor.own_clock.is_some() {
            Range::default()
        } else if let Device::Sonar(sonar) = &sensor.device {
            Range { least: sonar.holdoff_ns + sonar.echo_ns(sonar.min_m).min(sonar.timeout_ns), most }
        } else if let Device::Photoresistor(device) = &sensor.device {
            Range { least: device.unit_ns * u64::from(device.max_counts.min(1)), most }
        } else {
            Range { least: most, most }
        };
        Range { least: sensor.acquisition_ns + wait.least, most: sensor.acquisition_ns + wait.most }
    }

    /// Bytes on the wire of a message in which these sensors are new.
    pub(super) fn readings_bytes(&self, new: impl Fn(usize) -> bool) -> Range {
        if self.repeats() {
            return self.all_bytes();
        }
        let layout = self.spec.firmware.layout();
        let entry = |sensor: &Sensor| usize::from(layout.ages) + sample_bytes(sensor);
        let new = self.on_wire().iter().enumerate().filter(|(i, _)| new(*i));
        let entries: usize = new.map(|(_, sensor)| entry(sensor)).sum();
        Range::of(frame::encoded_len(HEADER_LEN + layout.mask_len() + entries))
    }

    /// Bytes on the wire of a command. A Khepera's request for readings goes over the wire while the command is
    /// confirmed.
    pub(super) fn command_bytes(&self) -> Range {
        Range::of(self.spec.firmware.agreement().command_len())
    }

    /// The usual length of a message: stuffing is counted as if it were needed, and of digits there are not often as
    /// many as there can be.
    pub(super) fn usual(&self, bytes: Range) -> u64 {
        if self.spec.firmware.protocol.pace() == Pace::Asked { bytes.middle() } else { bytes.most }
    }

    /// The time within which a cycle must be over, in nanoseconds.
    pub(super) fn deadline_ns(&self) -> u64 {
        match self.spec.deadline.on_late {
            Some(_) => self.spec.deadline.within_ns,
            None => self.step_ns,
        }
    }

    /// The least bytes that go up before the readings do: a Khepera's confirmation, and the positions of its wheels.
    pub(super) fn acknowledgement_bytes(&self) -> u64 {
        let preface = self.spec.firmware.agreement().preface();
        (preface.acknowledgement + preface.positions[0]) as u64
    }

    /// Bytes of a message with all readings.
    pub(super) fn all_bytes(&self) -> Range {
        Range::of(self.spec.firmware.agreement().readings_len())
    }

    /// The time of framing: it is counted for the longest frame that so much payload can have.
    pub(super) fn framing_ns(&self, message: Range) -> u64 {
        if self.spec.is_onboard() { 0 } else { message.most * self.spec.processor.framing_ns_per_byte }
    }

    /// The processor time for taking a byte from the receiver.
    pub(super) fn receiving_ns(&self) -> u64 {
        if self.spec.is_onboard() { 0 } else { self.spec.processor.receiving_ns_per_byte }
    }

    /// The processor time of a whole command.
    pub(super) fn command_ns(&self) -> u64 {
        self.command_bytes().most * self.receiving_ns() + self.spec.processor.obeying_ns
    }

    /// Time between two steps of the brain, at least, in the long run.
    pub(super) fn brain_ns(&self) -> u64 {
        self.step_ns.max(self.thinking().least_ns)
    }

    /// Time between two pulses of the motors, if they are servos.
    pub(super) fn pulse_ns(&self) -> u64 {
        match &self.spec.drive.motor {
            Motors::Servo(servo) => servo.frame_ns,
            Motors::Dc(_) | Motors::Velocity(_) | Motors::Stepper(_) => 0,
        }
    }

    /// The possible age of a device's value when it is read, if it has a clock of its own.
    pub(super) fn held_ns(&self, sensor: &Sensor) -> Range {
        let Some(clock) = &sensor.own_clock else { return Range::default() };
        let least = settling_ns(sensor, clock);
        let (spread, jitter) = if self.noise { (clock.spread_ns, clock.jitter_ns) } else { (0, 0) };
        Range { least, most: least + clock.period_ns + spread + jitter }
    }

    /// The sensors with a cable of their own, and what they are.
    pub(super) fn ports(&self) -> impl Iterator<Item = (usize, &'a Sensor, &'a OwnClock, &'a Link)> {
        self.spec.sensors.ports().iter().filter_map(|&i| {
            let sensor = &self.spec.sensors[i];
            Some((i, sensor, sensor.own_clock.as_ref()?, &sensor.port.as_ref()?.link))
        })
    }
}

/// Time from the beginning of a measurement until its value is at the output.
pub(super) fn settling_ns(sensor: &Sensor, clock: &OwnClock) -> u64 {
    let sweep_ns = if let Device::Laser(laser) = &sensor.device { laser.sweep_ns } else { 0 };
    sweep_ns + clock.latency_ns
}

/// The link without what is left to chance or to accident.
pub(super) fn calm(link: &Link) -> Link {
    let mut calm = link.clone();
    match &mut calm {
        Link::Ideal | Link::Onboard => {}
        Link::Uart(uart) => {
            uart.byte_error_rate = 0.0;
            uart.outages = Vec::new();
            uart.cuts = Vec::new();
            uart.error_bursts = Vec::new();
        }
        Link::Usb(usb) => {
            usb.outages = Vec::new();
            usb.cuts = Vec::new();
        }
    }
    calm
}

/// The adapter between the cable and the laptop.
pub(super) fn adapter(link: &Link) -> Adapter {
    match link {
        Link::Ideal | Link::Onboard | Link::Usb(_) => Adapter::None,
        Link::Uart(uart) => uart.adapter,
    }
}

/// The pause before the other side may speak, where both share the wire.
pub(super) fn turnaround_ns(link: &Link) -> Option<u64> {
    match link {
        Link::Ideal | Link::Onboard | Link::Usb(_) => None,
        Link::Uart(uart) => uart.turnaround_ns,
    }
}

/// Bytes of a sensor's values on the wire.
pub(super) fn sample_bytes(sensor: &Sensor) -> usize {
    sensor.encodings.iter().map(|encoding| encoding.len()).sum()
}

/// Kind, sequence number and time of a message of readings.
const HEADER_LEN: usize = 4;
