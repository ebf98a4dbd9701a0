//! Laser range finder (§1.2.2, §3.2.3): Sᵢ is the distance dᵢ along ray i, or −1 if nothing is within range.
//!
//! The rays of a scan are taken one after the other while the mirror turns, so a robot that moves gets a scan
//! that is bent. The scene is frozen for a tick; within it the robot's own pose is carried on at its present
//! speed and turn rate to the instant of each ray.
//!
//! Deviation: 682 of 1024 steps are the URG-04LX's; the notes speak of 683 directions, which counts the step
//! after the last as well.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use baudbot_geometry::{Bundle, Carried, Fan, Twist, vectors};
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Rays, Sense, levels};
use super::style::Style;
use super::{Measurement, Mount};
use crate::random::Stream;
use crate::time::{SECOND_NS, SimTime};
use baudbot_fields::number::{Between, Length, Millis, NotNegative, Number, Opening};
use baudbot_fields::{FieldError, Path};

/// The model of a laser range finder.
#[derive(Clone, Debug, PartialEq)]
pub struct Laser {
    /// The place and the direction.
    pub mount: Mount,
    /// Its rays, from right to left.
    pub fan: Fan,
    /// Nearest distance that it can tell, in metres.
    pub min_m: f64,
    /// Range D, in metres.
    pub range_m: f64,
    /// Time from the first ray to the last, in nanoseconds.
    pub sweep_ns: u64,
    /// Whether it sweeps from left to right, as an RPLIDAR turns; the values then come in that order.
    pub clockwise: bool,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Angle between the first ray and the last. In a full turn the two coincide.
    opening_rad: Number<Opening>,
    /// Number of rays, and so of distances in a scan.
    rays: Rays,
    /// Smallest distance that is measured; nearer things are read as this. Range: to `range_m`.
    #[serde(default)]
    min_m: Number<NotNegative>,
    /// Maximum range D.
    range_m: Number<Length>,
    /// Time from the first ray to the last. Range: not longer than a period.
    #[serde(default)]
    sweep_ms: Number<Millis<Between<0, 1_000_000>>>,
    /// The laser sweeps from left to right, and its values are in that order.
    #[serde(default)]
    clockwise: bool,
}

impl Sense for Laser {
    const NAME: &str = "laser";
    const PLACE: Place = Place::Mounted;
    const TILTS: bool = true;
    const STYLE: Style = Style::dot("#009e73");
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let range_m = sheet.range_m.get();
        let device = Self {
            mount: fit.mount,
            fan: Fan::new(sheet.opening_rad.get(), sheet.rays.get().into()),
            min_m: path.within("min_m", sheet.min_m.get(), 0.0, range_m)?,
            range_m,
            sweep_ns: sheet.sweep_ms.get(),
            clockwise: sheet.clockwise,
        };
        let encodings = levels(fit.bits, device.rays(), -1.0, range_m);
        Ok(Built::new(device, encodings))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component { name: "", unit: "m", count: self.rays() }]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn range_m(&self) -> Option<f64> {
        Some(self.range_m)
    }

    fn fan(&self) -> Option<&Fan> {
        Some(&self.fan)
    }

    /// Takes all rays of a scan, as if it began now.
    fn read(&self, at: &Measurement<'_>, _: &mut (), _: &mut Stream, values: &mut [f64]) -> Effect {
        self.take(at, 0..values.len(), at.now, values);
        Effect::NONE
    }

    /// Noise makes no echo of nothing, and takes none nearer or farther than can be told.
    fn bound(&self, values: &mut [f64]) {
        let (least, most) = (self.min_m, self.range_m);
        vectors::each(values, move |value| {
            let bounded = if value < least { least } else { value };
            let bounded = if bounded > most { most } else { bounded };
            if value == NOTHING { NOTHING } else { bounded }
        });
    }

    fn nothing(&self) -> Option<f64> {
        Some(NOTHING)
    }

    fn unmeasured(&self, values: &mut [f64]) {
        values.fill(NOTHING);
    }
}

impl Laser {
    /// The number of a scan's rays.
    pub fn rays(&self) -> usize {
        self.fan.len()
    }

    /// When ray `i` of a scan that starts at `start` is taken.
    pub(super) fn instant(&self, start: SimTime, i: usize) -> SimTime {
        // The sweep times i over the gaps, of which no part is as large as that product.
        let gaps = self.gaps();
        let (each, rest) = (self.sweep_ns / gaps, self.sweep_ns % gaps);
        start + (each * i as u64 + rest * i as u64 / gaps)
    }

    /// When the rays from `first` on are taken, one after the other: [`instant`](Self::instant) without its divisions.
    fn instants(&self, start: SimTime, first: usize) -> impl Iterator<Item = SimTime> {
        let gaps = self.gaps();
        let (each, rest) = (self.sweep_ns / gaps, self.sweep_ns % gaps);
        let mut after = rest * first as u64 % gaps;
        let mut instant = self.instant(start, first);
        core::iter::repeat_with(move || {
            let this = instant;
            after += rest;
            let is_whole = after >= gaps;
            after -= if is_whole { gaps } else { 0 };
            instant = instant + (each + u64::from(is_whole));
            this
        })
    }

    /// The number of rays of a scan that starts at `start` which are taken before `end`.
    pub(super) fn taken_before(&self, start: SimTime, end: SimTime) -> usize {
        if self.sweep_ns == 0 {
            return if start < end { self.rays() } else { 0 };
        }
        let ray = (u128::from(end.since(start)) * u128::from(self.gaps())).div_ceil(self.sweep_ns.into());
        ray.min(self.rays() as u128) as usize
    }

    fn gaps(&self) -> u64 {
        self.rays().saturating_sub(1).max(1) as u64
    }

    /// Takes the rays `which` of a scan that started at `start`; all of them must fall into the tick.
    pub(super) fn take(&self, at: &Measurement<'_>, which: Range<usize>, start: SimTime, values: &mut [f64]) {
        if which.is_empty() {
            return;
        }
        if self.sweep_ns == 0 || at.over_ground() == Twist::default() {
            return self.read_at_once(at, which, start, values);
        }
        let mut rest = which;
        while !rest.is_empty() {
            let rays = rest.start..rest.end.min(rest.start + Bundle::MOST_RAYS);
            rest.start = rays.end;
            self.read_one_by_one(at, rays, start, values);
        }
    }

    /// A laser that is carried on while it sweeps takes each ray from a place of its own.
    fn read_one_by_one(&self, at: &Measurement<'_>, which: Range<usize>, start: SimTime, values: &mut [f64]) {
        let mut after_s = [0.0; Bundle::MOST_RAYS];
        let after_s = &mut after_s[..which.len()];
        for (after_s, instant) in after_s.iter_mut().zip(self.instants(start, which.start)) {
            *after_s = since_start_s(at, instant);
        }
        let values = &mut values[which.clone()];
        if self.clockwise {
            after_s.reverse();
        }
        let bundle = Bundle::new(&self.carried(at), &self.fan, self.places(which), after_s);
        self.mount.look(at, &bundle.pose(), self.range_m).sweep_bundle(&bundle, values);
        self.finish(values);
    }

    /// A laser that stands still, or sweeps in no time, takes all rays from one place.
    fn read_at_once(&self, at: &Measurement<'_>, which: Range<usize>, start: SimTime, values: &mut [f64]) {
        let pose = self.carried(at).place(since_start_s(at, self.instant(start, which.start)));
        let viewpoint = self.mount.look(at, &pose, self.range_m);
        let values = &mut values[which.clone()];
        viewpoint.sweep(&pose, &self.fan, self.places(which), values);
        self.finish(values);
    }

    /// Makes readings of distances that are in the order of the fan.
    fn finish(&self, values: &mut [f64]) {
        if self.clockwise {
            values.reverse();
        }
        vectors::each(values, |value| if value.is_infinite() { NOTHING } else { value });
    }

    /// The laser on its robot, which goes on at its present speed and turn rate from the start of the tick.
    fn carried(&self, at: &Measurement<'_>) -> Carried {
        Carried {
            robot: at.motion.pose,
            body: at.over_ground(),
            turret: self.mount.turned(at.actuators),
            sensor: self.mount.pose,
        }
    }

    /// The places of a scan's rays in the fan: the other way round if it sweeps so.
    fn places(&self, rays: Range<usize>) -> Range<usize> {
        if self.clockwise { self.rays() - rays.end..self.rays() - rays.start } else { rays }
    }
}

/// The reading of a ray that meets nothing within range.
pub(crate) const NOTHING: f64 = -1.0;

/// The time from the start of the tick to an instant, in seconds; no longer than the tick.
fn since_start_s(at: &Measurement<'_>, instant: SimTime) -> f64 {
    instant.min(at.tick_end).since(at.tick_start).cast_signed() as f64 / SECOND_NS as f64
}

#[cfg(test)]
mod tests;
