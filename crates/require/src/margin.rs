//! Margins: by how much a formula holds or fails.

/// By how much a formula holds, and whether it does, which the number alone leaves open at 0: there `<=` holds and `<`
/// does not. Of two margins the one of the smaller number is the smaller, and of equal numbers the one that fails.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(crate) struct Margin {
    /// In the units of the quantities that are compared; never NaN.
    pub(crate) robustness: f64,
    pub(crate) holds: bool,
}

impl Margin {
    /// The margin of `greater > less`, or of `greater >= less` if they may be equal. It is −∞ where the difference is no
    /// number.
    pub(crate) fn of(greater: f64, less: f64, may_be_equal: bool) -> Self {
        let difference = greater - less;
        if difference.is_nan() {
            return Self { robustness: f64::NEG_INFINITY, holds: false };
        }
        // A sum with 0 has no negative zero, which would be shown.
        let robustness = difference + 0.0;
        Self { robustness, holds: robustness > 0.0 || may_be_equal && robustness == 0.0 }
    }

    /// That of the opposite.
    pub(crate) fn negated(self) -> Self {
        Self { robustness: 0.0 - self.robustness, holds: !self.holds }
    }

    pub(crate) fn least(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    pub(crate) fn greatest(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}
