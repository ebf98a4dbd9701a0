//! Photoresistor, read through the time in which a capacitor loses its charge (RCTIME on a BASIC Stamp).
//!
//! The resistance falls with the light, R = R₁₀ (E / 10 lx)^−γ, and the capacitor falls from 5 V to the pin's
//! threshold of 1.4 V in t = R C ln(5/1.4) = 1.273 R C (Boe-Bot manual, ch. 6; BASIC Stamp manual, RCTIME). A counter
//! counts units of 2 µs until then (RCTIME: it is stopped as soon as the pin has changed), so that a part of a unit does not
//! count; it gives 1 at least, and 0 if the count does not fit. The
//! program waits all that time, in the dark up to 131 ms: a sensor that blocks the processor.

use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::TAU;

use baudbot_geometry::math;
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, TIMED_BY_PROCESSOR, levels};
use super::light::{self, LightSensor};
use super::lowpass::LowPass;
use super::style::Style;
use super::{Measurement, Mount};
use crate::random::Stream;
use baudbot_fields::{FieldError, Path};

/// The model of a photoresistor and its capacitor.
#[derive(Clone, Debug, PartialEq)]
pub struct Photoresistor {
    /// The surface and how slowly it follows.
    pub light: LightSensor,
    /// Resistance at 10 lux, in ohms.
    pub resistance_10lux_ohm: f64,
    /// Steepness γ of the resistance over the light.
    pub gamma: f64,
    /// Of the capacitor, in farads.
    pub capacitance_f: f64,
    /// Length of one count, in nanoseconds: 2 µs on a BASIC Stamp 2.
    pub unit_ns: u64,
    /// Counts after which the program gives up and reads 0.
    pub max_counts: u32,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Sheet {
    /// Lamps within it are seen. Range: 0 to 2π.
    #[serde(default = "light::half_turn")]
    opening_rad: f64,
    /// Time constant with which the resistance follows the light. Range: 0 to 1000.
    #[serde(default)]
    lag_s: f64,
    /// Resistance at 10 lx. Range: positive.
    resistance_10lux_ohm: f64,
    /// Steepness γ: the resistance at E lux is R₁₀ (E / 10 lx)^−γ. Range: positive.
    gamma: f64,
    /// Of the capacitor, in µF. Range: positive.
    capacitance_uf: f64,
    /// Length of a count. Range: 0.001 to 10^6.
    #[serde(default = "unit_us")]
    unit_us: f64,
    /// Where the count ends. Range: 1 to 2^32 − 1.
    #[serde(default = "max_counts")]
    max_counts: u64,
}

/// Shortest count, in microseconds: a nanosecond.
const LEAST_UNIT_US: f64 = 1e-3;

fn unit_us() -> f64 {
    2.0
}

fn max_counts() -> u64 {
    65_535
}

impl Sense for Photoresistor {
    const NAME: &str = "photoresistor";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#b58900");
    const NO_CLOCK: Option<&str> = Some(TIMED_BY_PROCESSOR);
    type Sheet = Sheet;
    type Memory = LowPass;

    fn new(sheet: Sheet, path: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let light = LightSensor {
            mount: fit.mount,
            opening_rad: path.within("opening_rad", sheet.opening_rad, 0.0, TAU)?,
            range_lux: f64::INFINITY,
            lag_s: path.within("lag_s", sheet.lag_s, 0.0, 1e3)?,
        };
        let max_counts = path.whole_within("max_counts", sheet.max_counts, 1, u64::from(u32::MAX))? as u32;
        let unit_ns = path.us("unit_us", sheet.unit_us, 1e6)?;
        if sheet.unit_us < LEAST_UNIT_US {
            return Err(path.field("unit_us").error("must be at least a nanosecond"));
        }
        let device = Self {
            light,
            resistance_10lux_ohm: path.positive("resistance_10lux_ohm", sheet.resistance_10lux_ohm)?,
            gamma: path.positive("gamma", sheet.gamma)?,
            capacitance_f: path.positive("capacitance_uf", sheet.capacitance_uf)? * 1e-6,
            unit_ns,
            max_counts,
        };
        Ok(Built::new(device, levels(path, fit.bits, 1, 0.0, f64::from(max_counts))?))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "count")]
    }

    fn acceptance_rad(&self) -> Option<f64> {
        Some(self.light.opening_rad)
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.light.mount)
    }

    /// Counts into `values`: few in bright light, 0 if it took too long. The effect has the time that it took.
    fn read(&self, at: &Measurement<'_>, filter: &mut LowPass, _: &mut Stream, values: &mut [f64]) -> Effect {
        let lux = light::illuminance(at, &self.light.mount, self.light.opening_rad);
        let lux = filter.follow(lux, self.light.lag_s, at.now);
        let counts = math::floor(self.decay_s(lux) * 1e9 / self.unit_ns as f64).max(1.0);
        let limit = f64::from(self.max_counts);
        values[0] = if counts > limit { 0.0 } else { counts };
        Effect { wait_ns: counts.min(limit) as u64 * self.unit_ns, ping: None }
    }

    /// Noise makes fractions of counts, which are rounded.
    fn bound(&self, values: &mut [f64]) {
        values[0] = math::round(values[0]).clamp(0.0, f64::from(self.max_counts));
    }

    fn longest_wait_ns(&self) -> u64 {
        u64::from(self.max_counts) * self.unit_ns
    }
}

impl Photoresistor {
    /// The time in which the capacitor falls to the threshold, in seconds.
    pub fn decay_s(&self, lux: f64) -> f64 {
        // In perfect darkness the resistance has no end.
        let resistance =
            self.resistance_10lux_ohm * math::exp(-self.gamma * math::ln((lux / 10.0).max(1e-12)));
        DECAY * resistance * self.capacitance_f
    }
}

/// ln(5 V / 1.4 V).
const DECAY: f64 = 1.272_965_675_813_121_6;
