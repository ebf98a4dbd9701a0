//! Requirements: what must hold over time.

use std::fmt::{self, Display};

use crate::formula::Formula;

/// A rule that a run must keep from an instant on.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement<Q> {
    /// What must hold.
    pub rule: Rule<Q>,
    /// Samples before this instant do not count, in nanoseconds.
    pub from_ns: u64,
}

/// What must hold of the samples of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule<Q> {
    /// The formula holds of all samples.
    Always(Formula<Q>),
    /// The formula holds of no sample.
    Never(Formula<Q>),
    /// The formula holds of a sample at least.
    Eventually {
        /// What must become true.
        formula: Formula<Q>,
        /// The time it has from the requirement's beginning, [`Requirement::from_ns`], in nanoseconds, the end included; without
        /// it, to the end of the run.
        within_ns: Option<u64>,
    },
    /// Of each sample of which the formula holds, or of one soon after it, holds another.
    Whenever {
        /// The trigger.
        formula: Formula<Q>,
        /// The reaction.
        then: Formula<Q>,
        /// The time from the trigger to the reaction, in nanoseconds, both ends included.
        within_ns: u64,
    },
}

impl<Q> Display for Requirement<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.rule.fmt(f)?;
        if self.from_ns > 0 { write!(f, ", from {} on", Seconds(self.from_ns)) } else { Ok(()) }
    }
}

impl<Q> Display for Rule<Q> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Always(formula) => write!(f, "always {formula}"),
            Self::Never(formula) => write!(f, "never {formula}"),
            Self::Eventually { formula, within_ns: None } => write!(f, "eventually {formula}"),
            Self::Eventually { formula, within_ns: Some(within_ns) } => {
                write!(f, "eventually {formula} within {}", Seconds(*within_ns))
            }
            Self::Whenever { formula, then, within_ns } => {
                write!(f, "whenever {formula} then {then} within {}", Seconds(*within_ns))
            }
        }
    }
}

/// Nanoseconds, shown in seconds.
pub(crate) struct Seconds(pub(crate) u64);

impl Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s", self.0 as f64 / 1e9)
    }
}
