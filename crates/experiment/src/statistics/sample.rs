//! Means, with the intervals that they are in.

use super::distribution::student;

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
}
