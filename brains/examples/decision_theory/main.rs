//! Utility and rational decisions: the examples of Wahde 2016, chapter 7.
//!
//! ```sh
//! cargo run -p baudbot-brains --example decision_theory
//! ```
//!
//! A [`Lottery`] is a mixed consequence: amounts, each with its probability. Its expected payoff is (7.1), but its
//! worth to a person is its expected utility (7.5), and that depends on a [`Curve`], the utility of each amount. A
//! rational agent takes the action whose expected utility is [`greatest`].

mod curve;
mod lottery;
mod st_petersburg;

use baudbot_brains::decision::utility::greatest;
use curve::{Attitude, Curve};
use lottery::{Lottery, LotteryError};
use st_petersburg::{highest_fee, subjective_payoff};

fn main() -> Result<(), LotteryError> {
    bets()?;
    street()?;
    curves()?;
    st_petersburg();
    Ok(())
}

/// (7.1) and what follows.
fn bets() -> Result<(), LotteryError> {
    println!("A fair coin for a gain or a loss, and its expected payoff (7.1):");
    for (gain, loss) in [(3.0, -2.0), (300_000.0, -200_000.0)] {
        let payoff = Lottery::new(&[(0.5, gain), (0.5, loss)])?.expected_payoff();
        println!("  {gain:>7} or {loss:>7}: {payoff}");
    }
    Ok(())
}

/// The example of the street, (7.6) to (7.9).
fn street() -> Result<(), LotteryError> {
    let cross = Lottery::new(&[(0.2, 5.0), (0.8, -10.0)])?.expected_payoff();
    println!("\nTo cross the street has a utility of {cross} (7.6). To stay has by (7.9)");
    for (who, probability) in [("daring", 0.1), ("careful", 0.5)] {
        let stay = utility_of_equal(probability, 5.0, -10.0);
        let action = if greatest([cross, stay]) == Some(0) { "crosses" } else { "stays" };
        println!("  {stay:>5} for somebody {who}, who {action}");
    }
    Ok(())
}

/// The curves of (7.10), Fig. 7.1.
fn curves() -> Result<(), LotteryError> {
    println!("\n30 for certain, as good as a fair coin for 100 or nothing (7.10):");
    println!("  curve        u(25)  u(50)  u(75)  the coin  attitude");
    let coin = Lottery::new(&[(0.5, 100.0), (0.5, 0.0)])?;
    let through = [Curve::exponential_through(30.0, 0.5, 100.0), Curve::power_through(30.0, 0.5, 100.0)];
    let others = [Curve::Linear { top: 100.0 }, Curve::Logarithmic { wealth: 100.0 }];
    for curve in through.into_iter().flatten().chain(others) {
        let name = match curve {
            Curve::Linear { .. } => "linear",
            Curve::Exponential { .. } => "exponential",
            Curve::Power { .. } => "power",
            Curve::Logarithmic { .. } => "logarithmic",
        };
        let attitude = match curve.attitude() {
            Attitude::Averse => "averse to risk",
            Attitude::Neutral => "neutral",
            Attitude::Prone => "prone to risk",
        };
        let [a, b, c] = [25.0, 50.0, 75.0].map(|amount| curve.utility(amount));
        let sure = coin.certainty_equivalent(&curve);
        println!("  {name:<11}  {a:.3}  {b:.3}  {c:.3}  {sure:>8.3}  {attitude}");
    }
    Ok(())
}

/// The St Petersburg paradox, (7.2), (7.3).
fn st_petersburg() {
    println!("\nThe St Petersburg game: its expected payoff is infinite (7.2). The highest fee by (7.3) is");
    for wealth in [2.0, 10.0, 100.0, 1000.0, 1e6] {
        let fee = highest_fee(wealth).unwrap_or(f64::NAN);
        let more = subjective_payoff(wealth, fee + 0.01).unwrap_or(f64::NAN);
        println!("  {fee:>7.4} with {wealth}; a hundredth more makes it worth {more:.1e}");
    }
}

/// The utility of a consequence that a person values as much as a lottery of a better one, with `probability`, and else
/// a worse one: (7.8). This is how a utility function is found by asking.
fn utility_of_equal(probability: f64, better: f64, worse: f64) -> f64 {
    probability * better + (1.0 - probability) * worse
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The decision not to cross the street, (7.9), of a daring and of a careful person.
    /// The order of (7.7), by (7.8).
    #[test]
    fn the_daring_cross_the_street_and_the_careful_stay() {
        assert!((utility_of_equal(0.1, 5.0, -10.0) - -8.5).abs() < 1e-12);
        assert!((utility_of_equal(0.5, 5.0, -10.0) - -2.5).abs() < 1e-12);
    }

    /// 30 for certain is worth as much to C as a fair coin for 100 or nothing: (7.10).
    #[test]
    fn more_than_thirty_for_certain_are_better_than_the_coin_and_less_are_not() {
        let curve = Curve::exponential_through(30.0, 0.5, 100.0).unwrap();
        let coin = Lottery::new(&[(0.5, 100.0), (0.5, 0.0)]).unwrap();
        assert!((coin.expected_payoff() - 50.0).abs() < 1e-12);
        assert!((coin.certainty_equivalent(&curve) - 30.0).abs() < 1e-9);
        let utilities = |sure| [curve.utility(sure), coin.expected_utility(|amount| curve.utility(amount))];
        assert_eq!((greatest(utilities(35.0)), greatest(utilities(25.0))), (Some(0), Some(1)));
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
