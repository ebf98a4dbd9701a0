//! The tests of distributions accept what is right and reject what is wrong by 5 %.

use crate::common::statistics::{
    self, SAMPLES, assert_distributed, assert_rate, chi_squared, correlation, kolmogorov_smirnov, normal,
    rate,
};
use baudbot_sim::random::Stream;

fn draw(name: &str, draw: impl Fn(&mut Stream) -> f64) -> Vec<f64> {
    let mut stream = Stream::new(11, name);
    (0..SAMPLES).map(|_| draw(&mut stream)).collect()
}

#[test]
fn distribution_functions_are_those_of_the_tables() {
    let table = [
        (0.0, 0.5),
        (1.0, 0.841_344_746_068_543),
        (1.96, 0.975_002_104_851_780),
        (-3.0, 0.001_349_898_031_630),
        (6.0, 0.999_999_999_013_412),
        (9.0, 1.0),
        (-1e9, 0.0),
    ];
    for (x, expected) in table {
        let found = normal(2.0, 0.5)(2.0 + 0.5 * x);
        assert!((found - expected).abs() < 1e-12, "{found} at {x}, not {expected}");
    }
    let found = [-3.0, -1.0, 0.0, 2.0, 4.0].map(statistics::uniform(-2.0, 2.0));
    assert_eq!(found, [0.0, 0.25, 0.5, 1.0, 1.0]);
}

#[test]
fn normal_deviates_fit_their_own_distribution_and_none_that_is_wrong_by_5_percent() {
    let mut samples = draw("normal", |stream| 3.0 + 0.2 * stream.normal());
    assert!(kolmogorov_smirnov(&mut samples, normal(3.0, 0.2)).fits());
    for (mean, sigma) in [(3.0, 0.19), (3.0, 0.21), (3.01, 0.2), (2.99, 0.2)] {
        let outcome = kolmogorov_smirnov(&mut samples, normal(mean, sigma));
        assert!(!outcome.fits(), "N({mean}, {sigma}): {outcome:?}");
    }
}

#[test]
fn uniform_numbers_fit_their_own_distribution_and_none_that_is_wrong_by_5_percent() {
    let mut samples = draw("uniform", Stream::uniform);
    assert_distributed(&mut samples, |scale| statistics::uniform(0.0, scale));
    assert!(!kolmogorov_smirnov(&mut samples, normal(0.5, 12.0_f64.sqrt().recip())).fits());
}

#[test]
fn the_largest_distance_is_found_on_either_side_of_a_step() {
    let found = kolmogorov_smirnov(&mut [0.9, 0.1], statistics::uniform(0.0, 1.0));
    assert!((found.statistic - 0.4).abs() < 1e-15, "{found:?}");
    let found = kolmogorov_smirnov(&mut [0.7, 0.6], statistics::uniform(0.0, 1.0));
    assert!((found.statistic - 0.6).abs() < 1e-15, "{found:?}");
}

#[test]
fn one_in_a_thousand_that_is_right_is_rejected() {
    let mut stream = Stream::new(5, "chance");
    let (mut normals, mut counts) = (0, 0);
    for _ in 0..5000 {
        let mut samples: Vec<_> = (0..50).map(|_| stream.normal()).collect();
        normals += u32::from(!kolmogorov_smirnov(&mut samples, normal(0.0, 1.0)).fits());
        let mut dice = [0; 11];
        (0..200).for_each(|_| dice[stream.below(11) as usize] += 1);
        counts += u32::from(!chi_squared(&dice, &[1.0; 11]).fits());
    }
    // 5 are expected of each.
    assert!((1..=12).contains(&normals) && (1..=14).contains(&counts), "{normals}, {counts}");
}

#[test]
fn chi_squared_is_that_of_an_example() {
    // 44 and 56 of 100 tosses of a coin: 36/50 + 36/50.
    let outcome = chi_squared(&[44, 56], &[1.0, 1.0]);
    assert!((outcome.statistic - 1.44).abs() < 1e-12 && outcome.fits(), "{outcome:?}");
    // The tables have 29.588 for 10 degrees of freedom and 149.449 for 100.
    let critical = |n: usize| chi_squared(&vec![10; n + 1], &vec![1.0; n + 1]).critical;
    assert!((critical(10) - 29.588).abs() < 0.2, "{}", critical(10));
    assert!((critical(100) - 149.449).abs() < 0.2, "{}", critical(100));
}

#[test]
fn a_rate_that_is_wrong_by_5_percent_is_rejected() {
    let mut stream = Stream::new(11, "rate");
    let hits = (0..SAMPLES).filter(|_| stream.uniform() < 0.2).count() as u64;
    assert_rate(hits, SAMPLES as u64, 0.2);
    assert!(!rate(hits, SAMPLES as u64, 0.21).fits());
}

#[test]
fn a_die_that_is_loaded_by_5_percent_is_rejected() {
    let mut stream = Stream::new(11, "die");
    let mut counts = [0; 6];
    (0..SAMPLES).for_each(|_| counts[stream.below(6) as usize] += 1);
    assert!(chi_squared(&counts, &[1.0; 6]).fits(), "{counts:?}");
    assert!(!chi_squared(&counts, &[1.05, 1.0, 1.0, 1.0, 1.0, 1.0]).fits(), "{counts:?}");
}

#[test]
fn correlation_is_that_of_examples() {
    assert!((correlation(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)]) - 1.0).abs() < 1e-12);
    assert!((correlation(&[(0.0, 1.0), (1.0, -1.0), (2.0, 1.0)])).abs() < 1e-12);
    assert!((correlation(&[(0.0, 5.0), (1.0, 3.0), (2.0, 1.0)]) + 1.0).abs() < 1e-12);
}
