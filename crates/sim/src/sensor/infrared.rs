//! Infra-red proximity sensor: Wahde 2016, §1.2.2, Eqs. (3.9)–(3.14) and (3.1); from measured samples (3.2); and as a meter of
//! the light around it.
//!
//! Deviations. The notes give a ray no reading if d > D; ARSim, which we follow, if d ≥ D. ρ is limited to 1
//! before the mean is taken (3.13), and the mean's noise is clamped to [0, 1], as in ARSim. One ray looks
//! straight ahead, where (3.11) would divide by 0 (ARSim then always reads 0). ARSim draws its noise once a
//! ray and keeps the last; the distribution is that of one draw, which is what we do.
//!
//! With samples (3.2) the ray that comes back first gives the reading, whatever its angle in the fan is: so the fan should be
//! as wide as the sensor sees well, and not as wide as it notices anything. The light around a sensor changes no reading of a
//! lit one: real ones subtract what they read with the emitter off, which may leave less than 0; here 0 is the least.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::{Fan, Pencil, math};
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Rays, Sense, levels};
use super::lookup::{Lookup, Sheet as LookupSheet};
use super::style::Style;
use super::{Measurement, Mount, light};
use crate::random::Stream;
use baudbot_fields::number::{HalfOpening, Length, NotNegative, Number, Positive, Sigma, Whole};
use baudbot_fields::{FieldError, Path};

/// The model of an IR sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Infrared {
    /// The place and the direction.
    pub mount: Mount,
    /// The N rays over the opening angle γ.
    pub fan: Fan,
    /// Range D, in metres.
    pub range_m: f64,
    /// The formula of a reading.
    pub model: InfraredModel,
    /// The steps of its own converter, if these are coarser than those of the codes that are sent.
    pub converter: Option<Converter>,
}

/// An analogue-to-digital converter with fewer bits than its results are sent in: the lower ones are 0, as in the values of a
/// Khepera, which are multiples of 4 and 1020 at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converter {
    /// The difference between neighbouring readings.
    step: f64,
    /// The number of steps of the largest reading.
    top: f64,
}

impl Converter {
    /// The difference between neighbouring readings, as a share of full scale.
    #[must_use]
    pub fn step(self) -> f64 {
        self.step
    }

    /// The reading that is nearest to a value in [0, 1].
    #[cold]
    #[inline(never)]
    fn convert(self, value: f64) -> f64 {
        math::floor(value / self.step + 0.5).min(self.top) * self.step
    }
}

/// The formula of an IR reading.
#[derive(Clone, Debug, PartialEq)]
pub enum InfraredModel {
    /// Equations (3.12) and (3.13).
    Phenomenological {
        /// c₁ of (3.13), in m².
        c1_m2: f64,
        /// c₂ of (3.13).
        c2: f64,
    },
    /// Interpolated between samples of a real sensor (3.2).
    Lookup(Lookup),
    /// The emitter is off: 1 in the dark, falling to 0 at so many lux, as a Khepera's ambient mode.
    Ambient {
        /// Light at which it reads 0.
        saturation_lux: f64,
        /// The opening angle for the surroundings, in radians; a fan of a single ray does not have one.
        opening_rad: f64,
    },
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Opening angle γ.
    opening_rad: Number<HalfOpening>,
    /// Number of rays N. A single ray points straight ahead.
    rays: Rays,
    /// Maximum range D.
    range_m: Number<Length>,
    /// c₁ of Eq. (3.13). Default: this, `lookup` or `ambient_saturation_lux`.
    c1_m2: Option<Number<NotNegative>>,
    /// c₂ of Eq. (3.13). Default: required with `c1_m2`.
    c2: Option<Number<NotNegative>>,
    /// Samples of a real sensor. Type: table, or the name of a
    /// [file](scenario.md#files-that-a-scenario-refers-to). Default: this, `c1_m2` or `ambient_saturation_lux`.
    lookup: Option<LookupSheet>,
    /// Illuminance at which the reading falls to 0. The sensor then measures the light around it, ambient and from
    /// lamps within `opening_rad`, and reads 1 in the dark. Default: this, `c1_m2` or `lookup`.
    ambient_saturation_lux: Option<Number<Positive>>,
    /// Short for `noise.multiplicative`, σ of Eq. (3.1).
    #[serde(default)]
    sigma: Number<Sigma>,
    /// Code of a reading of 1. A Thymio II sends 13 bits, but no code above 4505. Default: 2^`bits` − 1. Range: to
    /// 2^`bits` − 1; with `bits`.
    full_scale: Option<Number<Whole<1, { u64::MAX }>>>,
    /// Bits of the sensor's converter, if the lower bits of its codes are always 0: with 8 of 10 all codes are
    /// multiples of 4, and 1020 is the largest. Default: `bits`. Range: to `bits`; with `bits`.
    converter_bits: Option<Number<Whole<1, { u64::MAX }>>>,
}

impl Sense for Infrared {
    const NAME: &str = "ir";
    const PLACE: Place = Place::Mounted;
    const TILTS: bool = true;
    const STYLE: Style = Style::dot("#d55e00");
    type Sheet = Sheet;
    type Memory = ();

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let fan = Fan::new(sheet.opening_rad.get(), sheet.rays.get().into());
        let (multiplicative, range_m) = (sheet.sigma.get(), sheet.range_m.get());
        let (max, converter) = codes(path, &sheet, fit.bits)?;
        let encodings = levels(fit.bits, 1, 0.0, max);
        let device = Self { mount: fit.mount, fan, range_m, model: model(path, sheet)?, converter };
        if device.mount.elevation_rad.is_some()
            && !matches!(device.model, InfraredModel::Phenomenological { .. })
        {
            return Err(path.field("elevation_rad").error("goes with `c1_m2` and `c2` only"));
        }
        Ok(Built { multiplicative, ..Built::new(device, encodings) })
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "1")]
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

    /// The reading S in [0, 1], larger when nearer: the mean of the rays' readings (3.12).
    fn read(&self, at: &Measurement<'_>, _: &mut (), stream: &mut Stream, values: &mut [f64]) -> Effect {
        values[0] = match &self.model {
            InfraredModel::Phenomenological { c1_m2, c2 } => self.reflected(at, *c1_m2, *c2),
            InfraredModel::Lookup(lookup) => self.sampled(at, lookup, stream),
            InfraredModel::Ambient { saturation_lux, opening_rad } => {
                1.0 - light::illuminance(at, &self.mount, *opening_rad) / saturation_lux
            }
        };
        Effect::NONE
    }

    fn bound(&self, values: &mut [f64]) {
        values[0] = values[0].clamp(0.0, 1.0);
        if let Some(converter) = self.converter {
            values[0] = converter.convert(values[0]);
        }
    }
}

/// The reading that the largest code stands for, and the converter that makes the codes, if it is a coarser one.
fn codes(path: &Path, sheet: &Sheet, bits: Option<u8>) -> Result<(f64, Option<Converter>), FieldError> {
    let Some(bits) = bits else {
        let problem = "goes with `bits`, which is missing";
        path.refuse("full_scale", sheet.full_scale.is_some(), problem)?;
        path.refuse("converter_bits", sheet.converter_bits.is_some(), problem)?;
        return Ok((1.0, None));
    };
    let largest = (1_u64 << bits) - 1;
    let full_scale = sheet.full_scale.map_or(largest, Number::get);
    path.whole_within("full_scale", full_scale, 1, largest)?;
    let converter = |own_bits: Number<_>| {
        let own_bits = path.whole_within("converter_bits", own_bits.get(), 1, bits.into())?;
        let step = 1_u64 << (u64::from(bits) - own_bits);
        Ok(Converter { step: step as f64 / full_scale as f64, top: (full_scale / step) as f64 })
    };
    Ok((largest as f64 / full_scale as f64, sheet.converter_bits.map(converter).transpose()?))
}

fn model(path: &Path, sheet: Sheet) -> Result<InfraredModel, FieldError> {
    match (sheet.c1_m2, sheet.c2, sheet.lookup, sheet.ambient_saturation_lux) {
        (Some(c1), Some(c2), None, None) => {
            Ok(InfraredModel::Phenomenological { c1_m2: c1.get(), c2: c2.get() })
        }
        (None, None, Some(samples), None) => {
            Ok(InfraredModel::Lookup(samples.lookup(&path.field("lookup"))?))
        }
        (None, None, None, Some(lux)) => {
            Ok(InfraredModel::Ambient { saturation_lux: lux.get(), opening_rad: sheet.opening_rad.get() })
        }
        (Some(_), None, None, None) => Err(path.field("c2").error("goes with c1_m2 and is missing")),
        (None, Some(_), None, None) => Err(path.field("c1_m2").error("goes with c2 and is missing")),
        _ => Err(path.error("needs exactly one of: `c1_m2` with `c2`, `lookup`, `ambient_saturation_lux`")),
    }
}

impl Infrared {
    /// The mean (3.12) over the rays, each of which reads (3.13).
    fn reflected(&self, at: &Measurement<'_>, c1_m2: f64, c2: f64) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        let reading = |d: f64, cos_kappa: f64| {
            if d >= self.range_m {
                return 0.0;
            }
            // At d = 0 the quotient is infinite and the minimum 1, unless c₁ is 0 (0/0 is not a number, and
            // `min` then takes the other operand).
            (cos_kappa * (c1_m2 / (d * d) + c2)).min(1.0)
        };
        let mut sum = 0.0;
        if let Some(near) = at.near.as_ref().filter(|_| self.mount.elevation_rad.is_none()) {
            let forward = pose.direction();
            for relative in self.fan.relative().chunks(Pencil::RAYS) {
                let mut pencil = Pencil::new(pose.position, forward, relative, self.range_m);
                near.meet(&mut pencil, self.mount.height);
                for (d, kappa) in pencil.distances().iter().zip(relative) {
                    sum += reading(*d, kappa.cos);
                }
            }
        } else {
            let viewpoint = self.mount.look(at, &pose, self.range_m);
            viewpoint.each(&pose, &self.fan, |i, d| sum += reading(d, self.fan.cos_kappa(i)));
        }
        sum / self.fan.len() as f64
    }

    /// The distance L and the angle are those of the ray that comes back first; if none does, the reading is
    /// one of the samples at the largest distance. Between them it is (3.2).
    fn sampled(&self, at: &Measurement<'_>, lookup: &Lookup, stream: &mut Stream) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        let viewpoint = self.mount.look(at, &pose, self.range_m);
        if !lookup.has_angles() {
            let distance_m = viewpoint.nearest(&pose, &self.fan).unwrap_or(f64::INFINITY);
            return lookup.read(distance_m, 0.0, at.noise.then_some(stream));
        }
        let seen = self
            .fan
            .rays(pose.position, pose.direction())
            .filter_map(|ray| Some((ray, viewpoint.see(&ray)?)));
        let nearest = seen.reduce(|a, b| if b.1.distance_m < a.1.distance_m { b } else { a });
        let (distance_m, angle_rad) = nearest
            .map_or((f64::INFINITY, 0.0), |(ray, hit)| (hit.distance_m, viewpoint.incidence_rad(&ray, &hit)));
        lookup.read(distance_m, angle_rad, at.noise.then_some(stream))
    }
}
