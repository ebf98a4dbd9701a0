//! Satellite positioning (§1.2.2): latitude and longitude with an error that wanders slowly, and none where
//! the sky is hidden. The error is the sum of two first-order Gauss–Markov processes: the autocorrelation of a real
//! receiver's (a Garmin 12XL over 20 days, by D. L. Wilson) falls for about a minute, bends, and then falls slowly.
//!
//! Deviation: the notes speak of three satellites; a receiver whose clock is not right needs four. How many
//! there are is not modelled: the sky is seen or it is not.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::PI;

use baudbot_geometry::{Pose, angle, math};
use serde::{Deserialize, Serialize};

use super::Measurement;
use super::kind::{Built, Component, Effect, Fit, Place, Sense, level};
use crate::random::Stream;
use crate::time::{SECOND_NS, SimTime};
use baudbot_fields::number::{Between, Number, Positive, Seconds, Sigma};
use baudbot_fields::{FieldError, Path};

/// The model of a satellite receiver.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Gps {
    /// Standard deviation of an error that wanders slowly, along x and y each.
    #[serde(default, with = "Number::<Sigma>")]
    pub wander_sigma_m: f64,
    /// Time constant of that error.
    #[serde(default = "wander_time_s", with = "Number::<Positive>")]
    pub wander_time_s: f64,
    /// Standard deviation of a second error, which wanders faster, along x and y each.
    #[serde(default, with = "Number::<Sigma>")]
    pub short_wander_sigma_m: f64,
    /// Time constant of the second error.
    #[serde(default = "short_wander_time_s", with = "Number::<Positive>")]
    pub short_wander_time_s: f64,
    /// Standard deviation of the noise added to each fix, along x and y each.
    #[serde(default, with = "Number::<Sigma>")]
    pub sigma_m: f64,
    /// Standard deviation of the noise added to the speed.
    #[serde(default, with = "Number::<Sigma>")]
    pub speed_sigma_m_s: f64,
    /// Time with a view of the sky until a lost fix is back.
    #[serde(rename = "reacquire_s", default, with = "Number::<Seconds<Between<0, 1_000_000>>>")]
    pub reacquire_ns: u64,
}

/// The error as it stands, and the fix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Wander {
    error_m: [f64; 2],
    last: SimTime,
    /// Since when the sky is seen.
    sky_since: Option<SimTime>,
    /// The error that wanders faster, if there is one.
    short_error_m: Option<[f64; 2]>,
    /// The last position, which is repeated without a fix.
    position_deg: [f64; 2],
}

impl Wander {
    pub(super) fn is_sound(&self) -> bool {
        let short = self.short_error_m.into_iter().flatten();
        crate::sound::numbers(self.error_m.into_iter().chain(self.position_deg).chain(short))
    }
}

fn wander_time_s() -> f64 {
    200.0
}

fn short_wander_time_s() -> f64 {
    60.0
}

impl Sense for Gps {
    const NAME: &str = "gps";
    const PLACE: Place = Place::Inside;
    const IS_ANALOG: bool = false;
    type Sheet = Self;
    type Memory = Box<Wander>;

    fn new(sheet: Self, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let ranges = [(-90.0, 90.0), (-180.0, 180.0), (0.0, 1.0), (0.0, 100.0), (-PI, PI)];
        Ok(Built::new(sheet, ranges.map(|(min, max)| level(fit.bits, min, max)).into()))
    }

    fn components(&self) -> Vec<Component> {
        vec![
            Component::one("latitude_deg", "deg"),
            Component::one("longitude_deg", "deg"),
            Component::one("fix", "1"),
            Component::one("speed_m_s", "m/s"),
            Component::one("course_rad", "rad"),
        ]
    }

    /// At the start the error is anything that it can be later.
    fn remember(&self, _: &Pose, stream: &mut Stream) -> Box<Wander> {
        let mut draw = |sigma_m: f64| if sigma_m == 0.0 { 0.0 } else { sigma_m * stream.normal() };
        let error_m = [draw(self.wander_sigma_m), draw(self.wander_sigma_m)];
        let short = [draw(self.short_wander_sigma_m), draw(self.short_wander_sigma_m)];
        Box::new(Wander {
            error_m,
            last: SimTime::ZERO,
            sky_since: Some(SimTime::ZERO),
            short_error_m: (self.short_wander_sigma_m > 0.0).then_some(short),
            position_deg: [0.0; 2],
        })
    }

    /// Latitude and longitude in degrees, 1 with a fix and 0 without, speed over ground in m/s, and the course
    /// in radians, counter-clockwise from east.
    fn read(
        &self,
        at: &Measurement<'_>,
        wander: &mut Box<Wander>,
        stream: &mut Stream,
        values: &mut [f64],
    ) -> Effect {
        if at.noise {
            self.wander_on(wander, at.now, stream);
        }
        let position = at.motion.pose.position;
        let sky = at.scene.surroundings.sky_at(position);
        let sky_since = &mut wander.sky_since;
        *sky_since = if sky { sky_since.or(Some(at.now)) } else { None };
        let back = |since: SimTime| since == SimTime::ZERO || at.now.since(since) >= self.reacquire_ns;
        let fix = sky_since.is_some_and(back);
        if fix {
            let [mut east, mut north] = [position.x, position.y];
            if at.noise {
                let [short_east, short_north] = wander.short_error_m.unwrap_or_default();
                east += wander.error_m[0] + short_east + self.sigma_m * stream.normal();
                north += wander.error_m[1] + short_north + self.sigma_m * stream.normal();
            }
            wander.position_deg = degrees(at.scene.surroundings.origin_deg, east, north);
        }
        let [latitude, longitude] = wander.position_deg;
        if !fix {
            values.copy_from_slice(&[latitude, longitude, 0.0, 0.0, 0.0]);
            return Effect::NONE;
        }
        let noise = if at.noise && self.speed_sigma_m_s > 0.0 { stream.normal() } else { 0.0 };
        let speed = (at.over_ground().forward + self.speed_sigma_m_s * noise).abs();
        let backwards = if at.motion.speed_m_s < 0.0 { PI } else { 0.0 };
        let course = angle::wrap(at.motion.pose.heading + backwards);
        values.copy_from_slice(&[latitude, longitude, 1.0, speed, course]);
        Effect::NONE
    }
}

impl Gps {
    /// Both errors as they are now.
    fn wander_on(&self, wander: &mut Wander, now: SimTime, stream: &mut Stream) {
        let dt = now.since(core::mem::replace(&mut wander.last, now)) as f64 / SECOND_NS as f64;
        if dt == 0.0 {
            return;
        }
        if self.wander_sigma_m > 0.0 {
            wander_for(&mut wander.error_m, (self.wander_sigma_m, self.wander_time_s), dt, stream);
        }
        if let Some(short) = &mut wander.short_error_m {
            wander_for(short, (self.short_wander_sigma_m, self.short_wander_time_s), dt, stream);
        }
    }
}

/// A first-order Gauss–Markov process: exact for any time `dt` since the last fix.
fn wander_for(error_m: &mut [f64; 2], (sigma_m, time_s): (f64, f64), dt: f64, stream: &mut Stream) {
    let keep = math::exp(-dt / time_s);
    let fresh = sigma_m * math::sqrt(1.0 - keep * keep);
    for error in error_m {
        *error = keep * *error + fresh * stream.normal();
    }
}

/// The place so many metres east and north of the origin, on a sphere of the earth's mean radius.
fn degrees((latitude, longitude): (f64, f64), east_m: f64, north_m: f64) -> [f64; 2] {
    let metres_per_degree = EARTH_RADIUS_M * PI / 180.0;
    let shrink = math::cos(latitude.to_radians()).max(1e-6);
    [latitude + north_m / metres_per_degree, longitude + east_m / (metres_per_degree * shrink)]
}

const EARTH_RADIUS_M: f64 = 6_371_008.8;
