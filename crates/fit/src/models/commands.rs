//! Commands that are in force from one row to the next.

use super::motion::Segment;

/// The commands of a segment, looked at in the order of time.
pub(super) struct Commands<'a> {
    segment: &'a Segment,
    at: usize,
}

impl<'a> Commands<'a> {
    pub(super) fn new(segment: &'a Segment) -> Self {
        Self { segment, at: 0 }
    }

    /// The mean of the signals from one instant to another.
    pub(super) fn mean(&mut self, from: f64, to: f64) -> [f64; 2] {
        let times = &self.segment.times_s;
        while self.at + 1 < times.len() && times[self.at + 1] <= from {
            self.at += 1;
        }
        let (mut sum, mut row, mut begin) = ([0.0; 2], self.at, from);
        loop {
            let end = times.get(row + 1).map_or(to, |next| next.min(to));
            let share = (end - begin) / (to - from);
            for (sum, signal) in sum.iter_mut().zip(self.segment.signals[row]) {
                *sum += share * signal;
            }
            if end >= to {
                return sum;
            }
            begin = end;
            row += 1;
        }
    }
}
