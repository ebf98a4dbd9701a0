//! The microcontroller's view of each sensor: when it is due, and the sample that it holds.

use alloc::boxed::Box;

use serde::{Deserialize, Serialize};

use crate::model::RobotSpec;
use crate::random::Stream;
use crate::schedule::Due;
use crate::sensor::noise::NoiseState;
use crate::sensor::{Effect, Measurement, Memory, Running, Sensor};
use crate::sound;
use crate::time::SimTime;
use crate::values::ReadingValues;

/// State of one sensor: its device, and the sample that it holds. In the order of its fields, which is that in which they are
/// saved, and from the start of a cache line: a crowd is in no processor's near memory, and so each sensor that sees nothing
/// takes three lines from a far one.
#[repr(C, align(64))]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Channel {
    pub(super) due: Due,
    pub(crate) memory: Memory,
    pub(super) noise: NoiseState,
    pub(crate) stream: Stream,
    /// If the device measures at its own pace. Seldom there, so it takes no room among what is looked at all the time.
    pub(super) running: Option<Box<Running>>,
    /// The last sample, one value a component; empty before the first.
    pub(crate) values: ReadingValues,
    /// The instant at which the microcontroller took it; of a device with a cable of its own, when it was measured.
    pub(crate) sampled_at: SimTime,
    /// The instant at which it was measured: earlier, if the device held it.
    pub(super) measured_at: SimTime,
    /// The time that the last read took the processor, in nanoseconds.
    pub(super) took_ns: u64,
    /// In no frame yet: the readability state of §3.2.1.
    pub(super) fresh: bool,
    pub(crate) samples: u64,
}

impl Channel {
    pub(super) fn new(spec: &RobotSpec, sensor: &Sensor, seed: u64, noise: bool) -> Self {
        // The differences between specimens have a stream of their own, so that the noise does not depend on them.
        let specimen = &mut Stream::of(seed, &[&spec.name, "/", &sensor.name, ":specimen"]);
        let due = if sensor.is_on_wire() && spec.chip.is_none() {
            sensor.schedule.start()
        } else {
            Due { next: SimTime::NEVER, missed: 0 }
        };
        Self {
            due,
            noise: sensor.noise.start(sensor.encodings.len(), specimen),
            running: sensor.own_clock.as_ref().map(|clock| Box::new(Running::start(clock, specimen, noise))),
            memory: sensor.device.remember(&spec.start.pose, specimen),
            stream: Stream::of(seed, &[&spec.name, "/", &sensor.name]),
            values: ReadingValues::new(),
            sampled_at: SimTime::ZERO,
            measured_at: SimTime::ZERO,
            took_ns: 0,
            fresh: false,
            samples: 0,
        }
    }

    /// Whether this channel may have become what `other` is at `now`: the device remembers what its kind does, and a
    /// sample has all of its values.
    pub(super) fn may_become(&self, sensor: &Sensor, other: &Self, now: SimTime) -> bool {
        let has_sample = other.fresh || other.samples > 0;
        let values = other.values.len();
        let running = match (&other.running, &sensor.own_clock) {
            (Some(running), Some(clock)) => running.is_sound(&sensor.device, clock, now),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        running
            && other.memory.is_sound(&self.memory)
            && self.noise.may_become(&other.noise)
            && other.due.is_sound()
            && (sensor.is_on_wire() || other.due.next == SimTime::NEVER)
            && (values == sensor.encodings.len() || (values == 0 && !has_sample))
            && sound::numbers(other.values.iter().copied())
            && [other.samples, other.took_ns].into_iter().all(sound::count)
            && other.stream.is_sound()
    }

    /// Takes a reading: of the device now, or of what it holds.
    pub(super) fn read(&mut self, sensor: &Sensor, at: &Measurement<'_>) -> Effect {
        if self.values.len() != sensor.encodings.len() {
            self.values.resize(sensor.encodings.len(), 0.0);
        }
        if let Some(running) = &self.running {
            match running.held() {
                Some(held) => {
                    self.values.copy_from_slice(&held.values);
                    self.measured_at = held.truly_at;
                }
                None => {
                    sensor.device.unmeasured(&mut self.values);
                    self.measured_at = at.now;
                }
            }
            return Effect::default();
        }
        let effect = sensor.device.read(at, &mut self.memory, &mut self.stream, &mut self.values);
        sensor.disturb(at.noise, &mut self.noise, at.now, &mut self.values, &mut self.stream);
        self.measured_at = at.now;
        effect
    }

    /// Whether the device is a switch that was pressed at the last read.
    pub(super) fn is_pressed(&self) -> bool {
        matches!(&self.memory, Memory::Touch(contact) if contact.is_pressed())
    }

    /// Reads that fell due while the processor was busy and were left out.
    pub(crate) fn missed(&self) -> u64 {
        self.due.missed
    }
}
