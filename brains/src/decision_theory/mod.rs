//! Utility and rational decisions: Wahde 2016, chapter 7.
//!
//! A [`Lottery`] is a mixed consequence: amounts, each with its probability. Its expected payoff is (7.1), but what
//! it is worth to somebody is its expected utility (7.5), and that depends on a [`Curve`], the utility of each
//! amount. A rational agent takes the action whose expected utility is largest: [`choose`].
//!
//! ```
//! use baudbot_brains::decision_theory::{Curve, Lottery, choose};
//!
//! // 30 for certain is worth as much to C as a fair coin for 100 or nothing: (7.10).
//! let curve = Curve::exponential_through(30.0, 0.5, 100.0).ok_or("no such curve")?;
//! let coin = Lottery::new(&[(0.5, 100.0), (0.5, 0.0)])?;
//! assert!((coin.expected_payoff() - 50.0).abs() < 1e-12);
//! assert!((coin.certainty_equivalent(&curve) - 30.0).abs() < 1e-9);
//! // So 35 for certain is better than the coin, and 25 is not.
//! let utilities = |sure| [curve.utility(sure), coin.expected_utility(|amount| curve.utility(amount))];
//! assert_eq!((choose(&utilities(35.0)), choose(&utilities(25.0))), (Some(0), Some(1)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The St Petersburg paradox, (7.2) and (7.3), is in [`st_petersburg`].

mod curve;
mod lottery;
pub mod st_petersburg;

pub use curve::{Attitude, Curve};
pub use lottery::{Lottery, LotteryError};

/// The place of the largest utility, of equal ones the first: what a rational agent does (§7.2), and (7.13). `None`
/// if there is none; what is not a number is never chosen.
///
/// ```
/// use baudbot_brains::decision_theory::choose;
/// assert_eq!(choose(&[0.1, 0.7, 0.7, -2.0]), Some(1));
/// assert_eq!(choose(&[]), None);
/// ```
pub fn choose(utilities: &[f64]) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (i, &utility) in utilities.iter().enumerate() {
        if !utility.is_nan() && best.is_none_or(|(_, largest)| utility > largest) {
            best = Some((i, utility));
        }
    }
    best.map(|(i, _)| i)
}

/// The utility of a consequence that somebody likes neither more nor less than a lottery of a better one, with
/// `probability`, and else a worse one: (7.8). This is how a utility function is found by asking.
///
/// ```
/// use baudbot_brains::decision_theory::utility_of_equal;
/// // Not to cross the street, (7.9), for somebody daring and for somebody careful.
/// assert!((utility_of_equal(0.1, 5.0, -10.0) - -8.5).abs() < 1e-12);
/// assert!((utility_of_equal(0.5, 5.0, -10.0) - -2.5).abs() < 1e-12);
/// ```
pub fn utility_of_equal(probability: f64, better: f64, worse: f64) -> f64 {
    probability * better + (1.0 - probability) * worse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_the_best_is_chosen() {
        assert_eq!(choose(&[f64::NAN, -3.0, -2.0, f64::NAN, -2.0]), Some(2));
        assert_eq!(choose(&[f64::NAN]), None);
        assert_eq!(choose(&[f64::NEG_INFINITY]), Some(0));
    }

    /// Axiom 4, of which expected utility makes use: mixing both sides with the same third changes no preference.
    #[test]
    fn preferences_do_not_depend_on_what_both_sides_share() {
        let curve = Curve::Power { top: 100.0, exponent: 0.5 };
        let utility = |outcomes: &[(f64, f64)]| {
            Lottery::new(outcomes).unwrap().expected_utility(|amount| curve.utility(amount))
        };
        for (a, b, c) in [(50.0, 20.0, 80.0), (3.0, 70.0, 0.0), (10.0, 10.0, 40.0)] {
            let alone = curve.utility(a).total_cmp(&curve.utility(b));
            for p in [0.1, 0.5, 0.9] {
                let mixed = utility(&[(p, a), (1.0 - p, c)]).total_cmp(&utility(&[(p, b), (1.0 - p, c)]));
                assert_eq!(alone, mixed, "{a} {b} {c} {p}");
            }
        }
    }
}
