//! The St Petersburg paradox: (7.2), (7.3).
//!
//! A fair coin is tossed until it shows heads, after k tosses, and the player gets 2ᵏ. Each k adds 1 to the expected
//! payoff, so that is infinite, and yet people pay little to play. By Bernoulli, an amount is worth its logarithm to a
//! person who has W; then the game is worth a small fee.

use crate::curve::Curve;

/// The subjective value P_s of playing for a fee r, of a person who has W: (7.3). `None` unless W is positive and
/// something is left after the fee and the smallest prize, W − r + 2 > 0.
pub(crate) fn subjective_payoff(wealth: f64, fee: f64) -> Option<f64> {
    let possible = wealth > 0.0 && wealth.is_finite() && wealth - fee + 2.0 > 0.0 && fee.is_finite();
    possible.then(|| payoff(wealth, fee, TERMS))
}

/// The largest fee at which playing is worth something, or at least nothing: where P_s is 0. `None` unless W is
/// positive.
pub(crate) fn highest_fee(wealth: f64) -> Option<f64> {
    if !(wealth > 0.0 && wealth.is_finite()) {
        return None;
    }
    // P_s falls with the fee: from something positive, as all prizes are, to −∞ at W + 2.
    let (mut low, mut high) = (0.0, wealth + 2.0);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Some(low);
        }
        match subjective_payoff(wealth, middle) {
            Some(payoff) if payoff >= 0.0 => low = middle,
            _ => high = middle,
        }
    }
}

/// The sum of this number of terms of (7.3).
fn payoff(wealth: f64, fee: f64, terms: usize) -> f64 {
    let curve = Curve::Logarithmic { wealth };
    let (mut prize, mut probability, mut sum) = (1.0, 1.0, 0.0);
    for _ in 0..terms {
        prize *= 2.0;
        probability *= 0.5;
        sum += probability * curve.utility(prize - fee);
    }
    sum
}

/// A term is about k 2⁻ᵏ: those from the 65th on are lost to rounding.
const TERMS: usize = 100;

#[cfg(test)]
mod tests {
    use super::*;

    /// The fee at which (7.3) is 0; the notes have 10.95 for W = 1,000.
    #[test]
    fn fees_are_the_known_ones() {
        let figures = [
            (2.0, 3.34757, 5e-6),
            (4.0, 4.0, 1e-12),
            (10.0, 4.97002, 5e-6),
            (100.0, 7.79210, 5e-6),
            (1000.0, 10.953_813_014_2, 1e-9),
            (1e4, 14.23859, 5e-6),
            (1e6, 20.87445, 5e-6),
        ];
        for (wealth, figure, within) in figures {
            let fee = highest_fee(wealth).unwrap();
            assert!((fee - figure).abs() < within, "{wealth}: {fee}");
        }
    }

    #[test]
    fn the_payoff_about_the_highest_fee() {
        let payoff = |fee| subjective_payoff(1000.0, fee).unwrap();
        assert!((payoff(10.95) - 3.818e-6).abs() < 5e-10, "{}", payoff(10.95));
        assert!((payoff(10.96) - -6.196e-6).abs() < 5e-10, "{}", payoff(10.96));
        assert!(payoff(0.0) > 0.0);
    }

    #[test]
    fn forty_five_terms_are_enough() {
        let off = payoff(1000.0, 10.0, 45) - payoff(1000.0, 10.0, TERMS);
        assert!(off.abs() < 1e-12, "{off}");
    }

    #[test]
    fn nobody_plays_who_could_be_left_with_nothing() {
        assert_eq!(subjective_payoff(10.0, 12.0), None);
        assert!(subjective_payoff(10.0, 11.999).unwrap() < 0.0);
        assert_eq!(
            (subjective_payoff(0.0, 1.0), highest_fee(-1.0), highest_fee(f64::NAN)),
            (None, None, None)
        );
        assert_eq!(subjective_payoff(1.0, f64::NAN), None);
    }
}
