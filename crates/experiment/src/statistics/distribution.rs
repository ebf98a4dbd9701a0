//! Bounds and tails of distributions.

use std::f64::consts::SQRT_2;

/// The bound below which 97.5 % of a t distribution with so many degrees of freedom lie: a table, and beyond it the
/// first terms of the expansion in 1 / ν about the normal distribution (Abramowitz and Stegun, 26.7.5).
pub(crate) fn student(freedom: u64) -> f64 {
    if let Some(value) = usize::try_from(freedom - 1).ok().and_then(|i| STUDENT.get(i)) {
        return *value;
    }
    let (z, v) = (NORMAL, freedom as f64);
    let (z3, z5) = (z.powi(3), z.powi(5));
    z + (z3 + z) / (4.0 * v) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * v * v)
}

/// The bound below which a share of the normal distribution lies, of a share from 0.5 to below 1.
pub(super) fn normal(share: f64) -> f64 {
    bisected(0.0, 40.0, |z| libm::erfc(z / SQRT_2) / 2.0 > 1.0 - share)
}

/// The bound below which a share of the beta distribution of a and b lies.
pub(super) fn beta(share: f64, a: f64, b: f64) -> f64 {
    bisected(0.0, 1.0, |x| beta_below(x, a, b) < share)
}

/// The share of the beta distribution of a and b that lies below x: the regularised incomplete beta function, by its
/// continued fraction (Press et al., *Numerical Recipes*, third edition, 6.4). Of a and b of a million nine digits are right, of a
/// billion six.
pub(super) fn beta_below(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    let density = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * x.ln() + b * (-x).ln_1p();
    // The fraction converges soon on one side of the mean.
    if x < (a + 1.0) / (a + b + 2.0) {
        density.exp() / (a * fraction(x, a, b))
    } else {
        1.0 - density.exp() / (b * fraction(1.0 - x, b, a))
    }
}

/// 1 + d₁ x / (1 + d₂ x / (1 + …)) of the incomplete beta function, by the method of Lentz.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    let (mut value, mut c, mut d) = (1.0, 1.0, 0.0);
    for i in 1..MOST_TERMS {
        let m = f64::from(i / 2);
        let numerator = if i % 2 == 0 {
            m * (b - m) / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        d = 1.0 / not_zero(1.0 + numerator * x * d);
        c = not_zero(1.0 + numerator * x / c);
        value *= c * d;
        if (c * d - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

fn not_zero(value: f64) -> f64 {
    if value.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { value }
}

/// The place between two at which something ends that is true of all that lies lower.
fn bisected(mut low: f64, mut high: f64, is_low: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..MOST_HALVES {
        let middle = low.midpoint(high);
        *(if is_low(middle) { &mut low } else { &mut high }) = middle;
    }
    low.midpoint(high)
}

/// As many as a distribution of a billion takes: their number is some times the root of its parameters.
const MOST_TERMS: u32 = 200_000;

/// An interval of 1 becomes shorter than 1e-30.
const MOST_HALVES: u32 = 100;

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

    #[test]
    fn shares_below_a_bound_are_those_of_scipy() {
        for (x, a, b, expected) in [
            (0.5, 2.0, 3.0, 0.6875),
            (0.01, 1.0, 300.0, 0.950_959_105_928_714),
            (0.3, 250.0, 600.0, 0.649_941_238_019_237),
            (0.999, 5000.0, 3.0, 0.124_357_374_037_413),
            (1e-6, 1.0, 1e6, 0.632_120_742_768_355),
            (0.5, 0.5, 0.5, 0.5),
        ] {
            let share = beta_below(x, a, b);
            assert!((share - expected).abs() < 1e-9, "{x}, {a}, {b}: {share}");
            assert!((beta(expected, a, b) - x).abs() < 1e-9, "{x}, {a}, {b}: {}", beta(expected, a, b));
        }
        assert_eq!((beta_below(0.0, 2.0, 3.0), beta_below(1.0, 2.0, 3.0)), (0.0, 1.0));
        for (share, expected) in [(0.5, 0.0), (0.8, 0.841_621_233_573), (0.975, NORMAL)] {
            assert!((normal(share) - expected).abs() < 1e-9, "{share}: {}", normal(share));
        }
    }
}
