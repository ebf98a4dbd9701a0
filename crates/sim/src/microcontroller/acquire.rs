//! Reading sensors.

use super::{Channel, Microcontroller};
use crate::fault::FaultEffect;
use crate::model::RobotSpec;
use crate::scene::Ping;
use crate::sensor::{Measurement, Sensor};
use crate::time::SimTime;

/// A sensor has been read.
pub(crate) struct Acquired {
    pub(crate) sensor: usize,
    /// Whether reads of it were left out before.
    pub(crate) has_missed: bool,
    /// The instant until which the processor is busy with it.
    pub(crate) until: SimTime,
    /// The pulse that the sensor sent, if others can receive it.
    pub(crate) ping: Option<Ping>,
}

/// The instant at which the first of these sensors is due, and which that is; never if there is none.
pub(super) fn first_due(channels: &[Channel]) -> (SimTime, usize) {
    let mut first = (SimTime::NEVER, 0);
    for (i, channel) in channels.iter().enumerate() {
        first = if channel.due.next < first.0 { (channel.due.next, i) } else { first };
    }
    first
}

impl Microcontroller {
    /// Reads sensor `first`, which is due, and those behind it that fell due at the same instant, as long as reading
    /// takes no time. `note` gets to know of each. Returns which comes next and when, if that is another of those:
    /// sensors come first at an instant, in their order.
    pub(crate) fn acquire<'a>(
        &mut self,
        spec: &'a RobotSpec,
        first: usize,
        at: &mut Measurement<'a>,
        note: impl FnMut(Acquired),
    ) -> Option<(SimTime, usize)> {
        let next = self.acquire_alike(spec, first, at, note);
        self.first_due = Some(first_due(&self.channels));
        next
    }

    /// Measures with sensor `i` now, for a program that asks. Gives the values and the pulse that it sent, if others
    /// can receive it.
    pub(crate) fn sense(
        &mut self,
        spec: &RobotSpec,
        i: usize,
        at: &Measurement<'_>,
    ) -> (&[f64], Option<Ping>) {
        let channel = &mut self.channels[i];
        let ping = channel.acquire(&spec.sensors[i], at, spec.fault_effect(i, at.now));
        (&channel.values, ping)
    }

    /// Whether a switch was pressed when it was last read, however it bounced.
    pub(crate) fn is_pressed(&self, i: usize) -> bool {
        self.channels.get(i).is_some_and(Channel::is_pressed)
    }

    fn acquire_alike<'a>(
        &mut self,
        spec: &'a RobotSpec,
        first: usize,
        at: &mut Measurement<'a>,
        mut note: impl FnMut(Acquired),
    ) -> Option<(SimTime, usize)> {
        let Self { channels, free_at, .. } = self;
        let (model, now) = (&*spec.model, at.now);
        // A device with a clock of its own may come in between.
        let is_one_by_one = !model.sensors.own_clocks().is_empty();
        let due = channels[first].due.next;
        for (i, channel) in channels.iter_mut().enumerate().skip(first) {
            if channel.due.next != due {
                continue;
            }
            if i > first {
                let start = due.max(*free_at);
                if start != now {
                    return Some((start, i));
                }
            }
            let sensor = &model.sensors[i];
            let missed = channel.due.serve(&sensor.schedule, now);
            at.near = model
                .sensors
                .sector(i)
                .zip(sensor.device.mount())
                .and_then(|(sector, mount)| at.scene.in_sector(sector, mount.height, &at.motion.pose));
            let ping = if model.faults.is_empty() && channel.sees_nothing(sensor, at) {
                channel.note_sample(sensor, now, 0);
                None
            } else {
                channel.acquire(sensor, at, spec.fault_effect(i, now))
            };
            *free_at = now + channel.took_ns;
            note(Acquired { sensor: i, has_missed: missed > 0, until: *free_at, ping });
            if is_one_by_one {
                return None;
            }
        }
        None
    }
}

impl Channel {
    /// Measures, if that is soon done: when the sensor's rays meet nothing, it reads 0 whatever its noise is, which is drawn.
    #[inline]
    fn sees_nothing(&mut self, sensor: &Sensor, at: &Measurement<'_>) -> bool {
        let Self { values, stream, running: None, measured_at, .. } = self else { return false };
        let [value] = &mut values[..] else { return false };
        let reads_0 =
            at.near.is_some_and(|near| near.is_clear()) && (!at.noise || sensor.noise.leaves_0(stream));
        if reads_0 {
            (*value, *measured_at) = (0.0, at.now);
        }
        reads_0
    }

    /// Takes a sample of a sensor with this fault; gives back the pulse that it sent, if others can receive it.
    #[inline(never)]
    fn acquire(&mut self, sensor: &Sensor, at: &Measurement<'_>, fault: Option<FaultEffect>) -> Option<Ping> {
        let sticks = self.samples > 0 && fault == Some(FaultEffect::Sticks);
        let stuck = sticks.then(|| (self.values.clone(), self.measured_at));
        let effect = self.read(sensor, at);
        self.note_sample(sensor, at.now, effect.wait_ns);
        if let Some((values, measured_at)) = stuck {
            (self.values, self.measured_at) = (values, measured_at);
        }
        if fault == Some(FaultEffect::Lost) {
            self.values.fill(0.0);
        }
        effect.ping
    }

    /// Notes a sample that was taken at `now`.
    #[inline]
    fn note_sample(&mut self, sensor: &Sensor, now: SimTime, wait_ns: u64) {
        self.sampled_at = now;
        self.fresh = true;
        self.samples += 1;
        self.took_ns = sensor.acquisition_ns + wait_ns;
    }
}
