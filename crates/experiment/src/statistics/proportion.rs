//! Shares, with the intervals that they are in.

use super::distribution::NORMAL;

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
}
