//! Modules with a digital output: the voltage of a sensor beside one that a screw sets.
//!
//! The output is an open collector with a resistor to the supply, and changes a microsecond after the voltage does, which counts as at
//! once. Source: *LM393, LM2903 Dual Differential Comparators*, Texas Instruments, SLCS005; line and obstacle modules have one each.

use serde::Deserialize;

/// A voltage that a value of a sensor stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// The sensor's place.
    pub sensor: usize,
    /// The place of the value in its readings.
    pub value: usize,
    /// The voltage at the value 0, in volts.
    pub volts_at_0: f64,
    /// The rise for each unit of the value, in volts.
    pub volts_per_unit: f64,
}

impl Source {
    /// The voltage at a value, in volts.
    pub(crate) fn volts(&self, value: f64) -> f64 {
        self.volts_at_0 + self.volts_per_unit * value
    }
}

/// The side of the threshold on which the output of a comparator is low.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum LowWhen {
    /// Low where the voltage is below it.
    Below,
    /// Low where the voltage is above it.
    Above,
}

/// A comparator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparator {
    /// The voltage that it compares.
    pub source: Source,
    /// The voltage of the potentiometer, in volts.
    pub threshold_v: f64,
    /// The width of the band in which the output stays as it was, in volts: half on each side of the threshold.
    pub hysteresis_v: f64,
    /// When the output is low.
    pub low_when: LowWhen,
}

impl Comparator {
    /// Whether the output is low at a voltage, if it was or was not before.
    pub(crate) fn is_low(&self, volts: f64, was_low: bool) -> bool {
        let was_above = was_low == (self.low_when == LowWhen::Above);
        let half_v = self.hysteresis_v / 2.0;
        let is_above = volts > if was_above { self.threshold_v - half_v } else { self.threshold_v + half_v };
        is_above == (self.low_when == LowWhen::Above)
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    #[test]
    fn the_output_changes_beyond_the_band_and_stays_within_it() {
        for low_when in [LowWhen::Below, LowWhen::Above] {
            let source = Source { sensor: 0, value: 0, volts_at_0: 5.0, volts_per_unit: -5.0 };
            let comparator = Comparator { source, threshold_v: 2.0, hysteresis_v: 0.2, low_when };
            let mut is_low = low_when == LowWhen::Below;
            let mut outputs = Vec::new();
            for volts in [1.0, 2.05, 2.11, 1.95, 1.91, 1.89, 2.09] {
                is_low = comparator.is_low(volts, is_low);
                outputs.push(is_low == (low_when == LowWhen::Above));
            }
            assert_eq!(outputs, [false, false, true, true, true, false, false], "{low_when:?}");
            assert_eq!(source.volts(0.4), 3.0);
        }
    }
}
