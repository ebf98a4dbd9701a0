//! Ultrasound, the sonar of §1.2.2: GPRSim's model (§3.2.3), with the time that the sound takes.
//!
//! S = min dᵢ with probability p, and D_max (nothing heard) else; below D_min it is D_min. The microcontroller
//! that times the echo waits for it: a reading takes as long as the sound travels.
//!
//! Deviations. A target that is too small to be heard where it is can be told from a wall by its [`Echo`], which the notes
//! do not mention. With cross-talk on, a pulse that another robot sent in the last tick and that arrives while this
//! one listens is taken for the echo.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::{Direction, Fan, Ray, math};
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Rays, Sense, TIMED_BY_PROCESSOR, levels};
use super::style::Style;
use super::{Echo, Measurement, Mount};
use crate::random::Stream;
use crate::scene::Ping;
use crate::time::{SECOND_NS, SimTime};
use baudbot_fields::number::{Between, HalfOpening, Length, Micros, Millis, NotNegative, Number, Share};
use baudbot_fields::{FieldError, Path};

/// The model of a sonar.
#[derive(Clone, Debug, PartialEq)]
pub struct Sonar {
    /// The place and the direction.
    pub mount: Mount,
    /// The rays over its cone.
    pub fan: Fan,
    /// D_min, in metres.
    pub min_m: f64,
    /// D_max, in metres.
    pub max_m: f64,
    /// p: how likely an echo is heard.
    pub detection: f64,
    /// Speed of sound, in m/s.
    pub sound_m_s: f64,
    /// Time from the trigger until the echo's clock starts, in nanoseconds.
    pub holdoff_ns: u64,
    /// Echo time that stands for "nothing", in nanoseconds.
    pub timeout_ns: u64,
    /// Whether it hears the pulses of other robots.
    pub cross_talk: CrossTalk,
    /// The strength of the echoes that it hears; any, if this is left open.
    pub echo: Option<Echo>,
}

/// Whether a sonar and those of other robots disturb each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrossTalk {
    /// Each hears only itself.
    Off,
    /// A strange pulse is taken for the echo.
    On,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Opening angle of the cone.
    opening_rad: Number<HalfOpening>,
    /// Number of rays over the cone; about 3 in the notes.
    rays: Rays,
    /// D_min: smallest reading; nearer things are read as this. Range: to `max_m`.
    min_m: Number<NotNegative>,
    /// D_max: maximum range, and the reading when no echo is heard.
    max_m: Number<Length>,
    /// p: probability that an echo is heard. Only with noise.
    #[serde(default = "Number::<Share>::constant::<1>")]
    detection: Number<Share>,
    /// Speed of sound.
    #[serde(default = "Number::<Speed>::constant::<340>")]
    sound_m_s: Number<Speed>,
    /// Time from the trigger until the sensor listens.
    #[serde(default)]
    holdoff_us: Number<Micros<Between<0, 1_000_000>>>,
    /// Longest time for which the sensor listens. Default: the time of flight to `max_m` and back.
    timeout_ms: Option<Number<Millis<Timeout>>>,
    /// Cross-talk with sonars of other robots, which must have it, too: each takes the pulses of the other for
    /// echoes. A pulse is heard from the next tick on, for 30 ms.
    #[serde(default)]
    cross_talk: bool,
    /// Distance up to which a wide wall would be heard if the sensor listened long enough. With it, [small
    /// targets](#small-targets) are lost before `max_m`. Range: at least `max_m`.
    wall_range_m: Option<Number<Length>>,
}

type Speed = Between<1, 100_000>;

baudbot_fields::rules! {
    /// How long a sonar listens, in milliseconds.
    Timeout: Any, 1e-3, 1e6;
}

impl Sense for Sonar {
    const NAME: &str = "sonar";
    const PLACE: Place = Place::Mounted;
    const TILTS: bool = true;
    const STYLE: Style = Style::dot("#0072b2");
    const NO_CLOCK: Option<&str> = Some(TIMED_BY_PROCESSOR);
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let (max_m, sound_m_s) = (sheet.max_m.get(), sheet.sound_m_s.get());
        let echo_ms = 2.0 * max_m / sound_m_s * 1e3;
        let wall_range_m = sheet
            .wall_range_m
            .map(|range_m| path.within("wall_range_m", range_m.get(), max_m, 1e6))
            .transpose()?;
        if sheet.cross_talk && fit.mount.elevation_rad.is_some() {
            return Err(path
                .field("elevation_rad")
                .error("not with `cross_talk`: pulses are heard along level rays"));
        }
        if wall_range_m.is_some() && fit.mount.elevation_rad.is_some() {
            return Err(path
                .field("elevation_rad")
                .error("not with `wall_range_m`: small targets are those of level rays"));
        }
        let device = Self {
            mount: fit.mount,
            fan: Fan::new(sheet.opening_rad.get(), sheet.rays.get().into()),
            min_m: path.within("min_m", sheet.min_m.get(), 0.0, max_m)?,
            max_m,
            detection: sheet.detection.get(),
            sound_m_s,
            holdoff_ns: sheet.holdoff_us.get(),
            timeout_ns: match sheet.timeout_ms {
                Some(timeout) => timeout.get(),
                None => path.number::<Millis<Timeout>>("timeout_ms", echo_ms)?,
            },
            cross_talk: if sheet.cross_talk { CrossTalk::On } else { CrossTalk::Off },
            echo: wall_range_m.map(|range_m| Echo::new(range_m, sound_m_s)),
        };
        Ok(Built::new(device, levels(fit.bits, 1, 0.0, max_m)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "m")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn range_m(&self) -> Option<f64> {
        Some(self.max_m)
    }

    fn fan(&self) -> Option<&Fan> {
        Some(&self.fan)
    }

    /// The distance in metres into `values`; the effect has the time of flight.
    fn read(&self, at: &Measurement<'_>, _: &mut (), stream: &mut Stream, values: &mut [f64]) -> Effect {
        let heard = !at.noise || self.detection >= 1.0 || stream.uniform() < self.detection;
        let pose = self.mount.world_from_sensor(at);
        let viewpoint = self.mount.look(at, &pose, self.max_m);
        let nearest = match &self.echo {
            None => viewpoint.nearest(&pose, &self.fan),
            Some(echo) => echo.nearest(&viewpoint, &pose, &self.fan),
        };
        let mut nearest = nearest.filter(|_| heard);
        let ping = (self.cross_talk == CrossTalk::On).then(|| {
            let strange = self.strange_echo(at, &pose, nearest.unwrap_or(self.max_m));
            nearest = strange.or(nearest);
            Ping { robot: at.scene.own, from: pose.position, at: at.now + self.holdoff_ns }
        });
        values[0] = nearest.map_or(self.max_m, |d| d.clamp(self.min_m, self.max_m));
        let echo_ns = nearest.map_or(self.timeout_ns, |d| self.echo_ns(d).min(self.timeout_ns));
        Effect { wait_ns: self.holdoff_ns + echo_ns, ping }
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].clamp(self.min_m, self.max_m);
    }

    fn nothing(&self) -> Option<f64> {
        Some(self.max_m)
    }

    fn longest_wait_ns(&self) -> u64 {
        self.holdoff_ns + self.timeout_ns
    }
}

impl Sonar {
    /// Time for the way there and back, in nanoseconds.
    pub fn echo_ns(&self, distance_m: f64) -> u64 {
        (2.0 * distance_m.max(self.min_m) / self.sound_m_s * SECOND_NS as f64 + 0.5) as u64
    }

    /// The apparent distance because of a strange pulse, if that comes before the echo.
    fn strange_echo(&self, at: &Measurement<'_>, pose: &baudbot_geometry::Pose, echo_m: f64) -> Option<f64> {
        let start = at.now + self.holdoff_ns;
        let kappas = self.fan.kappas();
        let half_opening = kappas[kappas.len() - 1];
        let others = at.scene.frozen.pings.iter().filter(|ping| ping.robot != at.scene.own);
        let seeming = others.filter_map(|ping| {
            let way = ping.from - pose.position;
            let distance = way.norm();
            let bearing = math::atan2(way.y, way.x) - pose.heading;
            if baudbot_geometry::angle::wrap(bearing).abs() > half_opening {
                return None;
            }
            let ray =
                Ray { origin: pose.position, direction: Direction::from_angle(math::atan2(way.y, way.x)) };
            let blocked = at.scene.arena.seen(self.mount.height.layer).cast(&ray, distance).is_some();
            let arrival = ping.at + (distance / self.sound_m_s * SECOND_NS as f64) as u64;
            let after = arrival.since(start) as f64 / SECOND_NS as f64;
            (!blocked && arrival > start).then_some(0.5 * after * self.sound_m_s)
        });
        seeming.filter(|&d| d < echo_m && d >= self.min_m).reduce(f64::min)
    }
}

/// A pulse that was sent longer ago than this is heard by nobody any more: 10 m of way.
pub(crate) const PING_LASTS_NS: u64 = 30_000_000;

/// Whether a pulse may still be heard at `now`.
pub(crate) fn is_heard(ping: &Ping, now: SimTime) -> bool {
    now.since(ping.at) < PING_LASTS_NS
}
