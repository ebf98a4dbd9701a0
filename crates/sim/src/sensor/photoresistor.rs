//! Photoresistor, read through the time in which a capacitor loses its charge (RCTIME on a BASIC Stamp).
//!
//! The resistance falls with the light, R = R₁₀ (E / 10 lx)^−γ, and the capacitor falls from 5 V to the pin's
//! threshold of 1.4 V in t = R C ln(5/1.4) = 1.273 R C (Boe-Bot manual, ch. 6; BASIC Stamp manual, RCTIME). A counter
//! counts units of 2 µs until then (RCTIME: it is stopped as soon as the pin has changed), so that a part of a unit does not
//! count; it gives 1 at least, and 0 if the count does not fit. The
//! program waits all that time, in the dark up to 131 ms: a sensor that blocks the processor.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::math;
use serde::Deserialize;

use super::kind::{Built, Component, Effect, Fit, Place, Sense, TIMED_BY_PROCESSOR, levels};
use super::light::{self, LightSensor};
use super::lowpass::LowPass;
use super::style::Style;
use super::{Measurement, Mount};
use crate::random::Stream;
use baudbot_fields::number::{Between, Micros, Number, Opening, Positive, Whole};
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
    /// Opening angle within which lamps are seen.
    #[serde(default = "light::half_turn")]
    opening_rad: Number<Opening>,
    /// Time constant with which the resistance follows the light.
    #[serde(default)]
    lag_s: Number<Between<0, 1000>>,
    /// Resistance at 10 lx.
    resistance_10lux_ohm: Number<Positive>,
    /// Steepness γ: the resistance at E lux is R₁₀ (E / 10 lx)^−γ.
    gamma: Number<Positive>,
    /// Capacitance of the capacitor, in µF.
    capacitance_uf: Number<Positive>,
    /// Length of a count.
    #[serde(default = "Unit::constant::<2>")]
    unit_us: Unit,
    /// Largest count. If it is exceeded, the measurement ends there and reads 0.
    #[serde(default = "Counts::constant::<65_535>")]
    max_counts: Counts,
}

type Unit = Number<Micros<UnitUs>>;
type Counts = Number<Whole<1, { u32::MAX as u64 }, u32>>;

baudbot_fields::rules! {
    /// The length of a count, in microseconds: a nanosecond at least.
    UnitUs: Any, 1e-3, 1e6;
}

impl Sense for Photoresistor {
    const NAME: &str = "photoresistor";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style::dot("#b58900");
    const NO_CLOCK: Option<&str> = Some(TIMED_BY_PROCESSOR);
    type Sheet = Sheet;
    type Memory = LowPass;

    fn new(sheet: Sheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let light = LightSensor {
            mount: fit.mount,
            opening_rad: sheet.opening_rad.get(),
            range_lux: f64::INFINITY,
            lag_s: sheet.lag_s.get(),
        };
        let max_counts = sheet.max_counts.get();
        let device = Self {
            light,
            resistance_10lux_ohm: sheet.resistance_10lux_ohm.get(),
            gamma: sheet.gamma.get(),
            capacitance_f: sheet.capacitance_uf.get() * 1e-6,
            unit_ns: sheet.unit_us.get(),
            max_counts,
        };
        Ok(Built::new(device, levels(fit.bits, 1, 0.0, f64::from(max_counts))))
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
