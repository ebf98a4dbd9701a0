//! Wandering: Wahde 2016, code listings 5.1 and 5.2.
//!
//! A finite-state machine that makes one transition a step, as the listing does: it drives on (state 0),
//! waits for its time to turn (1), turns on the spot until it is time to stop (2), and drives on again. The
//! probabilities are per step, so a brain that steps more seldom than the listing's 100 times a second turns
//! more seldom and for longer. What it has decided is sent as often as the cable wants it. It sees nothing; in a closed room it runs into the wall.
//!
//! A wart of the listing that we keep: its "left turn" drives the left wheel forwards and the right one backwards,
//! which turns the robot to its right. The difference is invisible with equal probabilities.

use baudbot_brain::{Action, Brain, Signals, Turn};

use crate::chance::Chance;
use crate::parameter::{PROBABILITY, Parameter, SIGNAL};
use crate::throttle::CommandThrottle;

/// Listing 5.1's parameters; the defaults are its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Signal of both motors when driving on.
    pub forward: f64,
    /// Size of the motors' signals when turning.
    pub turn: f64,
    /// Probability, per step, that a turn begins.
    pub turn_probability: f64,
    /// Probability, per step, that a turn ends.
    pub stop_turn_probability: f64,
    /// Probability that a turn is a "left" one: left motor forwards.
    pub left_turn_probability: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            forward: 0.5,
            turn: 0.7,
            turn_probability: 0.01,
            stop_turn_probability: 0.03,
            left_turn_probability: 0.5,
        }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "forward",
        meaning: "signal of both motors when driving on",
        range: SIGNAL,
        field: |p| &mut p.forward,
    },
    Parameter {
        name: "turn",
        meaning: "magnitude of the motors' signals when turning",
        range: SIGNAL,
        field: |p| &mut p.turn,
    },
    Parameter {
        name: "turn_probability",
        meaning: "probability, per step, that a turn begins",
        range: PROBABILITY,
        field: |p| &mut p.turn_probability,
    },
    Parameter {
        name: "stop_turn_probability",
        meaning: "probability, per step, that a turn ends",
        range: PROBABILITY,
        field: |p| &mut p.stop_turn_probability,
    },
    Parameter {
        name: "left_turn_probability",
        meaning: "probability that a turn drives the left motor forwards",
        range: PROBABILITY,
        field: |p| &mut p.left_turn_probability,
    },
];

/// A brain that wanders blindly.
#[derive(Clone, Debug, PartialEq)]
pub struct Wander {
    parameters: Parameters,
    chance: Chance,
    state: State,
    signals: Signals,
    /// `None` before the first turn.
    throttle: Option<CommandThrottle>,
}

/// The listing's states 0, 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Forward,
    TimeToTurn,
    TimeToStopTurning,
}

impl Wander {
    /// A brain at its start; `chance` decides when it turns and which way.
    pub fn new(parameters: Parameters, chance: Chance) -> Self {
        Self { parameters, chance, state: State::Forward, signals: Signals::default(), throttle: None }
    }
}

impl Brain for Wander {
    fn step(&mut self, turn: &Turn) -> Action {
        let signals = self.decide();
        self.throttle.get_or_insert_with(|| CommandThrottle::new(&turn.body)).send(turn, signals)
    }
}

impl Wander {
    /// A transition: listing 5.2.
    fn decide(&mut self) -> Signals {
        let p = self.parameters;
        match self.state {
            State::Forward => {
                self.signals = Signals { left: p.forward, right: p.forward };
                self.state = State::TimeToTurn;
            }
            State::TimeToTurn => {
                if self.chance.happens(p.turn_probability) {
                    let left = if self.chance.happens(p.left_turn_probability) { p.turn } else { -p.turn };
                    self.signals = Signals { left, right: -left };
                    self.state = State::TimeToStopTurning;
                }
            }
            State::TimeToStopTurning => {
                if self.chance.happens(p.stop_turn_probability) {
                    self.state = State::Forward;
                }
            }
        }
        self.signals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: usize = 100_000;

    fn signals(parameters: Parameters) -> Vec<Signals> {
        let mut wander = Wander::new(parameters, Chance::new(3, "alice/wander"));
        (0..STEPS).map(|_| wander.decide()).collect()
    }

    /// Pieces of the run in which the signals stay the same.
    fn pieces(signals: &[Signals]) -> Vec<&[Signals]> {
        signals.chunk_by(|a, b| a == b).collect()
    }

    /// The probabilities of listings 5.1 and 5.2.
    #[test]
    fn turns_begin_end_and_divide_as_the_probabilities_say() {
        let signals = signals(Parameters::default());
        let pieces = pieces(&signals);
        assert_eq!(signals[0], Signals { left: 0.5, right: 0.5 });
        // A piece straight ahead is the step of state 0 and, on the average, 1/0.01 - 1 unlucky draws; a turn
        // is the draw that began it and 1/0.03 draws, the last of which leaves the signals as they are.
        let mean = |pieces: &[&[Signals]]| {
            pieces.iter().map(|p| p.len()).sum::<usize>() as f64 / pieces.len() as f64
        };
        let (straight, turns): (Vec<_>, Vec<_>) = pieces.into_iter().partition(|p| p[0].left == p[0].right);
        assert!((mean(&straight) - 100.0).abs() < 10.0, "{}", mean(&straight));
        assert!((mean(&turns) - (1.0 + 1.0 / 0.03)).abs() < 3.5, "{}", mean(&turns));
        let left = turns.iter().filter(|p| p[0] == Signals { left: 0.7, right: -0.7 }).count();
        let part = left as f64 / turns.len() as f64;
        assert!((part - 0.5).abs() < 0.06, "{part} of {}", turns.len());
    }

    /// The three states of listing 5.2.
    #[test]
    fn one_state_a_step() {
        let certain = Parameters {
            turn_probability: 1.0,
            stop_turn_probability: 1.0,
            left_turn_probability: 1.0,
            ..Parameters::default()
        };
        let signals = signals(certain);
        let (straight, left) = (Signals { left: 0.5, right: 0.5 }, Signals { left: 0.7, right: -0.7 });
        assert_eq!(signals[..6], [straight, left, left, straight, left, left]);
    }
}
