//! Means and shares with the intervals that they are in with a confidence of 95 %.

/// Numbers as they come, of which only what a mean and its interval need is kept (Welford's method).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Sample {
    /// Takes a number in.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let from_old = value - self.mean;
        self.mean += from_old / self.count as f64;
        self.squares += from_old * (value - self.mean);
    }

    /// The number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The mean of the values, if there are any.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then_some(self.mean)
    }

    /// Half the width of the interval about the mean, by Student's t distribution; it takes two numbers.
    pub fn half_width(&self) -> Option<f64> {
        let freedom = self.count.checked_sub(1).filter(|&freedom| freedom > 0)?;
        let variance = self.squares / freedom as f64;
        Some(student(freedom) * (variance / self.count as f64).sqrt())
    }
}

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

/// The bound below which 97.5 % of a t distribution with so many degrees of freedom lie: a table, and beyond it the
/// first terms of the expansion in 1 / ν about the normal distribution (Abramowitz and Stegun, 26.7.5).
fn student(freedom: u64) -> f64 {
    if let Some(value) = usize::try_from(freedom - 1).ok().and_then(|i| STUDENT.get(i)) {
        return *value;
    }
    let (z, v) = (NORMAL, freedom as f64);
    let (z3, z5) = (z.powi(3), z.powi(5));
    z + (z3 + z) / (4.0 * v) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * v * v)
}

/// The bound below which 97.5 % of the normal distribution lie.
const NORMAL: f64 = 1.959_963_985;

const STUDENT: [f64; 30] = [
    12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281, 2.2010, 2.1788, 2.1604,
    2.1448, 2.1314, 2.1199, 2.1098, 2.1009, 2.0930, 2.0860, 2.0796, 2.0739, 2.0687, 2.0639, 2.0595, 2.0555,
    2.0518, 2.0484, 2.0452, 2.0423,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_mean_is_students() {
        let mut sample = Sample::default();
        assert_eq!((sample.mean(), sample.half_width()), (None, None));
        for value in [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0] {
            sample.add(value);
        }
        assert_eq!(sample.mean(), Some(5.0));
        // The standard deviation is sqrt(32 / 7) = 2.13809, and t of 7 is 2.3646.
        let expected = 2.3646 * 2.13809 / 8.0_f64.sqrt();
        assert!((sample.half_width().unwrap() - expected).abs() < 1e-4, "{sample:?}");
    }

    #[test]
    fn the_table_goes_over_into_the_expansion() {
        // The values are of tables: t of 40 is 2.0211, of 120 is 1.9799.
        for (freedom, expected) in [(30, 2.0423), (31, 2.0395), (40, 2.0211), (120, 1.9799)] {
            assert!((student(freedom) - expected).abs() < 1e-4, "{freedom}: {}", student(freedom));
        }
    }

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
