//! Satellite positioning (§1.2.2): latitude and longitude with an error that wanders slowly, and none where
//! the sky is hidden.
//!
//! Deviation: the notes speak of three satellites; a receiver whose clock is not right needs four. How many
//! there are is not modelled: the sky is seen or it is not.

use baudbot_geometry::{angle, math};
use serde::{Deserialize, Serialize};

use super::Measurement;
use crate::random::Stream;
use crate::time::{SECOND_NS, SimTime};

/// What a receiver is.
#[derive(Clone, Debug, PartialEq)]
pub struct Gps {
    /// Standard deviation of the wandering error, along x and y each, in metres.
    pub wander_sigma_m: f64,
    /// Time in which the error forgets itself, in seconds.
    pub wander_time_s: f64,
    /// Standard deviation of what is added to each fix, in metres.
    pub sigma_m: f64,
    /// Standard deviation of the speed over ground, in m/s.
    pub speed_sigma_m_s: f64,
    /// Time with sky until a lost fix is back, in nanoseconds.
    pub reacquire_ns: u64,
}

/// The error as it stands, and the fix.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Wander {
    error_m: [f64; 2],
    last: SimTime,
    /// Since when the sky is seen.
    sky_since: Option<SimTime>,
    /// The last position, which is repeated without a fix.
    position_deg: [f64; 2],
}

impl Wander {
    pub(super) fn is_sound(&self) -> bool {
        crate::sound::numbers(self.error_m.into_iter().chain(self.position_deg))
    }
}

impl Gps {
    /// At the start the error is anything that it can be later.
    pub(super) fn start(&self, stream: &mut Stream) -> Wander {
        let mut draw =
            || if self.wander_sigma_m == 0.0 { 0.0 } else { self.wander_sigma_m * stream.normal() };
        Wander {
            error_m: [draw(), draw()],
            last: SimTime::ZERO,
            sky_since: Some(SimTime::ZERO),
            position_deg: [0.0; 2],
        }
    }

    /// Latitude and longitude in degrees, 1 with a fix and 0 without, speed over ground in m/s, and the course
    /// in radians, counter-clockwise from east.
    pub(super) fn read(&self, at: &Measurement<'_>, wander: &mut Wander, stream: &mut Stream) -> [f64; 5] {
        if at.noise {
            self.wander_on(wander, at.now, stream);
        }
        let position = at.motion.pose.position;
        let sky = at.scene.surroundings.sky_at(position);
        wander.sky_since = if sky { wander.sky_since.or(Some(at.now)) } else { None };
        let back = |since: SimTime| since == SimTime::ZERO || at.now.since(since) >= self.reacquire_ns;
        let fix = wander.sky_since.is_some_and(back);
        if fix {
            let [mut east, mut north] = [position.x, position.y];
            if at.noise {
                east += wander.error_m[0] + self.sigma_m * stream.normal();
                north += wander.error_m[1] + self.sigma_m * stream.normal();
            }
            wander.position_deg = degrees(at.scene.surroundings.origin_deg, east, north);
        }
        let [latitude, longitude] = wander.position_deg;
        if !fix {
            return [latitude, longitude, 0.0, 0.0, 0.0];
        }
        let noise = if at.noise && self.speed_sigma_m_s > 0.0 { stream.normal() } else { 0.0 };
        let speed = (at.over_ground().forward + self.speed_sigma_m_s * noise).abs();
        let backwards = if at.motion.speed_m_s < 0.0 { core::f64::consts::PI } else { 0.0 };
        [latitude, longitude, 1.0, speed, angle::wrap(at.motion.pose.heading + backwards)]
    }

    /// A first-order Gauss–Markov process: exact for any time since the last fix.
    fn wander_on(&self, wander: &mut Wander, now: SimTime, stream: &mut Stream) {
        let dt = now.since(core::mem::replace(&mut wander.last, now)) as f64 / SECOND_NS as f64;
        if self.wander_sigma_m == 0.0 || dt == 0.0 {
            return;
        }
        let keep = math::exp(-dt / self.wander_time_s);
        let fresh = self.wander_sigma_m * math::sqrt(1.0 - keep * keep);
        for error in &mut wander.error_m {
            *error = keep * *error + fresh * stream.normal();
        }
    }
}

/// The place so many metres east and north of the origin, on a sphere of the earth's mean radius.
fn degrees((latitude, longitude): (f64, f64), east_m: f64, north_m: f64) -> [f64; 2] {
    let metres_per_degree = EARTH_RADIUS_M * core::f64::consts::PI / 180.0;
    let shrink = math::cos(latitude.to_radians()).max(1e-6);
    [latitude + north_m / metres_per_degree, longitude + east_m / (metres_per_degree * shrink)]
}

const EARTH_RADIUS_M: f64 = 6_371_008.8;
