//! The shape of the signal at an output, without counting.

use super::mode::{Output, Slope, Top, Update};
use super::{Source, Timer};

impl Timer {
    /// Cycles in which an output is high, and cycles until it repeats, once what is buffered has been taken. None: the
    /// output is not connected, or the timer does not run by itself.
    pub(crate) fn shape(&self, channel: usize) -> Option<(u64, u64)> {
        let output = self.output(channel);
        let Source::Divided(division) = self.source() else { return None };
        if self.off || output == Output::Disconnected {
            return None;
        }
        let taken = if self.mode().update == Update::Immediate { self.compare } else { self.buffer };
        let top = match self.mode().top {
            Top::Fixed(top) => top,
            Top::CompareA => taken[0],
            Top::Capture => self.capture,
        };
        let (top, compare) = (u64::from(top), u64::from(taken[channel]));
        let period = match self.mode().slope {
            Slope::Single | Slope::Fast => top + 1,
            Slope::Dual => 2 * top.max(1),
        };
        let reached = compare <= top;
        let matched = match self.mode().slope {
            Slope::Single => 0,
            Slope::Fast => (compare + 1).min(period),
            Slope::Dual if !reached => period,
            Slope::Dual => (2 * compare).min(period),
        };
        let latched = if self.latches >> channel & 1 == 1 { period } else { 0 };
        let (high, period) = match output {
            Output::Toggle if reached => (period, 2 * period),
            Output::Disconnected | Output::Toggle => (latched, period),
            // A match without PWM sets or clears for good.
            Output::Clear | Output::Set if self.mode().slope == Slope::Single => (latched, period),
            Output::Clear => (matched, period),
            Output::Set => (period - matched, period),
        };
        Some((high * division, period * division))
    }
}
