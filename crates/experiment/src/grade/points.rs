//! The points that runs earn for a criterion.

use crate::grade::exercise::Criterion;
use crate::grade::run::Run;

/// The points for a criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct Awarded {
    /// Points earned.
    pub points: f64,
    /// Whether each run fulfils the criterion.
    pub fulfilled: Vec<bool>,
}

impl Awarded {
    pub(crate) fn new(criterion: &Criterion, runs: &[Run]) -> Self {
        let fulfils = |run: &Run| {
            run.measures().is_some_and(|measures| criterion.needs.hold(|measure| measures.get(measure)))
        };
        let fulfilled: Vec<_> = runs.iter().map(fulfils).collect();
        let share =
            fulfilled.iter().filter(|&&fulfilled| fulfilled).count() as f64 / runs.len().max(1) as f64;
        Self { points: share * criterion.points, fulfilled }
    }

    /// The number of runs that fulfil the criterion.
    pub fn count(&self) -> usize {
        self.fulfilled.iter().filter(|&&fulfilled| fulfilled).count()
    }
}
