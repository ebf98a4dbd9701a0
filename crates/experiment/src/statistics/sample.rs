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
    /// All of these numbers.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sample = Self::default();
        values.into_iter().for_each(|value| sample.add(value));
        sample
    }

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
        let deviation = self.deviation()?;
        Some(student(self.count - 1) * deviation / (self.count as f64).sqrt())
    }

    /// The standard deviation of what the values were drawn from; it takes two numbers.
    pub fn deviation(&self) -> Option<f64> {
        let freedom = self.count.checked_sub(1).filter(|&freedom| freedom > 0)?;
        Some((self.squares / freedom as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_mean_is_students() {
        assert_eq!((Sample::default().mean(), Sample::default().half_width()), (None, None));
        let sample = Sample::of([2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]);
        assert_eq!(sample.mean(), Some(5.0));
        // The standard deviation is sqrt(32 / 7) = 2.13809, and t of 7 is 2.3646.
        let expected = 2.3646 * 2.13809 / 8.0_f64.sqrt();
        assert!((sample.half_width().unwrap() - expected).abs() < 1e-4, "{sample:?}");
    }
}
