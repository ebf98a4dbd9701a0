//! The mean of a quantity over a step.

use serde::{Deserialize, Serialize};

/// The largest fraction, with what rounding adds to it.
const MOST: f64 = 1.0 + 1e-9;

/// A quantity that is constant between changes. Instants are cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Meter {
    value: f64,
    /// The value times cycles, from the step's start to the last change.
    sum: f64,
    begun: u64,
    changed: u64,
    mean: f64,
}

impl Meter {
    /// Whether this can be a fraction that was measured up to a cycle.
    pub(crate) fn is_possible(&self, now: u64) -> bool {
        (0.0..=MOST).contains(&self.value)
            && (0.0..=MOST).contains(&self.mean)
            && (0.0..=now as f64 * MOST).contains(&self.sum)
            && self.begun <= now
            && self.changed <= now
    }

    /// The quantity has another value from this cycle on.
    pub(crate) fn set(&mut self, value: f64, at: u64) {
        if value != self.value {
            self.sum += self.value * at.saturating_sub(self.changed) as f64;
            self.changed = at.max(self.changed);
            self.value = value;
        }
    }

    /// The step is over. A value that did not change is its mean without rounding.
    pub(crate) fn finish(&mut self, now: u64) {
        self.mean = if self.changed <= self.begun || now <= self.begun {
            self.value
        } else {
            let sum = self.sum + self.value * now.saturating_sub(self.changed) as f64;
            sum / (now - self.begun) as f64
        };
        (self.sum, self.begun, self.changed) = (0.0, now, now);
    }

    /// The mean over the last step.
    pub(crate) const fn mean(&self) -> f64 {
        self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_step_counts_each_value_by_its_time() {
        let mut meter = Meter::default();
        meter.set(1.0, 100);
        meter.set(0.5, 150);
        meter.finish(200);
        assert_eq!(meter.mean(), (50.0 + 25.0) / 200.0);
        meter.finish(300);
        assert_eq!(meter.mean(), 0.5);
    }

    #[test]
    fn a_constant_is_not_rounded() {
        let mut meter = Meter::default();
        meter.set(1.0 / 3.0, 0);
        for step in 1..100 {
            meter.finish(step * 16_001);
            assert_eq!(meter.mean(), 1.0 / 3.0);
        }
    }
}
