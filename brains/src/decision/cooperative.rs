//! Cooperative decisions, also called command fusion: the command is a weighted mean of what several behaviours suggest.
//! Wahde 2016, Section 8.1.1.
//!
//! ```text
//! s = Σᵢ wᵢ sᵢ / Σᵢ wᵢ
//! ```
//!
//! A weight is constant, or follows the state variables as a [utility](super::utility) does, of which the positive part counts. The
//! notes give no formula. That the weights are normalised, and that a robot stands still where none is positive, are choices: so no
//! command exceeds the largest suggestion, whatever the number of behaviours.
//!
//! Suggestions that contradict each other cancel: a behaviour that passes a pillar on the left and one that passes it on the right drive
//! straight at it together. An arbitration chooses one of them.

use baudbot_brain::Signals;

/// The weight of a behaviour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// The weight is always this.
    Constant(f64),
    /// The weight is this many times the positive part of the behaviour's utility.
    Utility(f64),
}

/// Behaviours that drive together.
#[derive(Clone, Debug, PartialEq)]
pub struct Cooperative {
    pub(crate) weights: Vec<Weight>,
    /// The weights of this step, divided by their sum.
    shares: Vec<f64>,
    /// The last suggestion of each behaviour.
    suggestions: Vec<Signals>,
}

impl Cooperative {
    /// Behaviours with these weights, none of which is negative.
    pub fn new(weights: Vec<Weight>) -> Self {
        let (shares, suggestions) = (vec![0.0; weights.len()], vec![Signals::default(); weights.len()]);
        Self { weights, shares, suggestions }
    }

    /// Weighs the behaviours, which have these utilities; the place of the one with the greatest weight.
    pub fn step(&mut self, utilities: impl IntoIterator<Item = f64>) -> usize {
        for ((share, weight), utility) in self.shares.iter_mut().zip(&self.weights).zip(utilities) {
            *share = match weight {
                Weight::Constant(weight) => *weight,
                Weight::Utility(times) => times * utility.max(0.0),
            };
        }
        let sum: f64 = self.shares.iter().sum();
        if sum > 0.0 {
            self.shares.iter_mut().for_each(|share| *share /= sum);
        }
        super::utility::greatest(self.shares.iter().copied()).unwrap_or_default()
    }

    /// One behaviour drives alone in this step.
    pub fn give_all_to(&mut self, behavior: usize) {
        self.shares.iter_mut().enumerate().for_each(|(place, share)| {
            *share = f64::from(u8::from(place == behavior));
        });
    }

    /// The behaviour's share of the command, in [0, 1].
    pub fn share(&self, behavior: usize) -> f64 {
        self.shares.get(behavior).copied().unwrap_or(0.0)
    }

    /// Takes in a behaviour's suggestion. It holds until the next one.
    pub fn suggest(&mut self, behavior: usize, signals: Signals) {
        if let Some(suggestion) = self.suggestions.get_mut(behavior) {
            *suggestion = signals;
        }
    }

    /// The command: all suggestions by their shares.
    pub fn command(&self) -> Signals {
        let mean = |side: fn(&Signals) -> f64| -> f64 {
            self.shares.iter().zip(&self.suggestions).map(|(share, signals)| share * side(signals)).sum()
        };
        Signals { left: mean(|signals| signals.left), right: mean(|signals| signals.right) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cooperative(weights: &[Weight], suggestions: &[(f64, f64)]) -> Cooperative {
        let mut decision = Cooperative::new(weights.to_vec());
        for (place, &(left, right)) in suggestions.iter().enumerate() {
            decision.suggest(place, Signals { left, right });
        }
        decision
    }

    #[test]
    fn the_command_is_the_mean_of_what_is_suggested_by_weights() {
        let mut decision = cooperative(
            &[Weight::Constant(3.0), Weight::Utility(2.0), Weight::Utility(1.0)],
            &[(0.5, 0.5), (1.0, -1.0), (-9.0, 9.0)],
        );
        assert_eq!(decision.step([-0.9, 0.5, -0.2]), 0);
        // 3 and 1 of 4; a utility that is not positive has no weight.
        assert_eq!(decision.command(), Signals { left: 0.625, right: 0.125 });
        assert_eq!([0, 1, 2, 3].map(|place| decision.share(place)), [0.75, 0.25, 0.0, 0.0]);
    }

    #[test]
    fn where_nothing_weighs_the_robot_stands() {
        let mut decision = cooperative(&[Weight::Utility(1.0)], &[(1.0, 1.0)]);
        decision.step([-0.5]);
        assert_eq!(decision.command(), Signals::default());
        decision.step([f64::NAN]);
        assert_eq!(decision.command(), Signals::default());
    }

    #[test]
    fn two_ways_round_a_pillar_cancel() {
        let mut decision =
            cooperative(&[Weight::Constant(1.0), Weight::Constant(1.0)], &[(0.1, 0.5), (0.5, 0.1)]);
        decision.step([0.0, 0.0]);
        assert_eq!(decision.command(), Signals { left: 0.3, right: 0.3 }, "straight on");
    }
}
