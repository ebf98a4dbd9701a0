//! Shares, with the intervals that they are in.

use super::distribution::{NORMAL, beta};

/// The share of those that succeeded, and the interval that it is in by Wilson's method.
pub fn wilson(successes: u64, count: u64) -> Option<(f64, f64, f64)> {
    if count == 0 {
        return None;
    }
    let (n, share) = (count as f64, successes as f64 / count as f64);
    let square = NORMAL * NORMAL / n;
    let middle = (share + square / 2.0) / (1.0 + square);
    let half = NORMAL / (1.0 + square) * (share * (1.0 - share) / n + square / (4.0 * n)).sqrt();
    // The interval reaches the end if all or none succeeded, whatever the rounding.
    let low = if successes == 0 { 0.0 } else { middle - half };
    let high = if successes == count { 1.0 } else { middle + half };
    Some((share, low.max(0.0), high.min(1.0)))
}

/// The share of those that succeeded, and the exact interval that it is in (Clopper and Pearson 1934): whatever the share is in
/// truth, the interval misses it in at most 5 % of experiments, on each side in at most 2.5 %. It is wider than [`wilson`]'s,
/// which keeps to 5 % in the mean over shares. `None` if there are none, or more successes than runs.
pub fn clopper_pearson(successes: u64, count: u64) -> Option<(f64, f64, f64)> {
    let failures = count.checked_sub(successes).filter(|_| count > 0)?;
    let (s, f) = (successes as f64, failures as f64);
    let low = if successes == 0 { 0.0 } else { beta(TAIL, s, f + 1.0) };
    let high = if failures == 0 { 1.0 } else { beta(1.0 - TAIL, s + 1.0, f) };
    Some((s / count as f64, low, high))
}

/// The number of runs which, if none of them fails, shows with a confidence of 95 % that the share of failures is less than
/// this: the least n with (1 − share)ⁿ ≤ 5 %, about 3 / share. `None` unless the share lies between 0 and 1.
pub fn runs_without_failure(share: f64) -> Option<u64> {
    if !(share > 0.0 && share < 1.0) {
        return None;
    }
    // What is a whole number in truth may have come out a little larger.
    let runs = (0.05_f64.ln() / (-share).ln_1p() * (1.0 - 1e-12)).ceil();
    (runs < u64::MAX as f64).then_some(runs as u64)
}

/// What lies beyond an interval on each side.
const TAIL: f64 = 0.025;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_share_is_wilsons() {
        // Newcombe 1998, table I: 81 of 263, and 0 of 20.
        let (share, low, high) = wilson(81, 263).unwrap();
        assert!((share - 0.3080).abs() < 1e-4 && (low - 0.2553).abs() < 1e-4 && (high - 0.3662).abs() < 1e-4);
        let (_, low, high) = wilson(0, 20).unwrap();
        assert!(low == 0.0 && (high - 0.1611).abs() < 1e-4, "{high}");
        assert_eq!(wilson(10, 10).unwrap().2, 1.0);
        assert_eq!(wilson(0, 0), None);
    }

    #[test]
    fn the_exact_interval_of_a_share_is_clopper_and_pearsons() {
        // The values are scipy's; Newcombe 1998, table I, has the first, second and fourth to four digits.
        for (successes, count, low, high) in [
            (81, 263, 0.252_736_745_585, 0.367_621_922_601),
            (15, 148, 0.057_844_010_083, 0.161_650_490_349),
            (20, 20, 0.831_566_529_017, 1.0),
            (0, 20, 0.0, 0.168_433_470_983),
            (1, 29, 0.000_872_646_884, 0.177_644_295_488),
            (999_999, 1_000_000, 0.999_994_428_369, 0.999_999_974_682),
        ] {
            let (share, from, to) = clopper_pearson(successes, count).unwrap();
            assert_eq!(share, successes as f64 / count as f64);
            assert!(
                (from - low).abs() < 1e-9 && (to - high).abs() < 1e-9,
                "{successes} of {count}: {from}, {to}"
            );
        }
        assert_eq!((clopper_pearson(0, 0), clopper_pearson(2, 1)), (None, None));
    }

    #[test]
    fn so_many_runs_without_a_failure_show_that_failures_are_few() {
        for (share, expected) in [(0.5, 5), (0.1, 29), (0.05, 59), (0.01, 299), (0.001, 2995), (0.95, 1)] {
            assert_eq!(runs_without_failure(share), Some(expected), "{share}");
        }
        for share in [0.0, 1.0, -0.1, f64::NAN, 1e-300] {
            assert_eq!(runs_without_failure(share), None, "{share}");
        }
    }
}
