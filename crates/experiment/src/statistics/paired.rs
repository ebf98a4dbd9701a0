//! Pairs: runs of two variants with the same seed, which differ less than runs with different ones.

use super::distribution::{NORMAL, beta_below, normal};

/// How likely pairs are to differ at least as unequally by chance, if both variants succeed equally often: McNemar's exact test,
/// two-sided, of the numbers of pairs in which only the first succeeded and only the second. Pairs in which both succeed
/// or fail tell nothing about that.
pub fn mcnemar(only_first: u64, only_second: u64) -> f64 {
    let (few, many) = (only_first.min(only_second) as f64, only_first.max(only_second) as f64);
    // If few or less of the binomial distribution of 1/2 come: I(1/2; many, few + 1).
    if few == many { 1.0 } else { (2.0 * beta_below(0.5, many, few + 1.0)).min(1.0) }
}

/// The number of pairs with which a mean difference is told from 0, at a level of 5 % on two sides, with this power, if
/// differences within pairs have this standard deviation. It is that of the normal approximation; Student's interval takes about two
/// pairs more.
///
/// `None` if the power is not from 0.5 to below 1, the difference is 0, or the deviation is negative.
pub fn pairs_for_difference(difference: f64, deviation: f64, power: f64) -> Option<u64> {
    if !((0.5..1.0).contains(&power) && deviation >= 0.0) {
        return None;
    }
    // The interval takes two.
    whole(((NORMAL + normal(power)) * deviation / difference).powi(2)).map(|pairs| pairs.max(2))
}

/// The number of pairs with which [`mcnemar`] tells two variants apart, at a level of 5 % on two sides, with this power, if only the
/// first and only the second succeeds in these shares of pairs. It is that of the normal approximation (Connor 1987); the
/// exact test has some hundredths less power.
///
/// `None` if the power is not from 0.5 to below 1, a share is negative, both make more than 1, or they are equal.
pub fn pairs_for_shares(only_first: f64, only_second: f64, power: f64) -> Option<u64> {
    let (sum, difference) = (only_first + only_second, only_first - only_second);
    if !((0.5..1.0).contains(&power) && only_first >= 0.0 && only_second >= 0.0 && sum <= 1.0) {
        return None;
    }
    let deviations = NORMAL * sum.sqrt() + normal(power) * (sum - difference * difference).sqrt();
    whole((deviations / difference).powi(2))
}

/// The next whole number, if there is one.
fn whole(pairs: f64) -> Option<u64> {
    (pairs < u64::MAX as f64).then_some(pairs.ceil() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mcnemars_test_is_the_binomial_one_of_pairs_that_differ() {
        // Fagerland, Lydersen and Laake 2013 have 0.0703 for 1 and 7; the others are scipy's binomtest.
        for (only_first, only_second, expected) in [
            (1, 7, 0.070_312_5),
            (7, 1, 0.070_312_5),
            (0, 5, 0.0625),
            (3, 3, 1.0),
            (3, 4, 1.0),
            (12, 30, 0.007_915_897_334_897),
            (400, 520, 8.549_170_923_884e-5),
            (0, 0, 1.0),
        ] {
            let p = mcnemar(only_first, only_second);
            assert!((p / expected - 1.0).abs() < 1e-9, "{only_first}, {only_second}: {p}");
        }
    }

    #[test]
    fn smaller_differences_take_more_pairs() {
        // By scipy's normal quantiles. The power of Student's interval is then 0.782 and 0.898 (scipy's nct).
        assert_eq!(pairs_for_difference(0.5, 1.0, 0.8), Some(32));
        assert_eq!(pairs_for_difference(-0.2, 1.0, 0.9), Some(263));
        assert_eq!(pairs_for_difference(1.0, 0.0, 0.9), Some(2));
        // The power of the exact test is then 0.774, 0.882, 0.882 and 0.795 (200,000 drawn tables each).
        assert_eq!(pairs_for_shares(0.2, 0.1, 0.8), Some(234));
        assert_eq!(pairs_for_shares(0.05, 0.2, 0.9), Some(113));
        assert_eq!(pairs_for_shares(0.3, 0.1, 0.9), Some(101));
        assert_eq!(pairs_for_shares(0.1, 0.0, 0.8), Some(77));
    }

    #[test]
    fn what_no_number_of_pairs_shows_has_none() {
        for (difference, deviation, power) in [
            (0.0, 1.0, 0.8),
            (0.0, 0.0, 0.8),
            (1.0, -1.0, 0.8),
            (1.0, 1.0, 1.0),
            (1.0, 1.0, 0.4),
            (1.0, f64::NAN, 0.8),
        ] {
            assert_eq!(
                pairs_for_difference(difference, deviation, power),
                None,
                "{difference}, {deviation}, {power}"
            );
        }
        for (only_first, only_second, power) in [
            (0.1, 0.1, 0.8),
            (0.0, 0.0, 0.8),
            (-0.1, 0.2, 0.8),
            (0.6, 0.5, 0.8),
            (0.2, 0.1, 1.0),
            (f64::NAN, 0.1, 0.8),
        ] {
            assert_eq!(
                pairs_for_shares(only_first, only_second, power),
                None,
                "{only_first}, {only_second}, {power}"
            );
        }
    }
}
