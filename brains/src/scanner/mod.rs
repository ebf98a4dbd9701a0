//! The way from a laser's readings to scans of one instant.
//!
//! A reading comes late, and is of a robot that moved. It waits until the odometry has come to the end of its sweep, and
//! then is [corrected](crate::localization::deskew) by what that says. On a slow cable odometry comes later than the next
//! readings of the laser, so these wait behind it: each is used as soon as odometry covers it, the oldest first.
//!
//! *Limit.* Lasers on turrets are not understood.

use std::collections::VecDeque;

use baudbot_brain::{Body, SensorKind, Sweep, Turn};

use crate::awaited::Awaited;
use crate::localization::deskew::{self, deskew};
use crate::odometry::Odometry;
use crate::parameter::ParameterError;
use crate::scan::Scan;

/// A source of scans.
#[derive(Clone, Debug, PartialEq)]
pub struct Scanner {
    sensor: usize,
    sweep: Sweep,
    /// The number of rays that are kept, about.
    rays: usize,
    name: String,
    /// The instant at which the laser's last reading came, in nanoseconds; 0 if none has.
    heard_ns: u64,
    /// Readings, and when each was begun, until the odometry knows where that was; the oldest first.
    waiting: VecDeque<(u64, Scan)>,
}

impl Scanner {
    /// A `Scanner` for the laser of this name. About so many of its rays are kept.
    ///
    /// # Errors
    /// In words, if the body has no such laser, or its data sheet does not state what must be known of it.
    pub fn new(body: &Body, laser: &str, rays: usize) -> Result<Self, ParameterError> {
        let sensor =
            body.sensor_index(laser).filter(|&sensor| body.sensors[sensor].kind == SensorKind::Laser);
        let wrong = |problem: String| ParameterError::value("laser", problem);
        let sensor =
            sensor.ok_or_else(|| wrong(format!("robot `{}` has no laser called `{laser}`", body.name)))?;
        let sheet = &body.sensors[sensor];
        let missing = |what: &str| {
            wrong(format!("the data sheet of `{laser}` does not say {what}: is the server older?"))
        };
        let mount = sheet.mount.ok_or_else(|| missing("where it sits"))?;
        if mount.turret.is_some() {
            return Err(wrong(format!("`{laser}` sits on a turret, and scans from there are not supported")));
        }
        if mount.elevation_rad.is_some() {
            return Err(wrong(format!(
                "the rays of `{laser}` have an elevation, and scans of such are not supported"
            )));
        }
        let opening_rad = sheet.opening_rad.ok_or_else(|| missing("how wide it opens"))?;
        if !(opening_rad > 0.0 && sheet.values() > 1) {
            return Err(wrong(format!("the rays of `{laser}` all point the same way, which is not a scan")));
        }
        let sweep = sheet.sweep.ok_or_else(|| missing("how it sweeps"))?;
        if rays == 0 {
            return Err(ParameterError::value("rays", "must be at least 1"));
        }
        Ok(Self { sensor, sweep, rays, name: laser.to_owned(), heard_ns: 0, waiting: VecDeque::new() })
    }

    /// Takes in what a turn brought. A new reading waits behind those that wait already. If too many do, it is left out, and
    /// not one of these: the next one would take the place of the next.
    pub fn hear(&mut self, turn: &Turn) {
        let reading = turn.readings.get(self.sensor).and_then(Option::as_ref);
        let Some(reading) = reading.filter(|reading| reading.readable) else { return };
        self.heard_ns = turn.at_ns;
        if self.waiting.len() == MOST_WAITING {
            return;
        }
        let begun_ns =
            reading.sampled_at_ns.unwrap_or_else(|| turn.at_ns.saturating_sub(self.sweep.duration_ns));
        let scan = turn.body.sensors.get(self.sensor);
        let scan = scan.and_then(|sensor| Scan::of(sensor, reading));
        self.waiting.extend(scan.map(|scan| (begun_ns, scan.thinned(self.rays))));
    }

    /// The oldest reading that waits, as if all of it had been taken at the end of its sweep, and that instant in
    /// nanoseconds, once this odometry has come there; `None` until then. There may be another behind it. A reading from before
    /// all that is known is lost.
    pub fn take(&mut self, odometry: &Odometry) -> Option<(u64, Scan)> {
        let sweep = self.sweep;
        let is_covered =
            |waiting: &mut (u64, Scan)| waiting.0.saturating_add(sweep.duration_ns) <= odometry.at_ns();
        let mut track = odometry.track();
        while let Some((begun_ns, scan)) = self.waiting.pop_front_if(is_covered) {
            let ended_ns = begun_ns.saturating_add(sweep.duration_ns);
            let [right_ns, left_ns] =
                if sweep.clockwise { [ended_ns, begun_ns] } else { [begun_ns, ended_ns] };
            let mended =
                deskew(&scan, deskew::Sweep { right_ns, left_ns }, ended_ns, |at_ns| track.pose_at(at_ns));
            if let Some(mended) = mended {
                return Some((ended_ns, mended));
            }
        }
        None
    }

    /// The oldest reading that waits as it is, without any odometry: for a robot that stands still, or knows only its present
    /// pose.
    pub fn take_as_is(&mut self) -> Option<(u64, Scan)> {
        let (begun_ns, scan) = self.waiting.pop_front()?;
        Some((begun_ns.saturating_add(self.sweep.duration_ns), scan))
    }

    /// The sensor that the next scan waits for, and since when: that of this odometry, if readings wait for that, or
    /// else the laser.
    #[must_use]
    pub fn awaited(&self, odometry: Option<&Odometry>) -> Awaited {
        let odometry = odometry.filter(|_| !self.waiting.is_empty());
        let laser = || Awaited { sensor: self.name.clone(), since_ns: self.heard_ns };
        odometry.map_or_else(laser, Odometry::awaited)
    }

    /// The readings that wait are not of interest any more.
    pub fn forget(&mut self) {
        self.waiting.clear();
    }

    /// Drops the scans that wait and were begun before this instant, in nanoseconds.
    pub fn forget_before(&mut self, at_ns: u64) {
        self.waiting.retain(|(begun_ns, _)| *begun_ns >= at_ns);
    }
}

/// The most readings that wait: those of a laser at 100 Hz while odometry is five seconds late.
const MOST_WAITING: usize = 512;

#[cfg(test)]
mod tests;
