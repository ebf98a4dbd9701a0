//! Photoresistor, read through the time in which a capacitor loses its charge (RCTIME on a BASIC Stamp).
//!
//! The resistance falls with the light, R = R₁₀ (E / 10 lx)^−γ, and the capacitor falls from 5 V to the pin's
//! threshold of 1.4 V in t = R C ln(5/1.4) = 1.273 R C (Boe-Bot manual, ch. 6; BASIC Stamp manual, RCTIME). The
//! program waits all that time, in the dark up to 131 ms: a sensor that blocks the processor.

use baudbot_geometry::math;

use super::light::{self, LightSensor};
use super::lowpass::LowPass;
use super::{Effect, Measurement};

/// What a photoresistor and its capacitor are.
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

impl Photoresistor {
    /// Counts into `values`: few in bright light, 0 if it took too long. The effect has the time that it took.
    pub(super) fn read(&self, at: &Measurement<'_>, filter: &mut LowPass, values: &mut [f64]) -> Effect {
        let lux = light::illuminance(at, &self.light.mount, self.light.opening_rad);
        let lux = filter.follow(lux, self.light.lag_s, at.now);
        let counts = math::floor(self.decay_s(lux) * 1e9 / self.unit_ns as f64).max(1.0);
        let limit = f64::from(self.max_counts);
        values[0] = if counts > limit { 0.0 } else { counts };
        Effect { wait_ns: counts.min(limit) as u64 * self.unit_ns, ping: None }
    }

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
