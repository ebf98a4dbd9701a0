//! Readings for a brain on board: see `robot/onboard.rs`.

use baudbot_wire::{Encoding, clock};

use super::Microcontroller;
use crate::laptop::Laptop;
use crate::model::RobotSpec;
use crate::time::SimTime;
use crate::values::ReadingValues;

impl Microcontroller {
    /// Hands over what is readable, and returns when the control cycle began that it belongs to.
    pub(crate) fn tell(&mut self, spec: &RobotSpec, now: SimTime, laptop: &mut Laptop) -> SimTime {
        self.serve_frame(spec, now);
        let (ages, repeats) = (spec.firmware.layout().ages, spec.firmware.protocol.repeats());
        let on_wire = spec.sensors.on_wire();
        let channels = &mut self.channels[..on_wire.len()];
        for ((sensor, channel), reading) in on_wire.iter().zip(&*channels).zip(&mut laptop.readings) {
            if channel.fresh || repeats {
                tell_values(&sensor.encodings, &channel.values, &mut reading.values);
            }
        }
        let mut reading_ns = 0;
        // Most were sampled at the same instant.
        let mut told = (SimTime::NEVER, None);
        let (readings, truth) = laptop.readings_with_truth();
        for (i, (channel, (reading, truly_at))) in channels.iter_mut().zip(readings).enumerate() {
            let fresh = core::mem::take(&mut channel.fresh);
            if !fresh && !repeats {
                continue;
            }
            reading_ns += if fresh { channel.took_ns } else { 0 };
            if ages && told.0 != channel.sampled_at {
                told = (channel.sampled_at, told_at(now, channel.sampled_at));
            }
            reading.sampled_at = told.1;
            reading.sequence = if repeats { reading.sequence.wrapping_add(1) } else { self.sequence };
            reading.readable = true;
            if channel.samples > 0 {
                *truly_at = Some(channel.measured_at);
            }
            truth.take(i, now, (channel.samples > 0).then_some(channel.measured_at));
        }
        self.sequence = self.sequence.wrapping_add(1);
        let begun = SimTime::from_ns(now.as_ns().saturating_sub(reading_ns));
        laptop.note_message(begun);
        begun
    }
}

/// The value of a sample once it has crossed the wire. Before the first one there are no values, and all may be sent.
fn tell_values(encodings: &[Encoding], sample: &[f64], told: &mut ReadingValues) {
    if let ([Encoding::Float64], [value], [told]) = (encodings, sample, &mut told[..]) {
        *told = *value;
    } else {
        tell_several(encodings, sample, told);
    }
}

#[inline(never)]
fn tell_several(encodings: &[Encoding], sample: &[f64], told: &mut ReadingValues) {
    if !sample.is_empty() && encodings.iter().all(|to| matches!(to, Encoding::Float64)) {
        told.clear();
        told.extend_from_slice(sample);
    } else {
        told.resize(encodings.len(), 0.0);
        for (k, (to, told)) in encodings.iter().zip(told).enumerate() {
            *told = to.quantise(sample.get(k).copied().unwrap_or(0.0));
        }
    }
}

/// The instant at which a reading was sampled, to the resolution of a frame that is closed now; `None` if that is too
/// long ago.
fn told_at(now: SimTime, sampled_at: SimTime) -> Option<SimTime> {
    let age = clock::age_100us(now.since(sampled_at));
    let closed_ns = now.as_ns() / clock::UNIT_NS * clock::UNIT_NS;
    (age < u8::MAX).then(|| SimTime::from_ns(closed_ns.saturating_sub(u64::from(age) * clock::UNIT_NS)))
}
