//! Devices with a clock of their own on the dry timeline: what they hold when, and what their cables bring.

use super::plan::{adapter, calm, settling_ns};
use super::wire;
use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::sensor::Sensor;
use baudbot_sim::time::SimTime;

/// The clock of a device, as it is usually: half as late as it can be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    period_ns: u64,
    /// The instant at which the first measurement begins; `None` if it is unknown.
    begins_ns: Option<u64>,
    /// The time from the beginning of a measurement to its output, in nanoseconds.
    settling_ns: u64,
}

impl Watch {
    pub(super) fn of(sensor: &Sensor, noise: bool) -> Option<Self> {
        let clock = sensor.own_clock.as_ref()?;
        let late_ns = if noise { clock.jitter_ns / 2 } else { 0 };
        let known =
            if noise { clock.phase_ns.filter(|_| clock.spread_ns == 0) } else { clock.phase_ns.or(Some(0)) };
        let settling_ns = settling_ns(sensor, clock);
        Some(Self { period_ns: clock.period_ns, begins_ns: known.map(|ns| ns + late_ns), settling_ns })
    }

    /// The instant at which that was measured which the device holds at an instant; before the first, that instant.
    pub(super) fn held_at(&self, now: SimTime) -> SimTime {
        let Some(begins_ns) = self.begins_ns else {
            return SimTime::from_ns(now.as_ns().saturating_sub(self.settling_ns + self.period_ns / 2));
        };
        match now.as_ns().checked_sub(begins_ns + self.settling_ns) {
            Some(since) => SimTime::from_ns(begins_ns + since / self.period_ns * self.period_ns),
            None => now,
        }
    }
}

/// The laptop's end of a cable of a device's own.
#[derive(Clone, Debug)]
pub(super) struct Ear {
    sensor: usize,
    watch: Watch,
    link: Link,
    bytes: u64,
    /// The number of the measurement that comes next.
    nth: u64,
    /// The instant of the measurement that is on the cable, and when that arrives.
    under_way: (SimTime, SimTime),
}

impl Ear {
    pub(super) fn new(i: usize, sensor: &Sensor, link: &Link, noise: bool) -> Self {
        let unknown = Watch { period_ns: 1, begins_ns: None, settling_ns: 0 };
        let watch = Watch::of(sensor, noise).unwrap_or(unknown);
        let bytes = wire::port_bytes(sensor).middle();
        let never = (SimTime::ZERO, SimTime::NEVER);
        let mut ear = Self { sensor: i, watch, link: calm(link), bytes, nth: 0, under_way: never };
        ear.send(SimTime::ZERO);
        ear
    }

    pub(super) fn next(&self) -> SimTime {
        self.under_way.1
    }

    /// The sensor whose measurement arrives at an instant, if one does, and the instant of the measurement.
    pub(super) fn take(&mut self, now: SimTime) -> Option<(usize, SimTime)> {
        let (measured, arrival) = self.under_way;
        (arrival <= now).then(|| {
            let idle = measured + self.watch.settling_ns + self.link.burst_ns(self.bytes);
            self.send(idle);
            (self.sensor, measured)
        })
    }

    /// The first measurement that comes out when the cable is idle is sent.
    fn send(&mut self, idle: SimTime) {
        let Watch { period_ns, begins_ns, settling_ns } = self.watch;
        let first = begins_ns.unwrap_or(0) + settling_ns;
        let nth = idle.as_ns().saturating_sub(first).div_ceil(period_ns).max(self.nth);
        self.nth = nth + 1;
        let measured = begins_ns.unwrap_or(0).saturating_add(nth.saturating_mul(period_ns));
        let out = SimTime::from_ns(measured) + settling_ns;
        let landed = wire::start_of_frame(&self.link, out) + self.link.burst_ns(self.bytes);
        self.under_way = (SimTime::from_ns(measured), self.through_adapter(out, landed));
    }

    /// The usual instant of arrival at the laptop.
    fn through_adapter(&self, out: SimTime, landed: SimTime) -> SimTime {
        match adapter(&self.link) {
            Adapter::None => landed,
            Adapter::Cdc(frames) => frames.at_laptop(landed, frames.jitter_ns / 2),
            Adapter::Ftdi(ftdi) => {
                let packet = u64::from(ftdi.packet_bytes.max(1));
                let full = self.bytes / packet * packet;
                let closed = match full {
                    0 => landed + ftdi.latency_ns / 2,
                    all if all == self.bytes => landed,
                    full => (out + self.link.burst_ns(full) + ftdi.latency_ns).max(landed),
                };
                ftdi.frames.at_laptop(closed, ftdi.frames.jitter_ns / 2)
            }
            Adapter::Bluetooth(radio) => landed + radio.latency_ns + radio.latency_ns / 2,
        }
    }
}
