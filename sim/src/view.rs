//! What may be seen of a robot: the truth for observers, and what its brain may have.

use crate::drive::{Motion, Wheels};
use crate::laptop::{Freshness, Reading};
use crate::link::LineCounters;
use crate::robot::{Robot, RobotCounters, RobotSpec};
use crate::time::SimTime;

/// A look at one robot.
#[derive(Clone, Copy, Debug)]
pub struct RobotView<'a> {
    spec: &'a RobotSpec,
    state: &'a Robot,
}

/// What a sensor did and holds.
#[derive(Clone, Copy, Debug)]
pub struct SensorView<'a> {
    /// The last sample, before quantisation, one value a component; empty before the first.
    pub sample: &'a [f64],
    /// When it was taken.
    pub sampled_at: SimTime,
    /// Samples taken so far.
    pub samples: u64,
    /// Samples that fell due while the microcontroller was busy, and were left out.
    pub missed: u64,
    /// How fresh its readings were for the brain.
    pub freshness: Freshness,
}

impl<'a> RobotView<'a> {
    pub(crate) fn new(spec: &'a RobotSpec, state: &'a Robot) -> Self {
        Self { spec, state }
    }

    /// What the robot is.
    pub fn spec(&self) -> &'a RobotSpec {
        self.spec
    }

    /// The truth about its motion: for observers, never for its brain.
    pub fn motion(&self) -> &'a Motion {
        &self.state.motion
    }

    /// The motor signals in force in the last step.
    pub fn signals(&self) -> Wheels {
        self.state.signals
    }

    /// Whether it ran into something in the last tick.
    pub fn collided(&self) -> bool {
        self.state.collided
    }

    /// For the brain: the bytes that arrived at its port since its last step.
    pub fn unread(&self) -> &'a [u8] {
        &self.state.laptop.unread
    }

    /// For the brain: the last reading of each sensor that arrived, in the order of the wire.
    pub fn readings(&self) -> &'a [Reading] {
        &self.state.laptop.readings
    }

    /// Each sensor's truth, in the order of the wire.
    pub fn sensors(&self) -> impl ExactSizeIterator<Item = SensorView<'a>> {
        let freshness = &self.state.laptop.freshness;
        self.state.microcontroller.channels().iter().enumerate().map(|(i, channel)| SensorView {
            sample: &channel.values,
            sampled_at: channel.sampled_at,
            samples: channel.samples,
            missed: channel.missed(),
            freshness: freshness[i],
        })
    }

    /// What happened to it so far.
    pub fn counters(&self) -> &'a RobotCounters {
        &self.state.counters
    }

    /// Commands that its microcontroller obeyed.
    pub fn commands(&self) -> u64 {
        self.state.microcontroller.commands
    }

    /// Frames of readings that fell due while the microcontroller was busy, and were left out.
    pub fn frames_missed(&self) -> u64 {
        self.state.microcontroller.frames_missed()
    }

    /// The line from the microcontroller to the laptop.
    pub fn uplink(&self) -> &'a LineCounters {
        &self.state.uplink.counters
    }

    /// The line from the laptop to the microcontroller.
    pub fn downlink(&self) -> &'a LineCounters {
        &self.state.downlink.counters
    }
}
