//! Tests of distributions, at a chance of 1 in 1000 to reject what is right. With fixed seeds what is right
//! stays right.
//!
//! A Kolmogorov–Smirnov test of 100,000 samples rejects a normal distribution whose standard deviation is
//! wrong by 5 %; with 10,000 it would not: so take [`SAMPLES`] of them.
//!
//! This file is a module of the unit tests, too (`#[path]` in `src/lib.rs`), and therefore does without
//! `std` and `alloc`.
#![allow(dead_code, unreachable_pub, reason = "each test uses some of it")]

use baudbot_geometry::math;

/// Samples that a Kolmogorov–Smirnov test should have.
pub const SAMPLES: usize = 100_000;

/// The result of a test.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// The larger, the worse the fit.
    pub statistic: f64,
    /// Larger statistics have a chance below 1 in 1000.
    pub critical: f64,
}

impl Outcome {
    pub fn fits(&self) -> bool {
        self.statistic <= self.critical
    }
}

/// The fit of the samples to the distribution function: the largest distance of theirs from it. Sorts them.
pub fn kolmogorov_smirnov(samples: &mut [f64], distribution: impl Fn(f64) -> f64) -> Outcome {
    samples.sort_unstable_by(f64::total_cmp);
    let n = samples.len() as f64;
    let distance = samples.iter().enumerate().map(|(i, &x)| {
        let expected = distribution(x);
        assert!((0.0..=1.0).contains(&expected), "the distribution function is {expected} at {x}");
        (expected - i as f64 / n).max((i + 1) as f64 / n - expected)
    });
    // The asymptotic critical value, with Stephens' correction for finite n.
    let root = math::sqrt(n);
    Outcome { statistic: distance.fold(0.0, f64::max), critical: 1.9495 / (root + 0.12 + 0.11 / root) }
}

/// The fit of counts to the expected ones, in proportion if the sums differ. Each should expect 5 or more.
pub fn chi_squared(counts: &[u64], expected: &[f64]) -> Outcome {
    assert_eq!(counts.len(), expected.len(), "as many counts as expectations");
    assert!(expected.iter().all(|&e| e > 0.0), "{expected:?}");
    let scale = counts.iter().sum::<u64>() as f64 / expected.iter().sum::<f64>();
    let terms = counts.iter().zip(expected).map(|(&count, &expected)| {
        let expected = expected * scale;
        assert!(expected >= 5.0, "too few to judge: {expected} expected");
        (count as f64 - expected) * (count as f64 - expected) / expected
    });
    Outcome { statistic: terms.sum(), critical: chi_squared_critical(counts.len() - 1) }
}

/// The fit of `hits` in `trials` to a probability.
pub fn rate(hits: u64, trials: u64, probability: f64) -> Outcome {
    chi_squared(&[hits, trials - hits], &[probability, 1.0 - probability])
}

/// The distribution function of N(mean, σ).
pub fn normal(mean: f64, sigma: f64) -> impl Fn(f64) -> f64 {
    move |x| standard_normal((x - mean) / sigma)
}

/// The distribution function of the uniform distribution.
pub fn uniform(min: f64, max: f64) -> impl Fn(f64) -> f64 {
    move |x| ((x - min) / (max - min)).clamp(0.0, 1.0)
}

/// Fails unless the samples fit `distribution(1)` and fit neither `distribution(0.95)` nor
/// `distribution(1.05)`: the argument scales what the test is about, say σ. So the test shows that it could
/// have failed.
#[track_caller]
pub fn assert_distributed<F: Fn(f64) -> f64>(samples: &mut [f64], distribution: impl Fn(f64) -> F) {
    let outcome = kolmogorov_smirnov(samples, distribution(1.0));
    assert!(outcome.fits(), "wrong distribution: {outcome:?}");
    for scale in [0.95, 1.05] {
        let outcome = kolmogorov_smirnov(samples, distribution(scale));
        assert!(!outcome.fits(), "cannot tell 1 from {scale}: {outcome:?}");
    }
}

/// Fails unless `hits` of `trials` fit the probability and do not fit one that is wrong by 5 %.
#[track_caller]
pub fn assert_rate(hits: u64, trials: u64, probability: f64) {
    let outcome = rate(hits, trials, probability);
    assert!(outcome.fits(), "{hits} of {trials} is not {probability}: {outcome:?}");
    for scale in [0.95, 1.05] {
        let outcome = rate(hits, trials, probability * scale);
        assert!(!outcome.fits(), "cannot tell {probability} from {scale} of it: {outcome:?}");
    }
}

/// Pearson's coefficient of correlation.
pub fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let mean_x = pairs.iter().map(|(x, _)| x).sum::<f64>() / n;
    let mean_y = pairs.iter().map(|(_, y)| y).sum::<f64>() / n;
    let sum = |f: fn(f64, f64) -> f64| pairs.iter().map(|(x, y)| f(x - mean_x, y - mean_y)).sum::<f64>();
    sum(|x, y| x * y) / math::sqrt(sum(|x, _| x * x) * sum(|_, y| y * y))
}

/// Marsaglia's series, which is good to 1e-15 where it is used.
fn standard_normal(x: f64) -> f64 {
    if x.abs() > 8.0 {
        return if x < 0.0 { 0.0 } else { 1.0 };
    }
    let (mut sum, mut before, mut term, mut i) = (x, 0.0, x, 1.0);
    while sum != before {
        before = sum;
        i += 2.0;
        term *= x * x / i;
        sum += term;
    }
    let density = math::exp(-0.5 * x * x) / math::sqrt(core::f64::consts::TAU);
    (0.5 + sum * density).clamp(0.0, 1.0)
}

/// The value that is exceeded with a chance of 1 in 1000: from tables, then Wilson and Hilferty's approximation,
/// which is within 2 % there.
fn chi_squared_critical(degrees_of_freedom: usize) -> f64 {
    const TABLE: [f64; 5] = [10.828, 13.816, 16.266, 18.467, 20.515];
    assert!(degrees_of_freedom > 0, "one count always fits");
    if let Some(&critical) = TABLE.get(degrees_of_freedom - 1) {
        return critical;
    }
    let k = degrees_of_freedom as f64;
    let root = 1.0 - 2.0 / (9.0 * k) + 3.0902 * math::sqrt(2.0 / (9.0 * k));
    k * root * root * root
}
