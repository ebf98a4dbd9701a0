//! Repeated measurements of a rate, each long enough to mean something.

use serde::{Deserialize, Serialize};

use crate::calibration;
use crate::process::Clock;

/// The duration and the number of measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Seconds of a repeat, about; the warm-up takes a quarter of it.
    pub seconds: f64,
    /// The number of repeats; at least 1.
    pub repeats: u32,
}

/// One repeat.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// The measured value, in the workload's unit.
    pub value: f64,
    /// Rounds a second of the [calibration loop](crate::calibration) just before.
    pub calibration_per_s: f64,
}

/// Runs `work` for a warm-up and then for each repeat, as many ticks at a time as make up a twentieth of a repeat. A
/// sample's value is ticks a second by the clock. `progress` gets the number of each repeat before it begins, from 1.
///
/// # Errors
/// The first of `work`.
pub fn rate<E>(
    effort: Effort,
    clock: Clock,
    mut progress: impl FnMut(u32),
    mut work: impl FnMut(u64) -> Result<(), E>,
) -> Result<Vec<Sample>, E> {
    let mut batch = 1;
    let (mut ticks, start_s) = (0, clock.now_s());
    let per_s = loop {
        work(batch)?;
        ticks += batch;
        let elapsed = clock.now_s() - start_s;
        if elapsed >= effort.seconds / 4.0 {
            break ticks as f64 / elapsed;
        }
        batch = ticks.min(MOST_TICKS);
    };
    let batch = ((per_s * effort.seconds / 20.0) as u64).max(1);
    let mut samples = Vec::new();
    for repeat in 1..=effort.repeats {
        progress(repeat);
        let calibration_per_s = calibration::rounds_per_second();
        let (mut ticks, start_s) = (0, clock.now_s());
        let value = loop {
            work(batch)?;
            ticks += batch;
            let elapsed = clock.now_s() - start_s;
            if elapsed >= effort.seconds {
                break ticks as f64 / elapsed;
            }
        };
        samples.push(Sample { value, calibration_per_s });
    }
    Ok(samples)
}

/// The most ticks between two looks at the clock in the warm-up.
const MOST_TICKS: u64 = 1 << 20;

/// The middle one, or the mean of the two in the middle; not a number if there are none.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<_> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[n / 2],
        n => f64::midpoint(values[n / 2 - 1], values[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    #[test]
    fn as_many_samples_as_repeats_and_every_tick_is_asked_for_in_batches() {
        let (mut ticks, mut heard) = (0, Vec::new());
        let effort = Effort { seconds: 1e-4, repeats: 3 };
        let samples = rate(
            effort,
            Clock::Wall,
            |repeat| heard.push(repeat),
            |batch| {
                ticks += batch;
                Ok::<_, Infallible>(())
            },
        );
        let samples = samples.unwrap();
        assert_eq!((samples.len(), heard), (3, vec![1, 2, 3]));
        assert!(ticks > 3, "{ticks}");
        assert!(
            samples.iter().all(|sample| sample.value > 0.0 && sample.calibration_per_s > 0.0),
            "{samples:?}"
        );
    }

    #[test]
    fn medians() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median([4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median([]).is_nan());
    }
}
