//! From a laser's readings to scans of one instant.
//!
//! A reading comes late, and is of a robot that moved. It waits until the odometry has come to the end of its sweep, and
//! then is [mended](deskew) by what that says.
//!
//! *Limits.* No data sheet says how wide a laser opens, which way round it sweeps, or how long that takes: these are
//! parameters. Lasers on turrets are not understood.

use baudbot_client::{Body, Turn};

use crate::localization::deskew::{Sweep, deskew};
use crate::odometry::Odometry;
use crate::scan::Scan;

/// What takes scans.
#[derive(Clone, Debug, PartialEq)]
pub struct Scanner {
    sensor: usize,
    /// Negative if it sweeps clockwise.
    opening_rad: f64,
    sweep_ns: u64,
    /// So many rays are kept, about.
    rays: usize,
    /// The last reading, and when it was begun, until the odometry knows where that was.
    waiting: Option<(u64, Scan)>,
}

impl Scanner {
    /// For the laser of this name. It opens by `opening_rad`, in radians, which is negative if it sweeps clockwise, and
    /// takes `sweep_s` from the first ray to the last, in seconds. About so many of its rays are kept.
    ///
    /// # Errors
    /// In words, if the body has no such laser, or a number makes no sense.
    pub fn new(
        body: &Body,
        laser: &str,
        opening_rad: f64,
        sweep_s: f64,
        rays: usize,
    ) -> Result<Self, String> {
        let sensor = body.sensor_index(laser).filter(|&sensor| body.sensors[sensor].kind == "laser");
        let sensor =
            sensor.ok_or_else(|| format!("laser: robot `{}` has no laser called `{laser}`", body.name))?;
        if !(0.0..=MOST_S).contains(&sweep_s) {
            return Err(format!("sweep_s: must be from 0 to {MOST_S}, is {sweep_s}"));
        }
        if !(opening_rad.is_finite() && opening_rad != 0.0) {
            return Err(format!("opening_rad: must not be 0, is {opening_rad}"));
        }
        if rays == 0 {
            return Err("rays: must be at least 1".to_owned());
        }
        Ok(Self { sensor, opening_rad, sweep_ns: (sweep_s * 1e9) as u64, rays, waiting: None })
    }

    /// Takes in what a turn brought: a new reading replaces one that still waits.
    pub fn hear(&mut self, turn: &Turn) {
        let reading = turn.readings.get(self.sensor).and_then(Option::as_ref);
        let Some(reading) = reading.filter(|reading| reading.readable) else { return };
        let begun_ns = reading.sampled_at_ns.unwrap_or_else(|| turn.at_ns.saturating_sub(self.sweep_ns));
        let scan = turn.body.sensors.get(self.sensor);
        let scan = scan.and_then(|sensor| Scan::of(sensor, self.opening_rad, reading));
        self.waiting = scan.map(|scan| (begun_ns, scan.thinned(self.rays)));
    }

    /// The instant of the end of its sweep, in nanoseconds, and the reading as if all of it had been taken then, once this
    /// odometry has come there. A reading from before all that is known is lost.
    pub fn take(&mut self, odometry: &Odometry) -> Option<(u64, Scan)> {
        let begun_ns = self.waiting.as_ref()?.0;
        let ended_ns = begun_ns + self.sweep_ns;
        if odometry.at_ns() < ended_ns {
            return None;
        }
        let (_, scan) = self.waiting.take()?;
        let is_clockwise = self.opening_rad < 0.0;
        let [right_ns, left_ns] = if is_clockwise { [ended_ns, begun_ns] } else { [begun_ns, ended_ns] };
        let pose_at = |at_ns| odometry.at(at_ns).map(|estimate| estimate.world_from_robot);
        Some((ended_ns, deskew(&scan, Sweep { right_ns, left_ns }, ended_ns, pose_at)?))
    }

    /// Whether the reading that waits was begun at this instant or later; false if none waits.
    pub fn waits_since(&self, at_ns: u64) -> bool {
        self.waiting.as_ref().is_some_and(|(begun_ns, _)| *begun_ns >= at_ns)
    }
}

/// No sweep takes longer, in seconds.
const MOST_S: f64 = 10.0;
