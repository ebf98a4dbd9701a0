//! Numbers of a sample.

/// The summary of many values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The number of values.
    pub n: usize,
    /// The mean of the values.
    pub mean: f64,
    /// The standard deviation of the values; 0 for a single value.
    pub sd: f64,
    /// The least.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Sample {
    /// The numbers of these values; none of no values.
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len();
        let (first, count) = (*values.first()?, n as f64);
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        Some(Self {
            n,
            mean,
            sd: if n > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 },
            min: values.iter().copied().fold(first, f64::min),
            max: values.iter().copied().fold(first, f64::max),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Sample;

    #[test]
    fn a_sample_has_the_deviation_of_n_minus_1() {
        let sample = Sample::of(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).unwrap();
        assert_eq!((sample.n, sample.mean, sample.min, sample.max), (8, 5.0, 2.0, 9.0));
        assert!((sample.sd * sample.sd - 32.0 / 7.0).abs() < 1e-12);
        assert_eq!(Sample::of(&[]), None);
        assert_eq!(Sample::of(&[3.0]).unwrap().sd, 0.0);
    }
}
