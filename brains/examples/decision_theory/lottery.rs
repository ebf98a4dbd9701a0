//! Mixed consequences: (7.1), (7.5).

use thiserror::Error;

use crate::curve::Curve;

/// Consequences, each with its probability. The probabilities add up to 1.
///
/// A consequence is a number: an amount of money, or whatever a utility is a function of. Where utilities are given
/// outright, as in (7.6), they can stand for the amounts, and [`expected_payoff`](Self::expected_payoff) is U(c).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lottery {
    /// The outcomes: probability and amount.
    outcomes: Vec<(f64, f64)>,
}

/// A reason why there is no such lottery.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub(crate) enum LotteryError {
    /// A probability that is none.
    #[error("outcome {outcome}: its probability must be from 0 to 1, not {found}")]
    Probability {
        /// Place of the outcome, from 0.
        outcome: usize,
        /// The number given.
        found: f64,
    },
    /// An amount that is none.
    #[error("outcome {outcome}: its amount must be finite, not {found}")]
    Amount {
        /// Place of the outcome, from 0.
        outcome: usize,
        /// The number given.
        found: f64,
    },
    /// Something else can happen, or too much.
    #[error("the probabilities must add up to 1, not {found}")]
    Sum {
        /// The sum of the probabilities.
        found: f64,
    },
}

impl Lottery {
    /// A lottery of pairs of a probability and an amount.
    ///
    /// # Errors
    /// If a probability is not from 0 to 1, an amount is not finite, or the sum of probabilities is off by more
    /// than 10⁻⁹.
    pub(crate) fn new(outcomes: &[(f64, f64)]) -> Result<Self, LotteryError> {
        for (outcome, &(probability, amount)) in outcomes.iter().enumerate() {
            if !(0.0..=1.0).contains(&probability) {
                return Err(LotteryError::Probability { outcome, found: probability });
            }
            if !amount.is_finite() {
                return Err(LotteryError::Amount { outcome, found: amount });
            }
        }
        let found = outcomes.iter().fold(0.0, |sum, (probability, _)| sum + probability);
        if (found - 1.0).abs() > 1e-9 {
            return Err(LotteryError::Sum { found });
        }
        Ok(Self { outcomes: outcomes.to_vec() })
    }

    /// The expected payoff Σ pₖ cₖ: (7.1).
    pub(crate) fn expected_payoff(&self) -> f64 {
        self.expected_utility(|amount| amount)
    }

    /// The expected utility Σ pₖ u(cₖ): (7.5). What cannot happen does not count, whatever its utility.
    pub(crate) fn expected_utility(&self, utility: impl Fn(f64) -> f64) -> f64 {
        let possible = self.outcomes.iter().filter(|(probability, _)| *probability > 0.0);
        possible.map(|&(probability, amount)| probability * utility(amount)).sum()
    }

    /// The amount that, for certain, is worth as much as the lottery.
    pub(crate) fn certainty_equivalent(&self, curve: &Curve) -> f64 {
        curve.amount(self.expected_utility(|amount| curve.utility(amount)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lottery(outcomes: &[(f64, f64)]) -> Lottery {
        Lottery::new(outcomes).unwrap()
    }

    /// Two bets with the same odds, (7.1) and what follows: the second is worth more, and few people take it.
    #[test]
    fn bets_of_euros_and_of_fortunes() {
        assert_eq!(lottery(&[(0.5, 3.0), (0.5, -2.0)]).expected_payoff(), 0.5);
        assert_eq!(lottery(&[(0.5, 300_000.0), (0.5, -200_000.0)]).expected_payoff(), 50_000.0);
    }

    /// (7.6).
    #[test]
    fn crossing_the_street_is_worth_7_6() {
        let expected = lottery(&[(0.2, 5.0), (0.8, -10.0)]).expected_payoff();
        assert!((expected - -7.0).abs() < 1e-12, "{expected}");
    }

    #[test]
    fn what_is_no_lottery_is_refused_by_name() {
        let text = |outcomes: &[(f64, f64)]| Lottery::new(outcomes).unwrap_err().to_string();
        assert_eq!(
            text(&[(0.5, 1.0), (-0.5, 1.0)]),
            "outcome 1: its probability must be from 0 to 1, not -0.5"
        );
        assert_eq!(text(&[(f64::NAN, 1.0)]), "outcome 0: its probability must be from 0 to 1, not NaN");
        assert_eq!(text(&[(1.0, f64::INFINITY)]), "outcome 0: its amount must be finite, not inf");
        assert_eq!(text(&[(0.5, 1.0), (0.25, 1.0)]), "the probabilities must add up to 1, not 0.75");
        assert_eq!(text(&[]), "the probabilities must add up to 1, not 0");
    }

    #[test]
    fn the_risk_averse_take_less_for_certain_and_the_risk_prone_want_more() {
        let coin = lottery(&[(0.5, 100.0), (0.5, 0.0)]);
        let sure = |curve: Curve| coin.certainty_equivalent(&curve);
        assert!((sure(Curve::Linear { top: 100.0 }) - 50.0).abs() < 1e-12);
        assert!((sure(Curve::Power { top: 100.0, exponent: 0.5 }) - 25.0).abs() < 1e-9);
        assert!((sure(Curve::Power { top: 100.0, exponent: 2.0 }) - 5000.0_f64.sqrt()).abs() < 1e-9);
        assert!(sure(Curve::Exponential { top: 100.0, tolerance: 40.0 }) < 49.0);
        assert!(sure(Curve::Exponential { top: 100.0, tolerance: -40.0 }) > 51.0);
        // W = 100: the geometric mean of 200 and 100, less 100.
        assert!((sure(Curve::Logarithmic { wealth: 100.0 }) - (20_000.0_f64.sqrt() - 100.0)).abs() < 1e-9);
    }

    /// u is known up to a positive linear transformation: no decision depends on it.
    /// (7.5), with a utility that is scaled.
    #[test]
    fn another_scale_of_utility_changes_no_preference() {
        let curve = Curve::Exponential { top: 100.0, tolerance: 30.0 };
        let (a, b) = (lottery(&[(0.3, 90.0), (0.7, 10.0)]), lottery(&[(1.0, 25.0)]));
        let prefers = |scale: f64, offset: f64| {
            let utility = |amount| scale * curve.utility(amount) + offset;
            a.expected_utility(utility) > b.expected_utility(utility)
        };
        assert_eq!(prefers(1.0, 0.0), prefers(17.0, -4.0));
        assert_eq!(prefers(1.0, 0.0), a.certainty_equivalent(&curve) > 25.0);
    }
}
