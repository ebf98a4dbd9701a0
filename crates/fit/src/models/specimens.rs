//! Gains and offsets of specimens that are known only by their spread: integrated over, by Laplace's method.
//!
//! Of a specimen's readings v = S g + o + noise, with g ~ N(1, σ_g) and o ~ N(0, σ_o), the most likely g and o are those of
//! a linear regression with that prior; the integral over them is the likelihood there, times the prior, over the square
//! root of the posterior's precision.

/// The spread of specimens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    pub(crate) gain: f64,
    pub(crate) offset: f64,
}

/// A specimen's most likely deviations, and the cost of having them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Specimen {
    /// The deviation of the gain, from 1.
    pub(crate) gain: f64,
    pub(crate) offset: f64,
    pub(crate) cost: f64,
}

/// The most likely specimen for some rows: what was expected, by how much the reading is above, and the weight, which is
/// one over the variance.
pub(crate) fn specimen(rows: impl Iterator<Item = (f64, f64, f64)>, spread: Spread) -> Specimen {
    // In units of the spreads the prior is standard normal.
    let (mut a, mut b, mut c, mut p, mut q) = (1.0, 0.0, 1.0, 0.0, 0.0);
    for (expected, above, weight) in rows {
        let (x, y) = (expected * spread.gain, spread.offset);
        a += weight * x * x;
        b += weight * x * y;
        c += weight * y * y;
        p += weight * x * above;
        q += weight * y * above;
    }
    let determinant = a * c - b * b;
    let (gain, offset) = ((c * p - b * q) / determinant, (a * q - b * p) / determinant);
    let cost = 0.5 * (gain * gain + offset * offset + determinant.ln());
    Specimen { gain: gain * spread.gain, offset: offset * spread.offset, cost }
}
