//! A robot: what it is, and the state it is in.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Point, Pose};
use serde::{Deserialize, Serialize};

use crate::actuator::{Actuator, ActuatorState};
use crate::arena::Look;
use crate::battery::{Battery, BatteryState};
use crate::collision::Partner;
use crate::drive::{Drive, Motion, Wheels};
use crate::firmware::Firmware;
use crate::laptop::Laptop;
use crate::link::{Line, Link};
use crate::microcontroller::{Microcontroller, Order, Processor, Task};
use crate::motor::NoiseState;
use crate::movable::Form;
use crate::port::PortState;
use crate::random::Stream;
use crate::scene::{Ping, Scene};
use crate::sensor::{Event, Measurement, Sensor};
use crate::time::SimTime;

/// What a robot is.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotSpec {
    /// Unique in its world.
    pub name: String,
    /// Where and how it starts.
    pub start: Start,
    /// Body, wheels and motors.
    pub drive: Drive,
    /// Corners of the body in the robot's frame, in metres; none if it is a disc. The collision geometry of §3.2.5.
    pub outline: Vec<Point>,
    /// What it looks like from the side.
    pub look: Look,
    /// Largest motor signal that a brain may ask for; `None` means any, as in ARSim.
    pub signal_limit: Option<f64>,
    /// Actuators besides the wheels, in the order of the wire.
    pub actuators: Vec<Actuator>,
    /// What feeds it, if that can run out.
    pub battery: Option<Battery>,
    /// How full that is at the start, in [0, 1].
    pub charge: f64,
    /// Motors stand still if no command comes for so long, in nanoseconds.
    pub command_timeout_ns: Option<u64>,
    /// Those that the microcontroller reads, in the order of the wire; then those with a cable of their own.
    pub sensors: Vec<Sensor>,
    /// The sensors that measure at their own pace, by their places.
    pub(crate) own_clocks: Vec<usize>,
    /// The sensors with a cable of their own, by their places.
    pub(crate) ports: Vec<usize>,
    /// What the microcontroller's tasks cost.
    pub processor: Processor,
    /// What it says on its wire.
    pub firmware: Firmware,
    /// The cable to the brain.
    pub link: Link,
    /// How long a brain thinks that does not say, in nanoseconds.
    pub thinking_ns: u64,
    /// How many operations a brain on board thinks, if the scenario says it so.
    pub brain_operations: Option<u64>,
    /// Memory that a brain on board needs for its variables, in bytes, if the scenario says.
    pub brain_memory_bytes: Option<u64>,
}

impl RobotSpec {
    /// Whether its brain is the microcontroller's program: then nothing is framed and nothing received.
    pub fn is_onboard(&self) -> bool {
        matches!(self.link, Link::Onboard)
    }

    /// The shape of its body.
    pub(crate) fn form(&self) -> Form<'_> {
        Form::of(&self.outline, self.drive.radius_m)
    }
}

/// Where and how a robot starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// World from robot.
    pub pose: Pose,
    /// Speed along the heading, in m/s.
    pub speed_m_s: f64,
    /// In rad/s.
    pub turn_rate_rad_s: f64,
    /// The motors do not see the start speed in the first step: ARSim's quirk.
    pub wheels_at_rest: bool,
}

/// The state of a robot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Robot {
    pub(crate) motion: Motion,
    /// The motor signals in force.
    pub(crate) signals: Wheels,
    pub(crate) motor_noise: NoiseState,
    /// Ran into something in the last tick.
    pub(crate) collided: bool,
    /// What it ran into since there was last some room around it.
    pub(crate) contacts: Vec<Partner>,
    pub(crate) microcontroller: Microcontroller,
    pub(crate) uplink: Line,
    pub(crate) downlink: Line,
    pub(crate) laptop: Laptop,
    /// The cables of the sensors that have their own, in their order.
    pub(crate) ports: Vec<PortState>,
    pub(crate) actuators: Vec<ActuatorState>,
    pub(crate) battery: Option<BatteryState>,
    /// The pulse that it sent in this tick, and the one that others hear, which is of the last tick.
    pub(crate) pings: [Option<Ping>; 2],
    /// When the last command was obeyed.
    pub(crate) commanded_at: SimTime,
    pub(crate) counters: RobotCounters,
}

/// The tick in which a robot is advanced, with the scene as it is at its start.
#[derive(Clone, Copy)]
pub(crate) struct Moment<'a> {
    pub(crate) scene: &'a Scene<'a>,
    /// Whether sensors are noisy.
    pub(crate) noise: bool,
    pub(crate) start: SimTime,
    pub(crate) end: SimTime,
}

/// What comes next on a robot.
enum Next {
    /// A device with an own clock.
    Device(usize, Event),
    /// The microcontroller.
    Task(Task),
}

/// What happened to a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotCounters {
    /// Times that it ran into something.
    pub collisions: u64,
    /// Way of its centre, in metres, forwards and backwards added.
    pub distance_m: f64,
    /// Steps that its brain could take.
    pub turns: u64,
}

impl Robot {
    pub(crate) fn new(spec: &RobotSpec, seed: u64, noise: bool) -> Self {
        let name = |part: &str| format!("{}/{part}", spec.name);
        let Start { pose, speed_m_s, turn_rate_rad_s, wheels_at_rest } = spec.start;
        let mut motion = spec.drive.place(pose, speed_m_s, turn_rate_rad_s);
        if wheels_at_rest {
            motion.wheel_speed_rad_s = Wheels::default();
        }
        Self {
            motion,
            signals: Wheels::default(),
            motor_noise: NoiseState::new(&spec.drive.motor_noise, Stream::new(seed, &name("motors:noise"))),
            collided: false,
            contacts: Vec::new(),
            microcontroller: Microcontroller::new(spec, seed, noise),
            uplink: Line::up(&spec.link, seed, &name("link:up")),
            downlink: Line::down(&spec.link, seed, &name("link:down")),
            laptop: Laptop::new(spec.sensors.len(), &spec.firmware),
            ports: spec.ports.iter().map(|&i| PortState::new(&spec.sensors[i], seed, &spec.name)).collect(),
            actuators: spec.actuators.iter().map(|_| ActuatorState::default()).collect(),
            battery: spec.battery.as_ref().map(|battery| battery.charged_to(spec.charge)),
            pings: [None; 2],
            commanded_at: SimTime::ZERO,
            counters: RobotCounters::default(),
        }
    }

    /// The brain steps at `at`: it has now been given all that arrived.
    pub(crate) fn hand_over(&mut self, at: SimTime) {
        self.laptop.hand_over(at);
        for port in &mut self.ports {
            port.unread.clear();
        }
    }

    /// Runs the timeline of microcontroller and link through all that happens before `until`. With
    /// `earliest`, stops when the brain can step, which is when a message has arrived and `earliest` is
    /// reached, and says when that is; what happens at that very instant has then happened.
    pub(crate) fn advance(
        &mut self,
        spec: &RobotSpec,
        moment: &Moment<'_>,
        until: SimTime,
        earliest: Option<SimTime>,
    ) -> Option<SimTime> {
        let mut step = earliest.filter(|_| self.laptop.has_message);
        // Bytes that arrive at the laptop change nothing on the robot.
        let mut on_robot = self.next_on_robot(spec);
        loop {
            let end = step.map_or(until, |at| at + 1);
            let (arrival, port) = self.next_byte(spec);
            if on_robot.0.min(arrival) >= end {
                return step;
            }
            if on_robot.0 <= arrival {
                let (now, next) = on_robot;
                match next {
                    Next::Device(i, event) => self.run_device(spec, moment, now, (i, event)),
                    Next::Task(task) => self.run(spec, moment, now, task),
                }
                on_robot = self.next_on_robot(spec);
                continue;
            }
            self.hear(spec, arrival, port);
            if step.is_none() && self.laptop.has_message {
                step = earliest.map(|earliest| earliest.max(arrival));
            }
        }
    }

    /// When the next byte arrives at the laptop, and on which sensor's cable, if it is not the microcontroller's.
    fn next_byte(&self, spec: &RobotSpec) -> (SimTime, Option<usize>) {
        let mut next = (self.uplink.arrival(&spec.link), None);
        for (k, (port, &i)) in self.ports.iter().zip(&spec.ports).enumerate() {
            let arrival = port.arrival(&spec.sensors[i]);
            if arrival < next.0 {
                next = (arrival, Some(k));
            }
        }
        next
    }

    /// What comes next on the robot, and when. At one instant devices come first, so that the microcontroller finds
    /// what is new; and it comes before the laptop, so that what it sends over an ideal link arrives at the same
    /// instant.
    fn next_on_robot(&self, spec: &RobotSpec) -> (SimTime, Next) {
        let (start, task) = self.microcontroller.next(&spec.link, &self.downlink);
        let mut next = (start, Next::Task(task));
        for &i in &spec.own_clocks {
            let (at, event) = self.microcontroller.next_of_own(i, &spec.sensors[i]);
            if at <= next.0 && !(at == next.0 && matches!(next.1, Next::Device(..))) {
                next = (at, Next::Device(i, event));
            }
        }
        next
    }

    fn run(&mut self, spec: &RobotSpec, moment: &Moment<'_>, now: SimTime, task: Task) {
        match task {
            Task::Acquire(i) => {
                let Self { microcontroller, motion, actuators, battery, .. } = self;
                let at = measurement(spec, moment, now, (motion, actuators, battery.as_ref()));
                let ping = microcontroller.acquire(i, &spec.sensors[i], &at);
                self.pings[0] = ping.or(self.pings[0]);
            }
            Task::SendReadings => {
                self.uplink.claim_wire(&spec.link, now, &mut self.downlink);
                self.microcontroller.send_readings(spec, now, &mut self.uplink);
                self.downlink.leave_wire_to(&spec.link, &self.uplink);
            }
            Task::Receive => self.microcontroller.receive(spec, now, &mut self.downlink),
        }
    }

    fn run_device(
        &mut self,
        spec: &RobotSpec,
        moment: &Moment<'_>,
        now: SimTime,
        (i, event): (usize, Event),
    ) {
        let sensor = &spec.sensors[i];
        match event {
            Event::Measure => {
                let Self { microcontroller, motion, actuators, battery, .. } = self;
                let at = measurement(spec, moment, now, (motion, actuators, battery.as_ref()));
                microcontroller.measure(i, sensor, &at);
            }
            Event::Output => {
                let Some(output) = self.microcontroller.output(i, sensor) else { return };
                let Some(port) = &sensor.port else { return };
                let place = spec.ports.iter().position(|&other| other == i);
                let sent = place.is_some_and(|k| self.ports[k].send(sensor, port, i, now, output));
                if !sent {
                    self.microcontroller.leave_out(i);
                }
            }
        }
    }

    fn hear(&mut self, spec: &RobotSpec, now: SimTime, port: Option<usize>) {
        let Some(k) = port else {
            while let Some(arrival) = self.uplink.take(&spec.link, now) {
                self.laptop.receive(spec, arrival, &mut self.uplink);
            }
            return;
        };
        let i = spec.ports[k];
        while let Some(arrival) = self.ports[k].take(&spec.sensors[i], now) {
            self.laptop.receive_from_port(spec, i, arrival, &mut self.ports[k]);
        }
    }

    /// When a brain is done that thinks from `begun` to `until`: on board it waits for the processor first.
    pub(crate) fn think(&mut self, spec: &RobotSpec, begun: SimTime, until: SimTime) -> SimTime {
        match spec.link {
            Link::Onboard => self.microcontroller.think(begun, until.since(begun)),
            Link::Ideal | Link::Uart(_) | Link::Usb(_) => until,
        }
    }

    /// The brain writes to its port at `at`. What the laptop's driver has no room for is refused.
    pub(crate) fn write(&mut self, spec: &RobotSpec, at: SimTime, bytes: &[u8]) {
        let room = spec.link.laptop_buffer().saturating_sub(self.downlink.waiting(&spec.link, at));
        let taken = bytes.len().min(room);
        self.downlink.counters.refused_bytes += (bytes.len() - taken) as u64;
        self.downlink.send(&spec.link, at, &bytes[..taken]);
    }

    /// The actuators take up what has been commanded by `now`.
    pub(crate) fn take_up(&mut self, spec: &RobotSpec, now: SimTime) {
        let until = spec.drive.motor.obeys_until(now);
        if let Some(Order { at, signals, others }) = self.microcontroller.order_at(until) {
            (self.signals, self.commanded_at) = (signals, at);
            for (actuator, signal) in self.actuators.iter_mut().zip(others) {
                actuator.signal = signal;
            }
        }
        if spec.command_timeout_ns.is_some_and(|timeout| now.since(self.commanded_at) >= timeout) {
            self.signals = Wheels::default();
        }
    }
}

fn measurement<'a>(
    robot: &'a RobotSpec,
    moment: &Moment<'a>,
    now: SimTime,
    (motion, actuators, battery): (&'a Motion, &'a [ActuatorState], Option<&'a BatteryState>),
) -> Measurement<'a> {
    Measurement {
        scene: moment.scene,
        robot,
        motion,
        actuators,
        battery,
        noise: moment.noise,
        now,
        tick_start: moment.start,
        tick_end: moment.end,
    }
}
