//! A low-pass filter of first order: how fast a sensor can follow.

use baudbot_fields::number::{Number, Positive};
use baudbot_geometry::math;
use serde::{Deserialize, Serialize};

use crate::time::{SECOND_NS, SimTime};

/// State of the filter: its output and when that was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct LowPass {
    last: Option<(SimTime, f64)>,
}

impl LowPass {
    pub(super) fn is_sound(&self) -> bool {
        self.last.is_none_or(|(_, output)| crate::sound::numbers([output]))
    }

    /// The output at `now`, the input having been `input` since the last time. The first input passes as it is.
    pub(super) fn follow(&mut self, input: f64, time_constant_s: f64, now: SimTime) -> f64 {
        let output = match self.last {
            Some((then, before)) if time_constant_s > 0.0 => {
                let dt = now.since(then) as f64 / SECOND_NS as f64;
                input + (before - input) * math::exp(-dt / time_constant_s)
            }
            _ => input,
        };
        self.last = Some((now, output));
        output
    }
}

/// The time constant of a filter of this bandwidth in hertz; 0 if it has none.
pub(super) fn time_constant_s(bandwidth_hz: Option<Number<Positive>>) -> f64 {
    bandwidth_hz.map_or(0.0, |hz| 1.0 / (core::f64::consts::TAU * hz.get()))
}
