//! Driving a distance by odometry: Wahde 2016, code listings 5.3 and 5.4, Eq. (5.1).
//!
//! A finite-state machine that makes one transition a step, as the listing does: it notes where it is (state
//! 0), drives with signals that shrink with the way that is left (1), and stops once little is left (2). It
//! drives straight on and never turns, whatever its heading.
//!
//! Deviation: the listing's robot always has an odometer reading. Ours waits, in state 0, until the first
//! one has come over the cable.

use baudbot_brain::{Action, Brain, Signals, Turn};

use crate::parameter::{PROBABILITY, Parameter, SIGNAL};
use crate::throttle::CommandThrottle;

/// Listing 5.3's parameters; the defaults are its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The distance to go, D of (5.1), in metres.
    pub distance_m: f64,
    /// Signal of both motors at the start, a of (5.1).
    pub signal_constant: f64,
    /// Part of the distance that may be left at the destination.
    pub threshold: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { distance_m: 1.0, signal_constant: 0.90, threshold: 0.02 }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "distance_m",
        meaning: "distance to go, in metres",
        range: 0.001..=1000.0,
        field: |p| &mut p.distance_m,
    },
    Parameter {
        name: "signal_constant",
        meaning: "signal of both motors at the start",
        range: SIGNAL,
        field: |p| &mut p.signal_constant,
    },
    Parameter {
        name: "threshold",
        meaning: "fraction of the distance that may remain at the destination",
        range: PROBABILITY,
        field: |p| &mut p.threshold,
    },
];

/// Name of the sensor that this brain needs, with the components `x_m`, `y_m` and `heading_rad`.
pub const ODOMETER: &str = "odometer";

/// A brain that drives a distance and stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Navigate {
    parameters: Parameters,
    state: State,
    /// `None` before the first turn.
    throttle: Option<CommandThrottle>,
}

/// The listing's states 0, 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Start,
    Moving { from: (f64, f64) },
    Arrived,
}

impl Navigate {
    /// A brain at its start.
    pub const fn new(parameters: Parameters) -> Self {
        Self { parameters, state: State::Start, throttle: None }
    }

    /// Whether it is at its destination and stands still from the next step on.
    pub const fn arrived(&self) -> bool {
        matches!(self.state, State::Arrived)
    }
}

impl Brain for Navigate {
    /// Listing 5.4, with the signal of (5.1).
    fn step(&mut self, turn: &Turn) -> Action {
        let throttle = self.throttle.get_or_insert_with(|| CommandThrottle::new(&turn.body));
        let Some(&[x, y, ..]) = turn.reading(ODOMETER).map(|reading| reading.values.as_slice()) else {
            return throttle.ask(turn);
        };
        let signal = match self.state {
            State::Start => {
                self.state = State::Moving { from: (x, y) };
                0.0
            }
            State::Moving { from } => {
                let Parameters { distance_m, signal_constant, threshold } = self.parameters;
                let (dx, dy) = (x - from.0, y - from.1);
                let moved = (dx * dx + dy * dy).sqrt();
                if (distance_m - moved).abs() < threshold * distance_m {
                    self.state = State::Arrived;
                }
                signal_constant * (distance_m - moved) / distance_m
            }
            State::Arrived => 0.0,
        };
        throttle.send(turn, Signals { left: signal, right: signal })
    }
}

#[cfg(test)]
mod tests {
    use baudbot_brain::{Body, Firmware, Protocol};

    use super::*;
    use crate::test_body::{body, turn};

    /// Signals for a robot whose odometer gives these positions, starting at (1, 2) and along a 3-4-5 triangle.
    fn signals(navigate: &mut Navigate, moved: &[f64]) -> Vec<f64> {
        let body = body(&[(ODOMETER, "odometer", 0.0)]);
        let step = |(tick, moved): (usize, &f64)| {
            let values = [1.0 + 0.6 * moved, 2.0 + 0.8 * moved, 0.3];
            let turn = turn(&body, tick as u64 * 20_000_000, &[Some(&values)]);
            let signals = navigate.step(&turn).signals.unwrap();
            assert_eq!(signals.left, signals.right);
            signals.left
        };
        moved.iter().enumerate().map(step).collect()
    }

    /// (5.1), with the numbers of listing 5.3.
    #[test]
    fn signals_shrink_with_the_way_that_is_left() {
        let mut navigate = Navigate::new(Parameters::default());
        let signals = signals(&mut navigate, &[0.0, 0.0, 0.5, 0.975]);
        assert_eq!(signals[..2], [0.0, 0.9]);
        assert!((signals[2] - 0.45).abs() < 1e-12);
        assert!(!navigate.arrived());
    }

    /// The order of lines in listing 5.4.
    #[test]
    fn the_step_that_arrives_still_drives_and_the_next_stands() {
        let mut navigate = Navigate::new(Parameters::default());
        let mut other = navigate.clone();
        let before = signals(&mut navigate, &[0.0, 0.985]);
        assert!((before[1] - 0.9 * 0.015).abs() < 1e-12 && navigate.arrived());
        // Once arrived it stays so, wherever it is pushed.
        assert_eq!(signals(&mut other, &[0.0, 0.985, 0.985, 0.2])[2..], [0.0, 0.0]);
    }

    #[test]
    fn beyond_the_destination_it_drives_back() {
        let mut navigate = Navigate::new(Parameters::default());
        assert!(signals(&mut navigate, &[0.0, 1.5])[1] < 0.0);
    }

    #[test]
    fn without_a_reading_it_waits_or_asks() {
        let first = |protocol, period_ns| {
            let body =
                Body { firmware: Firmware { protocol, period_ns }, ..body(&[(ODOMETER, "odometer", 0.0)]) };
            let mut navigate = Navigate::new(Parameters::default());
            let action = navigate.step(&turn(&body, 0, &[None]));
            assert_eq!(navigate.state, State::Start);
            assert_eq!(navigate.step(&turn(&body, 1_000_000, &[None])), Action::wait(), "the cable is taken");
            action
        };
        let framed = Protocol::Framed { ages: true };
        assert_eq!(first(framed, Some(20_000_000)), Action::wait());
        assert_eq!(first(framed, None), Action::poll());
        assert_eq!(first(Protocol::Khepera, None), Action::poll());
        assert_eq!(first(Protocol::Bare { gap_ns: 0 }, None), Action::drive(0.0, 0.0));
    }
}
