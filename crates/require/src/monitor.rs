//! Monitors: requirements held against samples as they come.

use std::fmt::{self, Display};

use thiserror::Error;

use crate::margin::Margin;
use crate::requirement::{Requirement, Rule, Seconds};
use crate::window::{Moment, Window};

/// A requirement, and what its samples have decided so far.
///
/// Of samples it remembers the one that decides, and of [`Rule::Whenever`] those of the last `within_ns`.
#[derive(Clone, Debug)]
pub struct Monitor<Q> {
    requirement: Requirement<Q>,
    last_ns: Option<u64>,
    decisive: Option<Moment>,
    window: Window,
}

/// How a run keeps to a requirement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// By how much it does; below 0, by how much it fails. In the units of what the formulas compare.
    pub robustness: f64,
    /// Whether it does, which a robustness of 0 leaves open: there `<=` holds and `<` does not.
    pub holds: bool,
    /// The instant that decides, in nanoseconds.
    pub at_ns: u64,
}

/// A sample that is not later than the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "the sample at {time_ns} ns comes after that at {last_ns} ns; give samples in the order of their times, one for each"
)]
pub struct OrderError {
    /// Its time, in nanoseconds.
    pub time_ns: u64,
    /// The time of the one before, in nanoseconds.
    pub last_ns: u64,
}

impl<Q> Monitor<Q> {
    /// A monitor that has seen no samples.
    pub fn new(requirement: Requirement<Q>) -> Self {
        Self { requirement, last_ns: None, decisive: None, window: Window::default() }
    }

    /// The requirement.
    pub fn requirement(&self) -> &Requirement<Q> {
        &self.requirement
    }

    /// Takes a sample in, at whatever time after the one before, with the values of its quantities. It takes constant time, in
    /// the mean over samples.
    ///
    /// # Errors
    /// If the time is not later than that of the sample before.
    pub fn see(&mut self, time_ns: u64, mut value: impl FnMut(&Q) -> f64) -> Result<(), OrderError> {
        if let Some(last_ns) = self.last_ns.filter(|&last_ns| time_ns <= last_ns) {
            return Err(OrderError { time_ns, last_ns });
        }
        self.last_ns = Some(time_ns);
        let Some(since_ns) = time_ns.checked_sub(self.requirement.from_ns) else { return Ok(()) };
        let moment = |margin| Moment { margin, at_ns: time_ns };
        match &self.requirement.rule {
            Rule::Always(formula) => {
                decide(&mut self.decisive, Moment::worse, moment(formula.margin(&mut value)));
            }
            Rule::Never(formula) => {
                decide(&mut self.decisive, Moment::worse, moment(formula.margin(&mut value).negated()));
            }
            Rule::Eventually { formula, within_ns } => {
                if within_ns.is_none_or(|within_ns| since_ns <= within_ns) {
                    decide(&mut self.decisive, Moment::better, moment(formula.margin(&mut value)));
                }
            }
            Rule::Whenever { formula, then, within_ns } => {
                while let Some(closed) = self.window.pop_closed(time_ns, *within_ns) {
                    decide(&mut self.decisive, Moment::worse, closed);
                }
                let no_trigger = formula.margin(&mut value).negated();
                self.window.add(moment(no_trigger), moment(then.margin(&mut value)));
            }
        }
        Ok(())
    }

    /// The verdict if the run ends with the last sample. The end cuts windows off: what has not come by then does not come.
    /// It takes time in proportion to the samples in the window of a [`Rule::Whenever`], and constant time of others.
    ///
    /// The instant that decides is the first one of the least robustness of [`Rule::Always`] and [`Rule::Never`], the first one of the
    /// greatest of [`Rule::Eventually`], and of [`Rule::Whenever`] that of the trigger with the least. Without samples that count,
    /// it is that of the requirement's beginning; the robustness is then −∞ of [`Rule::Eventually`], and ∞ of others.
    pub fn verdict(&self) -> Verdict {
        let open = self.window.open();
        let decisive = self.decisive.into_iter().chain(open).reduce(Moment::worse);
        let Moment { margin, at_ns } = decisive.unwrap_or_else(|| {
            let holds = match &self.requirement.rule {
                Rule::Eventually { .. } => false,
                Rule::Always(_) | Rule::Never(_) | Rule::Whenever { .. } => true,
            };
            let robustness = if holds { f64::INFINITY } else { f64::NEG_INFINITY };
            Moment { margin: Margin { robustness, holds }, at_ns: self.requirement.from_ns }
        });
        Verdict { robustness: margin.robustness, holds: margin.holds, at_ns }
    }
}

fn decide(decisive: &mut Option<Moment>, choose: fn(Moment, Moment) -> Moment, next: Moment) {
    *decisive = Some(decisive.map_or(next, |earlier| choose(earlier, next)));
}

impl Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, by) = (if self.holds { "holds" } else { "fails" }, self.robustness.abs());
        if by.is_infinite() {
            write!(f, "{word} by ∞ at {}", Seconds(self.at_ns))
        } else {
            write!(f, "{word} by {by} at {}", Seconds(self.at_ns))
        }
    }
}

#[cfg(test)]
mod tests;
