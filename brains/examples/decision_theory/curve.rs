//! The utility of amounts: Fig. 7.1.
//!
//! The notes draw such a curve through points that a person was asked for, and give no formula for it. Two common ones
//! are here, each with the one number that a single question leaves open, and Bernoulli's logarithm, of (7.3).

use baudbot_geometry::math;

/// The utility u(x) of an amount x. But for [`Curve::Logarithmic`] nothing is worth 0 and `top` is worth 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Curve {
    /// The straight line x / top.
    Linear {
        /// The amount that is worth 1.
        top: f64,
    },
    /// (1 − e^(−x/R)) / (1 − e^(−top/R)): the same risk is disliked equally whatever one has.
    Exponential {
        /// The amount that is worth 1.
        top: f64,
        /// R, the risk tolerance, an amount. Negative for a person who likes risk; not 0.
        tolerance: f64,
    },
    /// (x / top)^exponent, for amounts of 0 and more.
    Power {
        /// The amount that is worth 1.
        top: f64,
        /// Below 1 for a person who dislikes risk; positive.
        exponent: f64,
    },
    /// ln(W + x) − ln W: Bernoulli's, in (7.3). What costs all that one has is worth −∞.
    Logarithmic {
        /// W, what one has before; positive.
        wealth: f64,
    },
}

/// An opinion of a risk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Attitude {
    /// Prefers the expected payoff for certain: u'' < 0.
    Averse,
    /// Does not care: u'' = 0.
    Neutral,
    /// Prefers the lottery: u'' > 0.
    Prone,
}

impl Curve {
    /// The exponential curve on which `amount` has this utility, and `top` has 1. `None` unless the amount is
    /// between 0 and `top` and the utility between 0 and 1.
    pub(crate) fn exponential_through(amount: f64, utility: f64, top: f64) -> Option<Self> {
        if !is_inside(amount, utility, top) {
            return None;
        }
        // The utility of the amount grows with k = 1 / R: from 0 over amount / top, at k = 0, to 1.
        let steepest = STEEPEST / amount;
        let (mut low, mut high) = (-steepest, steepest);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if exponential(amount, middle, top) < utility { low = middle } else { high = middle }
        }
        let tolerance = 1.0 / (0.5 * (low + high));
        Some(if tolerance.abs() > FLAT * top {
            Self::Linear { top }
        } else {
            Self::Exponential { top, tolerance }
        })
    }

    /// The power law on which `amount` has this utility, and `top` has 1. `None` as above.
    pub(crate) fn power_through(amount: f64, utility: f64, top: f64) -> Option<Self> {
        let exponent = math::ln(utility) / math::ln(amount / top);
        is_inside(amount, utility, top).then_some(Self::Power { top, exponent })
    }

    /// The utility u(x) of an amount.
    pub(crate) fn utility(&self, amount: f64) -> f64 {
        match *self {
            Self::Linear { top } => amount / top,
            Self::Exponential { top, tolerance } => exponential(amount, 1.0 / tolerance, top),
            Self::Power { top, exponent } => math::exp(exponent * math::ln(amount / top)),
            Self::Logarithmic { wealth } => math::ln((wealth + amount) / wealth),
        }
    }

    /// The amount of this utility: the inverse of [`utility`](Self::utility).
    pub(crate) fn amount(&self, utility: f64) -> f64 {
        match *self {
            Self::Linear { top } => utility * top,
            Self::Exponential { top, tolerance } => {
                -tolerance * math::ln(1.0 - utility * (1.0 - math::exp(-top / tolerance)))
            }
            Self::Power { top, exponent } => top * math::exp(math::ln(utility) / exponent),
            Self::Logarithmic { wealth } => wealth * (math::exp(utility) - 1.0),
        }
    }

    /// The opinion of risks that this curve stands for: the sign of u''.
    pub(crate) fn attitude(&self) -> Attitude {
        let bend = match *self {
            Self::Linear { .. } => 0.0,
            Self::Exponential { tolerance, .. } => -tolerance,
            Self::Power { exponent, .. } => exponent - 1.0,
            Self::Logarithmic { .. } => -1.0,
        };
        if bend < 0.0 {
            Attitude::Averse
        } else if bend > 0.0 {
            Attitude::Prone
        } else {
            Attitude::Neutral
        }
    }
}

/// The exponential curve with k = 1 / R.
fn exponential(amount: f64, k: f64, top: f64) -> f64 {
    if k == 0.0 { amount / top } else { (1.0 - math::exp(-k * amount)) / (1.0 - math::exp(-k * top)) }
}

/// Whether the point lies within the box of which a curve joins two corners.
fn is_inside(amount: f64, utility: f64, top: f64) -> bool {
    0.0 < amount && amount < top && top.is_finite() && 0.0 < utility && utility < 1.0
}

/// The largest number of which `exp` is finite is a little more.
const STEEPEST: f64 = 700.0;

/// More than enough to come from 1400 to the last bit of a number that matters.
const HALVINGS: usize = 200;

/// The ratio of the risk tolerance to `top` beyond which the curve is straight up to a millionth, and the exponential
/// formula would lose more than that to rounding.
const FLAT: f64 = 1e6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_risk_averse_curve_through_7_10() {
        let exponential = Curve::exponential_through(30.0, 0.5, 100.0).unwrap();
        let Curve::Exponential { tolerance, .. } = exponential else { panic!("{exponential:?}") };
        assert!((tolerance - 55.5225).abs() < 5e-5, "{tolerance}");
        assert!((exponential.utility(50.0) - 0.71106).abs() < 5e-6, "{}", exponential.utility(50.0));
        let power = Curve::power_through(30.0, 0.5, 100.0).unwrap();
        let Curve::Power { exponent, .. } = power else { panic!("{power:?}") };
        assert!((exponent - 0.575717).abs() < 5e-7, "{exponent}");
        for curve in [exponential, power] {
            let points = [0.0, 30.0, 100.0].map(|amount| curve.utility(amount));
            let off = points.iter().zip([0.0, 0.5, 1.0]).map(|(found, asked)| (found - asked).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{points:?}");
            assert_eq!(curve.attitude(), Attitude::Averse);
        }
    }

    /// The curve of Fig. 7.1.
    #[test]
    fn the_curve_bends_as_the_answer_says() {
        let attitude = |utility| Curve::exponential_through(30.0, utility, 100.0).unwrap().attitude();
        assert_eq!([0.2, 0.3, 0.4].map(attitude), [Attitude::Prone, Attitude::Neutral, Attitude::Averse]);
        for utility in [1e-6, 0.1, 0.999_999] {
            let curve = Curve::exponential_through(30.0, utility, 100.0).unwrap();
            assert!((curve.utility(30.0) - utility).abs() < 1e-9, "{curve:?}");
        }
        assert_eq!(Curve::exponential_through(30.0, 1.0, 100.0), None);
        assert_eq!(Curve::exponential_through(100.0, 0.5, 100.0), None);
        assert_eq!(Curve::power_through(0.0, 0.5, 100.0), None);
        assert_eq!(Curve::power_through(f64::NAN, 0.5, 100.0), None);
    }

    #[test]
    fn amount_undoes_utility() {
        assert_eq!(Curve::Linear { top: 200.0 }.utility(50.0), 0.25);
        let curves = [
            Curve::Linear { top: 100.0 },
            Curve::Exponential { top: 100.0, tolerance: 30.0 },
            Curve::Exponential { top: 100.0, tolerance: -30.0 },
            Curve::Power { top: 100.0, exponent: 0.4 },
            Curve::Logarithmic { wealth: 50.0 },
        ];
        for curve in curves {
            for amount in [0.0, 0.1, 20.0, 99.0, 100.0] {
                let back = curve.amount(curve.utility(amount));
                assert!((back - amount).abs() < 1e-9, "{curve:?}: {amount} {back}");
            }
        }
    }
}
