//! Devices that measure at their own pace, whether or not anybody reads them, and hold their last value.
//!
//! A GP2D12 measures every 38 ms, begins somewhere, and keeps its voltage in between; a laser's mirror turns on
//! its own; a satellite receiver speaks once a second. A microcontroller that reads such a device gets what it
//! holds, and does not know how old that is; one with a cable of its own sends each measurement when it is done.

use alloc::vec::Vec;

use serde::{Deserialize, Serialize};

use super::{Device, Measurement, Memory, Sensor, noise};
use crate::fault::FaultEffect;
use crate::random::Stream;
use crate::sound;
use crate::time::SimTime;

/// When such a device measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnClock {
    /// Time between two measurements, in nanoseconds.
    pub period_ns: u64,
    /// The deviation of a specimen's period, either way: drawn once a run.
    pub spread_ns: u64,
    /// The greatest lateness of each measurement: drawn each time.
    pub jitter_ns: u64,
    /// When the first one begins; `None`: anywhere in the first period, drawn once a run.
    pub phase_ns: Option<u64>,
    /// Time from the end of a measurement until its value is at the output.
    pub latency_ns: u64,
}

/// The progress of such a device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Running {
    /// This specimen's period.
    period_ns: u64,
    /// When the next measurement is due, without jitter.
    due: SimTime,
    /// When the measurement that is next, or under way, begins.
    begins: SimTime,
    /// The part of a scan that has been taken.
    taken: usize,
    /// A scan under way.
    scan: Vec<f64>,
    /// A measurement that is done and not yet at the output.
    pending: Option<Held>,
    /// The value at the output.
    held: Option<Held>,
}

/// A measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Held {
    pub(crate) values: Vec<f64>,
    /// When it began, as the device tells it.
    pub(crate) measured_at: SimTime,
    /// When it truly began: earlier, if the device sticks.
    pub(crate) truly_at: SimTime,
    /// When it is at the output.
    pub(crate) ready_at: SimTime,
}

/// The next event in such a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// It measures, or goes on with a scan.
    Measure,
    /// The measurement comes to the output: a device with a cable of its own sends it.
    Output,
}

/// The parts of a measurement besides the scene.
pub(crate) struct Parts<'a> {
    pub(crate) memory: &'a mut Memory,
    pub(crate) noise: &'a mut noise::NoiseState,
    pub(crate) stream: &'a mut Stream,
}

impl Running {
    /// Without noise all specimens have the same period and begin at once, and none is late.
    pub(crate) fn start(clock: &OwnClock, specimen: &mut Stream, noise: bool) -> Self {
        let spread = if clock.spread_ns == 0 || !noise { 0.0 } else { 2.0 * specimen.uniform() - 1.0 };
        let period_ns =
            clock.period_ns.saturating_add_signed((spread * clock.spread_ns as f64) as i64).max(1);
        let anywhere =
            |stream: &mut Stream| if noise { (stream.uniform() * period_ns as f64) as u64 } else { 0 };
        let begins = SimTime::from_ns(clock.phase_ns.unwrap_or_else(|| anywhere(specimen)));
        Self { period_ns, due: begins, begins, taken: 0, scan: Vec::new(), pending: None, held: None }
    }

    /// Whether such a device can stand so at `now`: what is past it has measured, so that it has not a year to make up
    /// for, and a measurement has all of its values.
    pub(crate) fn is_sound(&self, device: &Device, clock: &OwnClock, now: SimTime) -> bool {
        let whole = |held: &Option<Held>| {
            held.as_ref().is_none_or(|held| {
                held.values.len() == device.values() && sound::numbers(held.values.iter().copied())
            })
        };
        let (rays, sweep_ns) =
            if let Device::Laser(laser) = device { (laser.rays(), laser.sweep_ns) } else { (0, 0) };
        // One that takes longer than its period is late for ever.
        let keeps_up = self.begins.since(self.due) <= clock.jitter_ns || sweep_ns >= self.period_ns;
        self.period_ns > 0
            && self.period_ns.abs_diff(clock.period_ns) <= clock.spread_ns
            && keeps_up
            && self.next(device).0 >= now
            && self.taken <= rays
            && (self.scan.is_empty() && self.taken == 0 || self.scan.len() == device.values())
            && sound::numbers(self.scan.iter().copied())
            && whole(&self.pending)
            && whole(&self.held)
    }

    /// The next event, and its instant. A value comes to the output before the next measurement.
    pub(crate) fn next(&self, device: &Device) -> (SimTime, Event) {
        let measure = if let Device::Laser(laser) = device {
            laser.instant(self.begins, self.taken)
        } else {
            self.begins
        };
        match &self.pending {
            Some(pending) if pending.ready_at <= measure => (pending.ready_at, Event::Output),
            _ => (measure, Event::Measure),
        }
    }

    /// Measures; of a scan, all that is taken before the tick ends. A device that sticks has measured what it had
    /// before, if anything, and one whose signal is lost zeros.
    pub(crate) fn measure(
        &mut self,
        sensor: &Sensor,
        clock: &OwnClock,
        at: &Measurement<'_>,
        parts: Parts<'_>,
        effect: Option<FaultEffect>,
    ) {
        let Parts { memory, noise, stream } = parts;
        self.scan.resize(sensor.encodings.len(), 0.0);
        let end = if let Device::Laser(laser) = &sensor.device {
            let which = self.taken..laser.taken_before(self.begins, at.tick_end).max(self.taken);
            laser.take(at, which.clone(), self.begins, &mut self.scan);
            self.taken = which.end;
            if self.taken < laser.rays() {
                return;
            }
            self.begins + laser.sweep_ns
        } else {
            sensor.device.read(at, memory, stream, &mut self.scan);
            at.now
        };
        sensor.disturb(at.noise, noise, self.begins, &mut self.scan, stream);
        self.finish(end + clock.latency_ns, effect);
        self.due = self.due + self.period_ns;
        let late =
            if clock.jitter_ns == 0 || !at.noise { 0.0 } else { stream.uniform() * clock.jitter_ns as f64 };
        // A measurement that begins late does not begin before the last one is over.
        self.begins = (self.due + late as u64).max(end);
    }

    /// The measurement will be at the output at `ready_at`.
    fn finish(&mut self, ready_at: SimTime, effect: Option<FaultEffect>) {
        let mut values = core::mem::take(&mut self.scan);
        if effect == Some(FaultEffect::Lost) {
            values.fill(0.0);
        }
        let last = self.pending.as_ref().or(self.held.as_ref());
        self.pending = Some(match last.filter(|_| effect == Some(FaultEffect::Sticks)) {
            Some(last) => Held { measured_at: self.begins, ready_at, ..last.clone() },
            None => Held { values, measured_at: self.begins, truly_at: self.begins, ready_at },
        });
        self.taken = 0;
    }

    /// When the measurement began that is not yet at the output.
    pub(crate) fn pending_since(&self) -> Option<SimTime> {
        self.pending.as_ref().map(|pending| pending.measured_at)
    }

    /// Moves the pending value to the output.
    pub(crate) fn output(&mut self) -> Option<&Held> {
        if let Some(pending) = self.pending.take()
            && let Some(old) = self.held.replace(pending)
            && self.scan.capacity() == 0
        {
            // The next measurement needs no new memory.
            self.scan = old.values;
            self.scan.clear();
        }
        self.held.as_ref()
    }

    /// The value at the output, if anything has been measured yet.
    pub(crate) fn held(&self) -> Option<&Held> {
        self.held.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use baudbot_geometry::{Fan, Pose};

    use super::*;
    use crate::arena::Arena;
    use crate::sensor::{Laser, Mount};

    const MS: u64 = 1_000_000;

    fn at_ms(ms: u64) -> SimTime {
        SimTime::from_ns(ms * MS)
    }

    #[test]
    fn a_device_that_sticks_gives_its_last_values_at_its_own_instants() {
        let begins = |ms| Running {
            period_ns: 10 * MS,
            due: at_ms(ms),
            begins: at_ms(ms),
            taken: 0,
            scan: vec![ms as f64],
            pending: None,
            held: None,
        };
        let mut running = begins(10);
        running.finish(at_ms(12), None);
        running = Running { pending: running.pending, ..begins(20) };
        running.finish(at_ms(22), Some(FaultEffect::Sticks));
        let [began, ready] = [at_ms(20), at_ms(22)];
        let stuck = Held { values: vec![10.0], measured_at: began, truly_at: at_ms(10), ready_at: ready };
        assert_eq!(running.pending, Some(stuck));
    }

    /// Each of these alone makes a laser's state one that no world comes to.
    #[test]
    fn a_state_is_sound_only_if_all_of_it_is() {
        let mount = Mount {
            pose: Pose::new(0.0, 0.0, 0.0),
            turret: None,
            height: Arena::new(vec![], vec![]).height(0.0),
            elevation_rad: None,
        };
        let fan = Fan::new(4.178564, 682);
        let laser = Laser { mount, fan, min_m: 0.02, range_m: 5.6, sweep_ns: 66_503_900, clockwise: false };
        let device = &Device::Laser(laser);
        let clock =
            &OwnClock { period_ns: 100 * MS, spread_ns: 0, jitter_ns: 0, phase_ns: None, latency_ns: 0 };
        let n = device.values();
        let held =
            |values| Some(Held { values, measured_at: at_ms(0), truly_at: at_ms(0), ready_at: at_ms(200) });
        let sound = Running {
            period_ns: clock.period_ns,
            due: at_ms(200),
            begins: at_ms(200),
            taken: 5,
            scan: vec![1.0; n],
            pending: held(vec![1.0; n]),
            held: held(vec![1.0; n]),
        };
        let is_sound = |running: &Running, now_ms| running.is_sound(device, clock, at_ms(now_ms));
        assert!(is_sound(&sound, 200) && !is_sound(&sound, 300), "what was due 100 ms ago is done");
        let others = [
            ("period", Running { period_ns: 2 * clock.period_ns + clock.spread_ns, ..sound.clone() }),
            ("late", Running { begins: at_ms(220), ..sound.clone() }),
            ("more taken than there are", Running { taken: n + 1, ..sound.clone() }),
            ("a scan without room", Running { scan: vec![1.0; n - 1], ..sound.clone() }),
            ("taken without a scan", Running { scan: vec![], ..sound.clone() }),
            ("no number", Running { scan: vec![f64::NAN; n], ..sound.clone() }),
            ("half a scan pending", Running { pending: held(vec![1.0; n / 2]), ..sound.clone() }),
            ("no number pending", Running { pending: held(vec![f64::INFINITY; n]), ..sound.clone() }),
            ("half a scan held", Running { held: held(vec![1.0; n / 2]), ..sound.clone() }),
        ];
        for (what, running) in others {
            assert!(!is_sound(&running, 200), "{what}");
        }
    }
}
