//! Optical flow: the sensor of a mouse, looking down, which counts how far it goes over the floor.
//!
//! From one read to the next it goes the way u along its own axes: the integral of the velocity v + ω × r of its mount,
//! turned into its own frame. With its resolution c it has then seen
//!
//! n = c (g u + N(0, σ² |u|)) + what was left
//!
//! counts along each axis, with the gain g of the specimen and the standard deviation σ after a metre. It tells whole
//! counts, as many as its registers hold, and what is left of them is for the next read.
//!
//! Deviations. The notes have no such sensor. A chip compares images, some thousand a second; here u comes from the poses
//! at the two reads, as if the speeds had been constant in between, so that more than half a turn would be taken for the
//! rest of it the other way round. Of several reads in a tick the first sees all of its way. Images of a floor that goes
//! by too fast have nothing in common, and what a chip then tells is not defined. Ours loses track if its mean speed was
//! too high, and tells no motion. That also holds for a robot that was put somewhere else by hand. The floor is the same
//! everywhere, and acceleration has no limit.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::{Pose, math, wheels};
use serde::{Deserialize, Serialize};

use super::kind::{Built, Component, Effect, Fit, LEAST_COUNTER_BITS, Place, Sense, counters};
use super::style::{Style, Symbol};
use super::{Measurement, Mount, noise};
use crate::random::Stream;
use crate::sound;
use crate::time::{SECOND_NS, SimTime};
use baudbot_fields::number::{Between, Number, Positive, Sigma};
use baudbot_fields::{FieldError, Path};

/// The model of an optical-flow sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct OpticalFlow {
    /// The place.
    pub mount: Mount,
    /// Its resolution.
    pub counts_per_m: f64,
    /// It loses track if it is faster.
    pub max_speed_m_s: f64,
    /// The least and the greatest count that its registers hold; beyond them they saturate.
    pub range_counts: [f64; 2],
    /// Standard deviation of a specimen's gain, N(1, σ).
    pub gain_spread: f64,
    /// Standard deviation of each axis after a metre of way, in metres; it grows as the root of the way.
    pub sigma_m: f64,
}

/// The pose of the sensor at its last read, and the motion that it has yet to report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Track {
    world_from_sensor: Pose,
    at: SimTime,
    gain: f64,
    /// Parts of counts.
    left: [f64; 2],
}

impl Track {
    pub(super) fn is_sound(&self) -> bool {
        sound::pose(&self.world_from_sensor) && sound::numbers(self.left.into_iter().chain([self.gain]))
    }
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Resolution, which is in a brain's data sheet. 400 counts per inch are 15,748 per metre.
    counts_per_m: Number<Between<1, 1_000_000>>,
    /// Mean speed since the last read above which the sensor has lost track and counts nothing.
    max_speed_m_s: Number<Positive>,
    /// Standard deviation of the specimen's gain, N(1, σ), drawn once per run.
    #[serde(default)]
    gain_spread: Number<Sigma>,
    /// Standard deviation of the error of each axis after a metre of travel. It grows with the square root of the
    /// distance.
    #[serde(default)]
    sigma_m: Number<Sigma>,
}

impl Sense for OpticalFlow {
    const NAME: &str = "optical-flow";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style { color: "#661100", symbol: Symbol::Square };
    const IS_ANALOG: bool = false;
    const LEAST_BITS: u64 = LEAST_COUNTER_BITS;
    const NO_CLOCK: Option<&str> =
        Some("it counts from one read to the next, and what a clock of its own holds would be counted twice");
    type Sheet = Sheet;
    type Memory = Box<Track>;

    fn new(sheet: Sheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let half = fit.bits.map_or(f64::INFINITY, |bits| (1_u64 << (bits - 1)) as f64);
        let device = Self {
            mount: fit.mount,
            counts_per_m: sheet.counts_per_m.get(),
            max_speed_m_s: sheet.max_speed_m_s.get(),
            range_counts: [-half, half - 1.0],
            gain_spread: sheet.gain_spread.get(),
            sigma_m: sheet.sigma_m.get(),
        };
        Ok(Built::new(device, counters(fit.bits)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("dx", "count"), Component::one("dy", "count")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn remember(&self, start: &Pose, stream: &mut Stream) -> Box<Track> {
        Box::new(Track {
            world_from_sensor: self.mount.place(start, &[]),
            at: SimTime::ZERO,
            gain: noise::additive(1.0, self.gain_spread, stream),
            left: [0.0; 2],
        })
    }

    /// Counts since the last read, along the sensor's heading and to the left of it.
    fn read(
        &self,
        at: &Measurement<'_>,
        track: &mut Box<Track>,
        stream: &mut Stream,
        values: &mut [f64],
    ) -> Effect {
        let world_from_sensor = self.mount.world_from_sensor(at);
        let way = wheels::arc(&track.world_from_sensor.inverse().compose(&world_from_sensor));
        // The scene, and the pose with it, is that of the tick's start.
        let seconds = at.tick_start.since(track.at) as f64 / SECOND_NS as f64;
        (track.world_from_sensor, track.at) = (world_from_sensor, at.tick_start);
        values.fill(0.0);
        if way.norm() > self.max_speed_m_s * seconds {
            return Effect::NONE;
        }
        let (gain, sigma) =
            if at.noise { (track.gain, self.sigma_m * math::sqrt(way.norm())) } else { (1.0, 0.0) };
        for ((value, left), way) in values.iter_mut().zip(&mut track.left).zip(way.iter()) {
            let seen = self.counts_per_m * noise::additive(gain * way, sigma, stream) + *left;
            *value = math::round(seen);
            *left = seen - *value;
        }
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        let [least, greatest] = self.range_counts;
        values.iter_mut().for_each(|value| *value = value.clamp(least, greatest));
    }
}
