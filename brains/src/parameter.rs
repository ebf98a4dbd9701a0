//! A brain's parameters as data, for command lines and help.

use std::ops::RangeInclusive;

/// One parameter of a brain whose parameters are a `P`.
pub(crate) struct Parameter<P> {
    pub(crate) name: &'static str,
    /// What it means, with its unit.
    pub(crate) meaning: &'static str,
    /// The values that make sense.
    pub(crate) range: RangeInclusive<f64>,
    pub(crate) field: fn(&mut P) -> &mut f64,
}

/// Motor signals. 1 is full voltage; some motors take more, and then nothing limits them.
pub(crate) const SIGNAL: RangeInclusive<f64> = -10.0..=10.0;

/// Probabilities, and other parts of a whole.
pub(crate) const PROBABILITY: RangeInclusive<f64> = 0.0..=1.0;
