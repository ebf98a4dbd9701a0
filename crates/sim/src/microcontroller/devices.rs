//! Devices with a clock of their own, whose values the microcontroller finds or which go past it.

use super::{Channel, Microcontroller};
use crate::model::RobotSpec;
use crate::sensor::{Event, Measurement, Parts, Sensor};
use crate::time::SimTime;

impl Microcontroller {
    /// The next event of the device of sensor `i`, which has an own clock, and its instant.
    pub(crate) fn next_of_own(&self, i: usize, sensor: &Sensor) -> (SimTime, Event) {
        let running = self.channels[i].running.as_ref();
        running.map_or((SimTime::NEVER, Event::Output), |running| running.next(&sensor.device))
    }

    /// The device of sensor `i` measures, at an instant of its own clock.
    pub(crate) fn measure(&mut self, spec: &RobotSpec, i: usize, at: &Measurement<'_>) {
        let sensor = &spec.sensors[i];
        let Channel { running, memory, noise, stream, .. } = &mut self.channels[i];
        let (Some(running), Some(clock)) = (running, &sensor.own_clock) else { return };
        let effect = spec.fault_effect(i, at.now);
        running.measure(sensor, clock, at, Parts { memory, noise, stream }, effect);
    }

    /// The instant at which the measurement of sensor `i` began that comes to its output next.
    pub(crate) fn pending_since(&self, i: usize) -> Option<SimTime> {
        self.channels[i].running.as_ref()?.pending_since()
    }

    /// Moves the measurement of sensor `i`'s device to its output. If it has a cable of its own, the answer is its
    /// message: the values, the instant of the measurement in it, and the true one.
    pub(crate) fn output(&mut self, i: usize, sensor: &Sensor) -> Option<(&[f64], SimTime, SimTime)> {
        let channel = &mut self.channels[i];
        let held = channel.running.as_mut()?.output()?;
        if sensor.is_on_wire() {
            return None;
        }
        channel.values.clear();
        channel.values.extend_from_slice(&held.values);
        (channel.sampled_at, channel.measured_at) = (held.measured_at, held.truly_at);
        channel.samples += 1;
        Some((&channel.values, channel.sampled_at, channel.measured_at))
    }

    /// The newest measurement of sensor `i`, which has a cable of its own, as [`output`](Self::output) gave it.
    pub(crate) fn newest(&self, i: usize) -> Option<(&[f64], SimTime, SimTime)> {
        let channel = self.channels.get(i).filter(|channel| channel.samples > 0)?;
        Some((&channel.values, channel.sampled_at, channel.measured_at))
    }

    /// A measurement of sensor `i` could not be sent, because its cable was still taken.
    pub(crate) fn leave_out(&mut self, i: usize) {
        self.channels[i].due.missed += 1;
    }
}
