//! The state of a robot.
//!
//! The events on it within a tick are in `advance`, the brain's writing in `brain_end`, its comparison with the
//! stated one in `writes`, the control cycles in `cycles`, and the cables of sensors' own in `ports`.

mod advance;
mod brain_end;
mod chip;
mod cycles;
mod dead_time;
mod measurement;
mod motion;
mod onboard;
mod ports;
mod recorder;
mod within;
mod writes;

use alloc::boxed::Box;
use alloc::vec::Vec;

use baudbot_geometry::Pose;
use serde::{Deserialize, Serialize};

pub use brain_end::Written;
use chip::ChipState;
pub use cycles::Cycles;
pub(crate) use recorder::Recorder;
pub use writes::Exceptions;
use writes::WriteWatch;

use crate::actuator::ActuatorState;
use crate::battery::{Battery, BatteryState};
use crate::collision::Partner;
use crate::drive::{Motion, Wheels};
use crate::laptop::Laptop;
use crate::link::{Direction, Line, Link};
use crate::microcontroller::Microcontroller;
use crate::model::{RobotSpec, Start};
use crate::motor::{DelayLine, NoiseState};
use crate::optional::optional_parts;
use crate::random::Stream;
use crate::scene::{Ping, Scene};
use crate::sensor::dialogue::{DialogueState, Dialogues};
use crate::sensor::port::PortState;
use crate::time::SimTime;

/// The state of a robot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Robot {
    pub(crate) motion: Motion,
    /// The motor signals that the microcontroller gives. Behind a dead time the motors have older ones:
    /// [`motor_signals`](Self::motor_signals).
    pub(crate) signals: Wheels,
    pub(crate) motor_noise: NoiseState,
    /// Ran into something in the last tick.
    pub(crate) collided: bool,
    /// The robot's obstacles since there was last some room around it.
    pub(crate) contacts: Vec<Partner>,
    pub(crate) microcontroller: Microcontroller,
    pub(crate) uplink: Line,
    pub(crate) downlink: Line,
    pub(crate) laptop: Laptop,
    /// The cables of the sensors that have their own, in their order.
    pub(crate) ports: Vec<PortState>,
    pub(crate) actuators: Vec<ActuatorState>,
    pub(crate) parts: OptionalParts,
    /// The pulse that it sent in this tick, and the one that others receive, which is of the last tick.
    pub(crate) pings: [Option<Ping>; 2],
    /// The instant at which the last command was obeyed.
    pub(crate) commanded_at: SimTime,
    pub(crate) counters: RobotCounters,
    pub(crate) cycles: Cycles,
    #[serde(skip)]
    pub(crate) writes: WriteWatch,
    #[serde(skip)]
    pub(crate) recorder: Recorder,
    /// Memory of a message that is over, for the next one.
    #[serde(skip)]
    spare: Vec<(usize, SimTime)>,
}

/// Parts of the state that few robots have.
#[derive(Clone, Debug, Default)]
pub(crate) struct OptionalParts {
    pub(crate) battery: Option<BatteryState>,
    /// The signals under way to motors with a dead time.
    pub(crate) delay_line: Option<Box<DelayLine>>,
    /// The dialogues with its sensors.
    pub(crate) dialogues: Option<Dialogues>,
    /// The chip that runs its program.
    pub(crate) chip: Option<Box<ChipState>>,
    /// The time, in nanoseconds, for which the robot has been kept from sliding on.
    pub(crate) standing_ns: Option<u64>,
    /// The impulses of all contacts so far on its front and on its back, in N s, if a sensor feels them.
    pub(crate) impulses_n_s: Option<[f64; 2]>,
    /// The currents in the windings of DC motors with an inductance, in A.
    pub(crate) currents_a: Option<Wheels>,
}

optional_parts!(OptionalParts {
    battery,
    delay_line,
    dialogues,
    chip,
    standing_ns,
    impulses_n_s,
    currents_a
});

/// The tick in which a robot is advanced, with the scene as it is at its start.
#[derive(Clone, Copy)]
pub(crate) struct Tick<'a> {
    pub(crate) scene: &'a Scene<'a>,
    /// Whether sensors are noisy.
    pub(crate) noise: bool,
    pub(crate) start: SimTime,
    pub(crate) end: SimTime,
    /// Substeps in it.
    pub(crate) substeps: u32,
}

/// The counters of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotCounters {
    /// Times that it ran into something.
    pub collisions: u64,
    /// Distance that its centre has travelled, in metres, forwards and backwards added.
    pub distance_m: f64,
    /// Steps that its brain could take.
    pub turns: u64,
}

impl Robot {
    /// The bytes of what is not serialised: its timeline, when bytes have arrived, and the truth about its readings.
    pub(crate) fn unsaved_bytes(&self) -> usize {
        let ports = self.ports.iter().map(|port| port.instants.len()).sum::<usize>();
        self.recorder.timeline.heap_bytes()
            + (self.laptop.instants.len() + ports) * size_of::<SimTime>()
            + self.laptop.truth.heap_bytes(self.laptop.readings.len())
    }

    /// The present state, without its chip, and of its timeline only how many events there were.
    pub(crate) fn as_seen(&mut self) -> Self {
        let (chip, recorder) = (self.parts.chip.take(), core::mem::take(&mut self.recorder));
        let mut seen = self.clone();
        seen.recorder.timeline = recorder.timeline.emptied();
        (self.parts.chip, self.recorder) = (chip, recorder);
        seen
    }

    pub(crate) fn new(spec: &RobotSpec, seed: u64, noise: bool) -> Self {
        Self {
            motion: started(spec),
            signals: Wheels::default(),
            motor_noise: NoiseState::new(
                &spec.drive.motor_noise,
                Stream::of(seed, &[&spec.name, "/motors:noise"]),
            ),
            collided: false,
            contacts: Vec::new(),
            microcontroller: Microcontroller::new(spec, seed, noise),
            uplink: Line::up(&spec.link, seed, &[&spec.name, "/link:up"]),
            downlink: Line::down(&spec.link, seed, &[&spec.name, "/link:down"]),
            laptop: Laptop::new(spec.sensors.len(), &spec.firmware),
            ports: spec
                .sensors
                .ports()
                .iter()
                .map(|&i| PortState::new(&spec.sensors[i], seed, &spec.name))
                .collect(),
            actuators: spec.actuators.iter().map(|_| ActuatorState::default()).collect(),
            parts: OptionalParts {
                battery: spec.battery.as_ref().map(Battery::at_start),
                delay_line: (spec.dead_time_ns > 0).then(Box::default),
                dialogues: dialogues(spec, seed),
                chip: spec.chip.as_ref().map(|chip| Box::new(ChipState::new(chip, spec))),
                standing_ns: None,
                currents_a: spec.drive.motor.has_windings().then(Wheels::default),
                impulses_n_s: spec.sensors.feel_contacts().then_some([0.0; 2]),
            },
            pings: [None; 2],
            commanded_at: SimTime::ZERO,
            counters: RobotCounters::default(),
            cycles: Cycles::default(),
            writes: WriteWatch::default(),
            recorder: Recorder::default(),
            spare: Vec::new(),
        }
    }

    /// A person puts the robot somewhere else.
    pub(crate) fn put_down(&mut self, spec: &RobotSpec, pose: Pose) {
        self.motion.pose = pose;
        self.motion.turn_rate_rad_s = 0.0;
        self.motion.acceleration_m_s2 = 0.0;
        spec.drive.halt(&mut self.motion);
        self.contacts.clear();
        self.collided = false;
        self.microcontroller.lift();
    }

    /// The cable to its brain is one that can be out.
    pub(crate) fn watch_outages(&mut self, link: &Link, seed: u64, name: &str) {
        self.uplink.watch_outages(link, seed, &[name, "/link:up"], Direction::Up);
        self.downlink.watch_outages(link, seed, &[name, "/link:down"], Direction::Down);
    }

    /// Keeps the last so many bytes that come over each of its cables, each way, from now on.
    pub(crate) fn keep_tape(&mut self, bytes: usize) {
        let ports = self.ports.iter_mut().map(|port| &mut port.line);
        let dialogues =
            self.parts.dialogues.iter_mut().flatten().flatten().map(|dialogue| &mut dialogue.down);
        let own = [&mut self.uplink, &mut self.downlink];
        own.into_iter().chain(ports).chain(dialogues).for_each(|line| line.keep_tape(bytes));
    }

    /// Keeps the edges on the pins of its chip, from now on, or no longer does.
    pub(crate) fn keep_edges(&mut self, keep: bool) {
        if let Some(chip) = &mut self.parts.chip {
            chip.keep_edges(keep);
        }
    }

    /// Counts the rounds of the main loop of its chip's program, from now on, or no longer does.
    pub(crate) fn keep_rounds(&mut self, keep: bool) {
        if let Some(chip) = &mut self.parts.chip {
            chip.keep_rounds(keep);
        }
    }

    /// The microcontroller is reset at `now`: it begins anew after the wait of its bootloader, which is in `spec`.
    pub(crate) fn reset_board(&mut self, spec: &RobotSpec, now: SimTime) {
        self.lay_down_command(spec);
        self.downlink.lose_before(&spec.link, now);
        self.microcontroller.reset(spec, now);
        if let Some(chip) = &mut self.parts.chip {
            chip.reset(now, SimTime::from_ns(spec.processor.bootloader_ns), &spec.link);
        }
    }

    /// The cable to its brain has another rate from now on.
    pub(crate) fn begin_bursts(&mut self, link: &Link) {
        if let Some(chip) = &mut self.parts.chip {
            chip.set_rate(link);
        }
        self.uplink.begin_burst();
        self.downlink.begin_burst();
    }
}

/// The motion with which a robot starts.
fn started(spec: &RobotSpec) -> Motion {
    let Start { pose, speed_m_s, turn_rate_rad_s, wheels_at_rest } = spec.start;
    let mut motion = spec.drive.place(pose, speed_m_s, turn_rate_rad_s);
    if wheels_at_rest {
        motion.wheel_speed_rad_s = Wheels::default();
    }
    motion
}

/// Whether each port is a dialogue; nothing if none is.
fn dialogues(spec: &RobotSpec, seed: u64) -> Option<Dialogues> {
    let dialogue = |&i: &usize| {
        let sensor = &spec.sensors[i];
        DialogueState::new(sensor.port.as_ref()?, seed, &[&spec.name, "/", &sensor.name, ":port:down"])
    };
    let all: Dialogues = spec.sensors.ports().iter().map(dialogue).collect();
    all.iter().any(Option::is_some).then_some(all)
}
