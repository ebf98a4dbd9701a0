//! Bounds and tails of distributions.

/// The bound below which 97.5 % of a t distribution with so many degrees of freedom lie: a table, and beyond it the
/// first terms of the expansion in 1 / ν about the normal distribution (Abramowitz and Stegun, 26.7.5).
pub(super) fn student(freedom: u64) -> f64 {
    if let Some(value) = usize::try_from(freedom - 1).ok().and_then(|i| STUDENT.get(i)) {
        return *value;
    }
    let (z, v) = (NORMAL, freedom as f64);
    let (z3, z5) = (z.powi(3), z.powi(5));
    z + (z3 + z) / (4.0 * v) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * v * v)
}

/// The bound below which 97.5 % of the normal distribution lie.
pub(super) const NORMAL: f64 = 1.959_963_985;

const STUDENT: [f64; 30] = [
    12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281, 2.2010, 2.1788, 2.1604,
    2.1448, 2.1314, 2.1199, 2.1098, 2.1009, 2.0930, 2.0860, 2.0796, 2.0739, 2.0687, 2.0639, 2.0595, 2.0555,
    2.0518, 2.0484, 2.0452, 2.0423,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_goes_over_into_the_expansion() {
        // The values are of tables: t of 40 is 2.0211, of 120 is 1.9799.
        for (freedom, expected) in [(30, 2.0423), (31, 2.0395), (40, 2.0211), (120, 1.9799)] {
            assert!((student(freedom) - expected).abs() < 1e-4, "{freedom}: {}", student(freedom));
        }
    }
}
