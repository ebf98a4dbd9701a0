//! Expressions: numbers made of quantities.

use std::fmt::{self, Display};

/// A number that a sample gives.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expression<Q> {
    /// A finite number.
    Number(f64),
    Quantity {
        name: Box<str>,
        argument: Option<Box<str>>,
        quantity: Q,
    },
    Negative(Box<Self>),
    Absolute(Box<Self>),
    Least(Box<[Self; 2]>),
    Greatest(Box<[Self; 2]>),
    /// Two factors or more.
    Product(Vec<Self>),
    /// Two summands or more; what is subtracted is negative.
    Sum(Vec<Self>),
}

impl<Q> Expression<Q> {
    /// Its number; NaN if one of its parts is that, or has no value, such as ∞ − ∞.
    pub(crate) fn value(&self, of: &mut impl FnMut(&Q) -> f64) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Quantity { quantity, .. } => of(quantity),
            Self::Negative(positive) => -positive.value(of),
            Self::Absolute(inner) => inner.value(of).abs(),
            Self::Least(both) => {
                let [a, b] = both.each_ref().map(|one| one.value(of));
                // f64::min would take the other one in place of NaN.
                if a.is_nan() || a < b { a } else { b }
            }
            Self::Greatest(both) => {
                let [a, b] = both.each_ref().map(|one| one.value(of));
                if a.is_nan() || a > b { a } else { b }
            }
            Self::Product(factors) => factors.iter().map(|factor| factor.value(of)).product(),
            Self::Sum(summands) => summands.iter().map(|summand| summand.value(of)).sum(),
        }
    }

    /// How tightly its parts are bound together: one that is bound no more tightly than what it stands in is in parentheses.
    fn tightness(&self) -> u8 {
        match self {
            Self::Sum(_) => 0,
            Self::Product(_) => 1,
            Self::Number(_)
            | Self::Quantity { .. }
            | Self::Negative(_)
            | Self::Absolute(_)
            | Self::Least(_)
            | Self::Greatest(_) => 2,
        }
    }

    fn within(&self, tightness: u8) -> Part<'_, Q> {
        Part { expression: self, tightness }
    }
}

impl<Q> Display for Expression<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write_number(*number, f),
            Self::Quantity { name, argument: None, .. } => f.write_str(name),
            Self::Quantity { name, argument: Some(argument), .. } => write!(f, "{name}({argument})"),
            Self::Negative(positive) => write!(f, "-{}", positive.within(1)),
            Self::Absolute(inner) => write!(f, "abs({inner})"),
            Self::Least(both) => write!(f, "min({}, {})", both[0], both[1]),
            Self::Greatest(both) => write!(f, "max({}, {})", both[0], both[1]),
            Self::Product(factors) => {
                for (i, factor) in factors.iter().enumerate() {
                    write!(f, "{}{}", if i == 0 { "" } else { " * " }, factor.within(1))?;
                }
                Ok(())
            }
            Self::Sum(summands) => {
                for (i, summand) in summands.iter().enumerate() {
                    if let (1.., Self::Negative(positive)) = (i, summand) {
                        write!(f, " - {}", positive.within(0))?;
                    } else {
                        write!(f, "{}{}", if i == 0 { "" } else { " + " }, summand.within(0))?;
                    }
                }
                Ok(())
            }
        }
    }
}

/// An expression that stands in another one, of this tightness.
struct Part<'a, Q> {
    expression: &'a Expression<Q>,
    tightness: u8,
}

impl<Q> Display for Part<'_, Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.expression.tightness() <= self.tightness {
            write!(f, "({})", self.expression)
        } else {
            self.expression.fmt(f)
        }
    }
}

/// The shortest text of this number, without the zeros of one that is very large or small.
fn write_number(number: f64, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if number == 0.0 || (1e-5..1e16).contains(&number.abs()) {
        write!(f, "{number}")
    } else {
        write!(f, "{number:e}")
    }
}
