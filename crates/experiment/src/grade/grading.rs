//! The result of an exercise's runs: points, and a verdict.

use crate::grade::exercise::Exercise;
use crate::grade::findings;
use crate::grade::points::Awarded;
use crate::grade::run::{Problem, Run};

/// The runs of an exercise, and the points that they earn.
#[derive(Clone, Debug, PartialEq)]
pub struct Grading {
    /// In the order of the seeds.
    pub runs: Vec<Run>,
    /// The award for each criterion of the exercise, in its order.
    pub awarded: Vec<Awarded>,
    /// Points earned.
    pub points: f64,
    /// The verdict.
    pub verdict: Verdict,
    /// The faults, the most telling first; empty if the exercise is passed.
    pub findings: Vec<String>,
}

/// The verdict of a grading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The points are enough.
    Passed,
    /// The points are not enough.
    Failed,
    /// In no run did the brain drive, so there is nothing to be graded.
    NotGraded,
}

impl Verdict {
    /// The name of the verdict in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::NotGraded => "not-graded",
        }
    }
}

impl Grading {
    pub(crate) fn new(exercise: &Exercise, runs: Vec<Run>) -> Self {
        let awarded: Vec<_> =
            exercise.criteria.iter().map(|criterion| Awarded::new(criterion, &runs)).collect();
        let points = awarded.iter().map(|awarded| awarded.points).sum();
        let is_absent = |run: &Run| matches!(run.outcome, Err(Problem::NotStarted(_)));
        let verdict = if runs.iter().all(is_absent) {
            Verdict::NotGraded
        } else if points >= exercise.pass * exercise.points() * (1.0 - ROUNDING) {
            Verdict::Passed
        } else {
            Verdict::Failed
        };
        let mut grading = Self { runs, awarded, points, verdict, findings: Vec::new() };
        if verdict != Verdict::Passed {
            grading.findings = findings::of(exercise, &grading.runs, &grading.awarded);
        }
        grading
    }
}

/// Shares of points that are added up are not exact.
const ROUNDING: f64 = 1e-9;
