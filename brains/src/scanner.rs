//! From a laser's readings to scans of one instant.
//!
//! A reading comes late, and is of a robot that moved. It waits until the odometry has come to the end of its sweep, and
//! then is [mended](crate::localization::deskew) by what that says.
//!
//! *Limit.* Lasers on turrets are not understood.

use baudbot_client::{Body, Sweep, Turn};

use crate::localization::deskew::{self, deskew};
use crate::odometry::Odometry;
use crate::scan::Scan;

/// What takes scans.
#[derive(Clone, Debug, PartialEq)]
pub struct Scanner {
    sensor: usize,
    sweep: Sweep,
    /// So many rays are kept, about.
    rays: usize,
    /// The last reading, and when it was begun, until the odometry knows where that was.
    waiting: Option<(u64, Scan)>,
}

impl Scanner {
    /// For the laser of this name. About so many of its rays are kept.
    ///
    /// # Errors
    /// In words, if the body has no such laser, or its data sheet does not say what must be known of it.
    pub fn new(body: &Body, laser: &str, rays: usize) -> Result<Self, String> {
        let sensor = body.sensor_index(laser).filter(|&sensor| body.sensors[sensor].kind == "laser");
        let sensor =
            sensor.ok_or_else(|| format!("laser: robot `{}` has no laser called `{laser}`", body.name))?;
        let sheet = &body.sensors[sensor];
        let missing = |what: &str| {
            format!("laser: the data sheet of `{laser}` does not say {what}: is the server older?")
        };
        let mount = sheet.mount.ok_or_else(|| missing("where it sits"))?;
        if mount.turret.is_some() {
            return Err(format!(
                "laser: `{laser}` sits on a turret, and scans from there are not understood"
            ));
        }
        let opening_rad = sheet.opening_rad.ok_or_else(|| missing("how wide it opens"))?;
        if !(opening_rad > 0.0 && sheet.values() > 1) {
            return Err(format!("laser: the rays of `{laser}` all go one way, which makes no scan"));
        }
        let sweep = sheet.sweep.ok_or_else(|| missing("how it sweeps"))?;
        if rays == 0 {
            return Err("rays: must be at least 1".to_owned());
        }
        Ok(Self { sensor, sweep, rays, waiting: None })
    }

    /// Takes in what a turn brought: a new reading replaces one that still waits.
    pub fn hear(&mut self, turn: &Turn) {
        let reading = turn.readings.get(self.sensor).and_then(Option::as_ref);
        let Some(reading) = reading.filter(|reading| reading.readable) else { return };
        let begun_ns =
            reading.sampled_at_ns.unwrap_or_else(|| turn.at_ns.saturating_sub(self.sweep.duration_ns));
        let scan = turn.body.sensors.get(self.sensor);
        let scan = scan.and_then(|sensor| Scan::of(sensor, reading));
        self.waiting = scan.map(|scan| (begun_ns, scan.thinned(self.rays)));
    }

    /// The instant of the end of its sweep, in nanoseconds, and the reading as if all of it had been taken then, once this
    /// odometry has come there. A reading from before all that is known is lost.
    pub fn take(&mut self, odometry: &Odometry) -> Option<(u64, Scan)> {
        let begun_ns = self.waiting.as_ref()?.0;
        let ended_ns = begun_ns.saturating_add(self.sweep.duration_ns);
        if odometry.at_ns() < ended_ns {
            return None;
        }
        let (_, scan) = self.waiting.take()?;
        let [right_ns, left_ns] =
            if self.sweep.clockwise { [ended_ns, begun_ns] } else { [begun_ns, ended_ns] };
        let pose_at = |at_ns| odometry.at(at_ns).map(|estimate| estimate.world_from_robot);
        Some((ended_ns, deskew(&scan, deskew::Sweep { right_ns, left_ns }, ended_ns, pose_at)?))
    }

    /// The same as it is, without any odometry: for who stands still, or knows only where it is now.
    pub fn take_as_is(&mut self) -> Option<(u64, Scan)> {
        let (begun_ns, scan) = self.waiting.take()?;
        Some((begun_ns.saturating_add(self.sweep.duration_ns), scan))
    }

    /// The reading that waits is not of interest any more.
    pub fn forget(&mut self) {
        self.waiting = None;
    }

    /// Whether the reading that waits was begun at this instant or later; false if none waits.
    pub fn waits_since(&self, at_ns: u64) -> bool {
        self.waiting.as_ref().is_some_and(|(begun_ns, _)| *begun_ns >= at_ns)
    }
}
