//! Gaussian noise, the form that the notes and ARSim use.

use crate::random::Stream;

/// Multiplicative noise, Eq. (3.1): the reading times N(1, σ). Draws nothing if σ is 0.
pub(crate) fn multiplicative(reading: f64, sigma: f64, stream: &mut Stream) -> f64 {
    if sigma == 0.0 { reading } else { reading * (1.0 + sigma * stream.normal()) }
}

/// Additive noise: the reading plus N(0, σ), in the reading's unit. Draws nothing if σ is 0.
pub(crate) fn additive(reading: f64, sigma: f64, stream: &mut Stream) -> f64 {
    if sigma == 0.0 { reading } else { reading + sigma * stream.normal() }
}
