//! Formulas: what holds of a sample, and by how much.

use std::fmt::{self, Display};

use crate::expression::Expression;
use crate::margin::Margin;

/// A condition on the quantities of one sample, such as `age_ms(ir_front) > 200 and speed_m_s > 0.3`.
///
/// Its text in the normal form, by [`Display`], is read as the same formula, unless it has become longer than
/// [`MOST_BYTES`](crate::MOST_BYTES) by its blanks.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula<Q>(pub(crate) Condition<Q>);

impl<Q> Formula<Q> {
    /// By how much the formula holds of the sample in which quantities have these values; below 0, by how much it fails.
    ///
    /// It is a − b of `a > b` and `a >= b`, b − a of `a < b` and `a <= b`; `and` takes the least, `or` the greatest, and
    /// `not` the negative. So it is in the units of what is compared, and formulas in which units differ compare numbers.
    ///
    /// Values may be infinite, as is the age of what never came. Where the difference is no number, because a value is NaN
    /// or by ∞ − ∞ or 0 · ∞, the comparison fails by ∞, in whatever direction it compares; its `not` holds by ∞.
    pub fn robustness(&self, mut value: impl FnMut(&Q) -> f64) -> f64 {
        self.0.margin(&mut value).robustness
    }

    pub(crate) fn margin(&self, value: &mut impl FnMut(&Q) -> f64) -> Margin {
        self.0.margin(value)
    }
}

impl<Q> Display for Formula<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// What is true or false of a sample.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Condition<Q> {
    Comparison {
        left: Expression<Q>,
        relation: Relation,
        right: Expression<Q>,
    },
    Not(Box<Self>),
    /// Two or more.
    And(Vec<Self>),
    /// Two or more.
    Or(Vec<Self>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    Less,
    AtMost,
    Greater,
    AtLeast,
}

impl<Q> Condition<Q> {
    fn margin(&self, value: &mut impl FnMut(&Q) -> f64) -> Margin {
        match self {
            Self::Comparison { left, relation, right } => {
                let (left, right) = (left.value(value), right.value(value));
                match relation {
                    Relation::Less => Margin::of(right, left, false),
                    Relation::AtMost => Margin::of(right, left, true),
                    Relation::Greater => Margin::of(left, right, false),
                    Relation::AtLeast => Margin::of(left, right, true),
                }
            }
            Self::Not(inner) => inner.margin(value).negated(),
            Self::And(all) => all.iter().map(|one| one.margin(value)).reduce(Margin::least).expect(NOT_EMPTY),
            Self::Or(any) => {
                any.iter().map(|one| one.margin(value)).reduce(Margin::greatest).expect(NOT_EMPTY)
            }
        }
    }

    /// How tightly its parts are bound together: one that is bound no more tightly than what it stands in is in parentheses.
    fn tightness(&self) -> u8 {
        match self {
            Self::Or(_) => 0,
            Self::And(_) => 1,
            Self::Not(_) | Self::Comparison { .. } => 2,
        }
    }
}

const NOT_EMPTY: &str = "the parser joins two conditions or more";

impl<Q> Display for Condition<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (all, word) = match self {
            Self::Comparison { left, relation, right } => return write!(f, "{left} {relation} {right}"),
            Self::Not(inner) => return write!(f, "not {}", Part { condition: inner, tightness: 1 }),
            Self::And(all) => (all, " and "),
            Self::Or(any) => (any, " or "),
        };
        for (i, condition) in all.iter().enumerate() {
            let part = Part { condition, tightness: self.tightness() };
            write!(f, "{}{part}", if i == 0 { "" } else { word })?;
        }
        Ok(())
    }
}

/// A condition that stands in another one, of this tightness.
struct Part<'a, Q> {
    condition: &'a Condition<Q>,
    tightness: u8,
}

impl<Q> Display for Part<'_, Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.condition.tightness() <= self.tightness {
            write!(f, "({})", self.condition)
        } else {
            self.condition.fmt(f)
        }
    }
}

impl Display for Relation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Less => "<",
            Self::AtMost => "<=",
            Self::Greater => ">",
            Self::AtLeast => ">=",
        })
    }
}
