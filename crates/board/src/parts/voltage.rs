//! A voltage at an input of the ADC: infrared range finders, light sensors, reflectance sensors with an analog output,
//! potentiometers, a battery behind a divider.

use serde::{Deserialize, Serialize};

const MICROVOLTS: f64 = 1e6;

/// A source of a voltage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Voltage {
    /// The fraction of the voltage at the pin: 1, or the ratio of a divider, R2 / (R1 + R2).
    pub ratio: f64,
}

impl Voltage {
    /// A source that is connected to the pin directly.
    pub const DIRECT: Self = Self { ratio: 1.0 };

    /// The voltage at the pin in microvolts. The protection diodes clip it to the supply.
    pub(crate) fn microvolts(self, volts: f64, supply_uv: u32) -> u32 {
        // NaN becomes 0.
        (libm::round(volts * self.ratio * MICROVOLTS) as u32).min(supply_uv)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voltage_is_divided_and_clipped_to_the_rails() {
        let divided = Voltage { ratio: 0.5 };
        assert_eq!(divided.microvolts(7.2, 5_000_000), 3_600_000);
        assert_eq!(divided.microvolts(12.0, 5_000_000), 5_000_000);
        assert_eq!(divided.microvolts(-1.0, 5_000_000), 0);
        assert_eq!(divided.microvolts(f64::NAN, 5_000_000), 0);
        assert_eq!(divided.microvolts(f64::INFINITY, 5_000_000), 5_000_000);
    }
}
