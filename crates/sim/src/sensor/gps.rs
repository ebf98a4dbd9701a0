//! Satellite positioning (§1.2.2): latitude and longitude with an error that wanders slowly, and none where
//! the sky is hidden. The error is the sum of two first-order Gauss–Markov processes: the autocorrelation of a real
//! receiver's (a Garmin 12XL over 20 days, by D. L. Wilson) falls for about a minute, bends, and then falls slowly.
//!
//! A receiver that tells its `satellites` has three more values: altitude, number of satellites, HDOP. The standard deviations σ of its table
//! are those of each axis under the open sky, with all twelve [satellites](sky): with n of them
//!
//! σ_x(n) = σ HDOP(n) / HDOP(12), σ_z(n) = σ √2 VDOP(n) / HDOP(12)
//!
//! since HDOP stands for both axes together. The altitude has processes of the same two times, and a stream, of its own.
//!
//! Deviations. To other receivers the sky is seen or it is not. The floor is flat, so that the true altitude is the arena's, and the antenna has
//! no height. Errors of positions and altitude are independent, and jump as a satellite comes or goes.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::{PI, SQRT_2};

use baudbot_geometry::{Point, Pose, angle, math};
use serde::{Deserialize, Serialize};

use super::Measurement;
use super::kind::{Built, Component, Effect, Fit, Place, Sense, level};
use super::sky::{self, Dilution, SKY};
use crate::random::Stream;
use crate::surroundings::Surroundings;
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
    /// `true`: it also tells altitude, number of satellites and dilution of precision, and its errors, which are those under the open sky, grow
    /// where the arena's zones have a `horizon_deg`. With a port only if it sends all `sentences`.
    #[serde(default)]
    pub satellites: bool,
}

/// The error as it stands, and the fix.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Wander {
    error_m: [f64; 2],
    last: SimTime,
    /// Since when the sky is seen.
    sky_since: Option<SimTime>,
    parts: Parts,
    /// The last position, which is repeated without a fix.
    position_deg: [f64; 2],
}

/// The parts of the error that not every receiver has: one along x and y that wanders faster, and the altitude's. The first two variants have the
/// bytes of an `Option`, which kept states have here.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Parts {
    #[default]
    None,
    Short([f64; 2]),
    Altitude(Altitude),
    Both([f64; 2], Altitude),
}

/// The altitude, which receivers tell as well (§1.2.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Altitude {
    /// The error that wanders slowly, and the one that wanders faster, both as along an axis.
    errors_m: [f64; 2],
    /// The last altitude, which is repeated without a fix.
    last_m: f64,
    stream: Stream,
}

impl Parts {
    fn short(&self) -> Option<[f64; 2]> {
        match self {
            Self::None | Self::Altitude(_) => None,
            Self::Short(short) | Self::Both(short, _) => Some(*short),
        }
    }

    fn both(&mut self) -> (Option<&mut [f64; 2]>, Option<&mut Altitude>) {
        match self {
            Self::None => (None, None),
            Self::Short(short) => (Some(short), None),
            Self::Altitude(altitude) => (None, Some(altitude)),
            Self::Both(short, altitude) => (Some(short), Some(altitude)),
        }
    }
}

impl Wander {
    /// Visits its streams of random numbers.
    pub(super) fn each_stream(&mut self, visit: &mut impl FnMut(&mut Stream)) {
        if let (_, Some(altitude)) = self.parts.both() {
            visit(&mut altitude.stream);
        }
    }

    pub(super) fn is_sound(&self) -> bool {
        let short = self.parts.short().into_iter().flatten();
        let numbers = self.error_m.into_iter().chain(self.position_deg).chain(short);
        crate::sound::numbers(numbers)
            && match &self.parts {
                Parts::None | Parts::Short(_) => true,
                Parts::Altitude(altitude) | Parts::Both(_, altitude) => {
                    let numbers = altitude.errors_m.into_iter().chain([altitude.last_m]);
                    crate::sound::numbers(numbers) && altitude.stream.is_sound()
                }
            }
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
        let of_sky = [(-1000.0, 10_000.0), (0.0, SKY.len() as f64), (0.0, 100.0)];
        let ranges = ranges.into_iter().chain(of_sky.into_iter().filter(|_| sheet.satellites));
        let encodings = ranges.map(|(min, max)| level(fit.bits, min, max)).collect();
        Ok(Built::new(sheet, encodings))
    }

    fn components(&self) -> Vec<Component> {
        let mut components = vec![
            Component::one("latitude_deg", "deg"),
            Component::one("longitude_deg", "deg"),
            Component::one("fix", "1"),
            Component::one("speed_m_s", "m/s"),
            Component::one("course_rad", "rad"),
        ];
        if self.satellites {
            let of_sky = [("altitude_m", "m"), ("satellites", "1"), ("hdop", "1")];
            components.extend(of_sky.map(|(name, unit)| Component::one(name, unit)));
        }
        components
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
            position_deg: [0.0; 2],
            parts: match (self.short_wander_sigma_m > 0.0, self.satellites) {
                (false, false) => Parts::None,
                (true, false) => Parts::Short(short),
                (false, true) => Parts::Altitude(self.altitude(stream)),
                (true, true) => Parts::Both(short, self.altitude(stream)),
            },
        })
    }

    /// Latitude and longitude in degrees, 1 with a fix and 0 without, speed over ground in m/s, and the course
    /// in radians, counter-clockwise from east; then altitude in metres, number of satellites, and HDOP.
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
        let seen = self.satellites_seen(at.scene.surroundings, position);
        let sky_since = &mut wander.sky_since;
        *sky_since = if seen >= sky::LEAST { sky_since.or(Some(at.now)) } else { None };
        let back = |since: SimTime| since == SimTime::ZERO || at.now.since(since) >= self.reacquire_ns;
        let fix = sky_since.is_some_and(back);
        let (of_place, of_sky) = values.split_at_mut(5);
        if let (_, Some(altitude)) = wander.parts.both() {
            of_sky.copy_from_slice(&self.read_sky(at, altitude, fix, seen));
        }
        if fix {
            let [mut east, mut north] = [position.x, position.y];
            if at.noise {
                let [short_east, short_north] = wander.parts.short().unwrap_or_default();
                let scale = self.scales(seen).horizontal;
                east += scale * (wander.error_m[0] + short_east + self.sigma_m * stream.normal());
                north += scale * (wander.error_m[1] + short_north + self.sigma_m * stream.normal());
            }
            wander.position_deg = degrees(at.scene.surroundings.origin_deg, east, north);
        }
        let [latitude, longitude] = wander.position_deg;
        if !fix {
            of_place.copy_from_slice(&[latitude, longitude, 0.0, 0.0, 0.0]);
            return Effect::NONE;
        }
        let [speed, course] = self.motion(at, stream);
        of_place.copy_from_slice(&[latitude, longitude, 1.0, speed, course]);
        Effect::NONE
    }
}

impl Gps {
    /// Speed over ground, in m/s, and course, in radians.
    fn motion(&self, at: &Measurement<'_>, stream: &mut Stream) -> [f64; 2] {
        let noise = if at.noise && self.speed_sigma_m_s > 0.0 { stream.normal() } else { 0.0 };
        let speed = (at.over_ground().forward + self.speed_sigma_m_s * noise).abs();
        let backwards = if at.motion.speed_m_s < 0.0 { PI } else { 0.0 };
        [speed, angle::wrap(at.motion.pose.heading + backwards)]
    }

    /// The number of satellites above a point's horizon.
    fn satellites_seen(&self, surroundings: &Surroundings, position: Point) -> usize {
        match (surroundings.sky_at(position), self.satellites) {
            (false, _) => 0,
            (true, false) => SKY.len(),
            (true, true) => sky::above(surroundings.horizon_at(position)),
        }
    }

    /// The factors by which errors along an axis and of the altitude are larger than those along an axis under the open sky.
    fn scales(&self, seen: usize) -> Dilution {
        if !self.satellites {
            return Dilution { horizontal: 1.0, vertical: 0.0 };
        }
        let (open, here) = (Dilution::of(SKY.len()), Dilution::of(seen));
        Dilution {
            horizontal: here.horizontal / open.horizontal,
            vertical: SQRT_2 * here.vertical / open.horizontal,
        }
    }

    /// At the start the altitude's error is anything that it can be later.
    fn altitude(&self, stream: &Stream) -> Altitude {
        let mut stream = Stream::of(stream.key(), &["altitude"]);
        let errors_m =
            [self.wander_sigma_m, self.short_wander_sigma_m].map(|sigma_m| sigma_m * stream.normal());
        Altitude { errors_m, last_m: 0.0, stream }
    }

    /// Altitude, number of satellites, and HDOP, which is 0 without a fix.
    fn read_sky(&self, at: &Measurement<'_>, altitude: &mut Altitude, fix: bool, seen: usize) -> [f64; 3] {
        if fix {
            altitude.last_m = at.scene.surroundings.altitude_m;
            if at.noise {
                let white_m = self.sigma_m * altitude.stream.normal();
                altitude.last_m +=
                    self.scales(seen).vertical * (altitude.errors_m.iter().sum::<f64>() + white_m);
            }
        }
        let hdop = if fix { Dilution::of(seen).horizontal } else { 0.0 };
        [altitude.last_m, seen as f64, hdop]
    }

    /// All errors as they are now.
    fn wander_on(&self, wander: &mut Wander, now: SimTime, stream: &mut Stream) {
        let dt = now.since(core::mem::replace(&mut wander.last, now)) as f64 / SECOND_NS as f64;
        if dt == 0.0 {
            return;
        }
        let slow = (self.wander_sigma_m, self.wander_time_s);
        let fast = (self.short_wander_sigma_m, self.short_wander_time_s);
        if self.wander_sigma_m > 0.0 {
            wander_for(&mut wander.error_m, slow, dt, stream);
        }
        let (short, altitude) = wander.parts.both();
        if let Some(short) = short {
            wander_for(short, fast, dt, stream);
        }
        if let Some(Altitude { errors_m: [slow_m, fast_m], stream, .. }) = altitude {
            wander_for([slow_m], slow, dt, stream);
            wander_for([fast_m], fast, dt, stream);
        }
    }
}

/// A first-order Gauss–Markov process: exact for any time `dt` since the last fix.
fn wander_for<'a>(
    errors_m: impl IntoIterator<Item = &'a mut f64>,
    (sigma_m, time_s): (f64, f64),
    dt: f64,
    stream: &mut Stream,
) {
    let keep = math::exp(-dt / time_s);
    let fresh = sigma_m * math::sqrt(1.0 - keep * keep);
    for error in errors_m {
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
