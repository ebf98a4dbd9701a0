//! Readings for a brain on board: see `robot/onboard.rs`.

use baudbot_wire::{Encoding, clock};

use super::Microcontroller;
use crate::laptop::Laptop;
use crate::model::RobotSpec;
use crate::time::SimTime;

impl Microcontroller {
    /// Hands over what is readable, and says when the control cycle began that it belongs to.
    pub(crate) fn tell(&mut self, spec: &RobotSpec, now: SimTime, laptop: &mut Laptop) -> SimTime {
        self.serve_frame(spec, now);
        let (ages, repeats) = (spec.firmware.layout().ages, spec.firmware.protocol.repeats());
        let mut reading_ns = 0;
        for (i, sensor) in spec.sensors.iter().enumerate().take_while(|(_, sensor)| sensor.is_on_wire()) {
            let channel = &mut self.channels[i];
            let fresh = core::mem::take(&mut channel.fresh);
            reading_ns += if fresh { channel.took_ns } else { 0 };
            if !fresh && !repeats {
                continue;
            }
            let reading = &mut laptop.readings[i];
            if !channel.values.is_empty() && sensor.encodings.iter().all(|to| matches!(to, Encoding::Float64))
            {
                reading.values.clone_from(&channel.values);
            } else {
                reading.values.resize(sensor.encodings.len(), 0.0);
                for (k, (to, told)) in sensor.encodings.iter().zip(&mut reading.values).enumerate() {
                    // Before the first sample there are no values, and all may be told.
                    *told = to.quantise(channel.values.get(k).copied().unwrap_or(0.0));
                }
            }
            reading.sampled_at = ages.then(|| told_at(now, channel.sampled_at)).flatten();
            reading.sequence = if repeats { reading.sequence.wrapping_add(1) } else { self.sequence };
            reading.readable = true;
            let truly_at = (channel.samples > 0).then_some(channel.measured_at);
            laptop.note_age(i, truly_at);
        }
        self.sequence = self.sequence.wrapping_add(1);
        let begun = SimTime::from_ns(now.as_ns().saturating_sub(reading_ns));
        laptop.note_message(begun);
        begun
    }
}

/// When a reading was sampled as far as a frame that is closed now would tell it; `None` if that is too long ago.
fn told_at(now: SimTime, sampled_at: SimTime) -> Option<SimTime> {
    let age = clock::age_100us(now.since(sampled_at));
    let closed_ns = now.as_ns() / clock::UNIT_NS * clock::UNIT_NS;
    (age < u8::MAX).then(|| SimTime::from_ns(closed_ns.saturating_sub(u64::from(age) * clock::UNIT_NS)))
}
