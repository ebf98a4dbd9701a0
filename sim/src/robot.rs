//! A robot: what it is, and the state it is in.

use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Pose};
use serde::{Deserialize, Serialize};

use crate::collision::Partner;
use crate::drive::{Drive, Motion, Wheels};
use crate::firmware::Firmware;
use crate::laptop::Laptop;
use crate::link::{Line, Link};
use crate::microcontroller::{Microcontroller, Processor, Task};
use crate::scene::Scene;
use crate::sensor::{Measurement, Sensor};
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
    /// Largest motor signal that a brain may ask for; `None` means any, as in ARSim.
    pub signal_limit: Option<f64>,
    /// In the order of the wire.
    pub sensors: Vec<Sensor>,
    /// What the microcontroller's tasks cost.
    pub processor: Processor,
    /// What it says on its wire.
    pub firmware: Firmware,
    /// The cable to the brain.
    pub link: Link,
    /// How long a brain thinks that does not say, in nanoseconds.
    pub thinking_ns: u64,
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
    /// Ran into something in the last tick.
    pub(crate) collided: bool,
    /// What it ran into since there was last some room around it.
    pub(crate) contacts: Vec<Partner>,
    pub(crate) microcontroller: Microcontroller,
    pub(crate) uplink: Line,
    pub(crate) downlink: Line,
    pub(crate) laptop: Laptop,
    pub(crate) counters: RobotCounters,
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
    pub(crate) fn new(spec: &RobotSpec, seed: u64) -> Self {
        let Start { pose, speed_m_s, turn_rate_rad_s, wheels_at_rest } = spec.start;
        let mut motion = spec.drive.place(pose, speed_m_s, turn_rate_rad_s);
        if wheels_at_rest {
            motion.wheel_speed_rad_s = Wheels::default();
        }
        Self {
            motion,
            signals: Wheels::default(),
            collided: false,
            contacts: Vec::new(),
            microcontroller: Microcontroller::new(spec, seed),
            uplink: Line::up(&spec.link, seed, &alloc::format!("{}/link:up", spec.name)),
            downlink: Line::down(&spec.link, seed, &alloc::format!("{}/link:down", spec.name)),
            laptop: Laptop::new(&spec.firmware),
            counters: RobotCounters::default(),
        }
    }

    /// The disc that the robot covers.
    pub(crate) fn disc(&self, spec: &RobotSpec) -> Circle {
        Circle { center: self.motion.pose.position, radius: spec.drive.radius_m }
    }

    /// Runs the timeline of microcontroller and link through all that happens before `until`. With
    /// `earliest`, stops when the brain can step, which is when a message has arrived and `earliest` is
    /// reached, and says when that is; what happens at that very instant has then happened.
    pub(crate) fn advance(
        &mut self,
        spec: &RobotSpec,
        scene: &Scene<'_>,
        noise: bool,
        until: SimTime,
        earliest: Option<SimTime>,
    ) -> Option<SimTime> {
        let mut step = earliest.filter(|_| self.laptop.has_message);
        loop {
            let end = step.map_or(until, |at| at + 1);
            let (start, task) = self.microcontroller.next(&spec.link, &self.downlink);
            let arrival = self.uplink.arrival(&spec.link);
            // The microcontroller goes first: what it sends at an instant over an ideal link arrives at it.
            if start <= arrival && start < end {
                self.run(spec, scene, noise, start, task);
            } else if arrival < end {
                self.hear(spec, arrival);
                if step.is_none() && self.laptop.has_message {
                    step = earliest.map(|earliest| earliest.max(arrival));
                }
            } else {
                return step;
            }
        }
    }

    fn run(&mut self, spec: &RobotSpec, scene: &Scene<'_>, noise: bool, now: SimTime, task: Task) {
        match task {
            Task::Acquire(i) => {
                let at = Measurement { scene, drive: &spec.drive, motion: &self.motion, noise };
                self.microcontroller.acquire(i, &spec.sensors[i], now, &at);
            }
            Task::SendReadings => {
                self.uplink.claim_wire(&spec.link, now, &mut self.downlink);
                self.microcontroller.send_readings(spec, now, &mut self.uplink);
                self.downlink.leave_wire_to(&spec.link, &self.uplink);
            }
            Task::Receive => self.microcontroller.receive(spec, now, &mut self.downlink),
        }
    }

    fn hear(&mut self, spec: &RobotSpec, now: SimTime) {
        while let Some(arrival) = self.uplink.take(&spec.link, now) {
            self.laptop.receive(spec, arrival, &mut self.uplink);
        }
    }

    /// The brain writes to its port at `at`. What the laptop's driver has no room for is refused.
    pub(crate) fn write(&mut self, spec: &RobotSpec, at: SimTime, bytes: &[u8]) {
        let room = spec.link.laptop_buffer().saturating_sub(self.downlink.waiting(&spec.link, at));
        let taken = bytes.len().min(room);
        self.downlink.counters.refused_bytes += (bytes.len() - taken) as u64;
        self.downlink.send(&spec.link, at, &bytes[..taken]);
    }
}
