//! Servos, which obey the width of a pulse.
//!
//! Source: Parallax, *Standard Servo (#900-00005)*: 0.75 ms to 2.25 ms are 0° to 180°; *Continuous Rotation Servo
//! (#900-00008)*: 1.3 ms is full speed clockwise, 1.5 ms stands, 1.7 ms is full speed counter-clockwise.

use serde::{Deserialize, Serialize};

use super::{Instant, Remark, Signal};

/// A kind of servo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ServoKind {
    /// A pulse is an angle.
    Standard,
    /// A pulse is a speed.
    Continuous,
}

/// Pulses that a servo obeys, in nanoseconds.
const WIDTHS_NS: core::ops::RangeInclusive<u64> = 500_000..=2_500_000;

/// A pulse that a servo obeys: 500 µs to 2500 µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pulse {
    /// The duration of the pulse, in nanoseconds.
    pub width_ns: u64,
    /// The instant at which it ended.
    pub at_ns: u64,
}

impl Pulse {
    /// The width of the pulse in microseconds.
    pub const fn width_us(self) -> f64 {
        self.width_ns as f64 / 1000.0
    }

    /// The angle that it means to a standard servo, in degrees from 0 to 180.
    pub fn degrees(self) -> f64 {
        ((self.width_us() - 750.0) * 180.0 / 1500.0).clamp(0.0, 180.0)
    }

    /// The speed that it means to a continuous servo, from −1 (full clockwise) to 1 (full counter-clockwise).
    pub fn speed(self) -> f64 {
        ((self.width_us() - 1500.0) / 200.0).clamp(-1.0, 1.0)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    kind: ServoKind,
    /// The cycle with which the pulse began.
    raised: Option<u64>,
    last: Option<Pulse>,
}

impl State {
    pub(crate) const fn new(kind: ServoKind) -> Self {
        Self { kind, raised: None, last: None }
    }

    pub(crate) const fn kind(&self) -> ServoKind {
        self.kind
    }

    pub(crate) fn is_possible(&self, kind: ServoKind, now: Instant<'_>) -> bool {
        let is_obeyed = |pulse: Pulse| WIDTHS_NS.contains(&pulse.width_ns) && pulse.at_ns <= now.ns();
        self.kind == kind
            && self.raised.is_none_or(|raised| raised <= now.cycle)
            && self.last.is_none_or(is_obeyed)
    }

    pub(crate) fn hear(&mut self, signal: Signal, at: Instant<'_>) -> Option<Remark> {
        if signal.is_high() {
            self.raised = self.raised.or(Some(at.cycle));
            return None;
        }
        let begun = self.raised.take()?;
        let width_ns = at.clock.ns(at.cycle - begun);
        if !WIDTHS_NS.contains(&width_ns) {
            return Some(Remark::OddServoPulse);
        }
        self.last = Some(Pulse { width_ns, at_ns: at.ns() });
        None
    }

    pub(crate) const fn last(&self) -> Option<Pulse> {
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_mean_angles_and_speeds() {
        let pulse = |width_ns| Pulse { width_ns, at_ns: 0 };
        assert_eq!(
            [750_000, 1_500_000, 2_250_000, 2_400_000].map(|ns| pulse(ns).degrees()),
            [0.0, 90.0, 180.0, 180.0]
        );
        assert_eq!(
            [1_300_000, 1_500_000, 1_600_000, 2_000_000].map(|ns| pulse(ns).speed()),
            [-1.0, 0.0, 0.5, 1.0]
        );
    }
}
