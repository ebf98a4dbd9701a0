//! A candidate: numbers for all fields, and the results of its runs.

use crate::experiment::Experiment;
use crate::factor::{Level, Range};
use crate::figures::Figure;
use crate::goal::Goal;
use crate::run_record::Row;
use crate::statistics::Sample;

/// A set of numbers that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The candidate's number; 0 is the untuned brain.
    pub number: u64,
    /// The generation that it is of, from 1; 0 is the untuned brain.
    pub generation: usize,
    /// The numbers, in the order of the fields; none for the untuned brain.
    pub values: Vec<f64>,
    /// The candidate's result.
    pub outcome: Outcome,
}

/// The results of some runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Scores of the runs that had one.
    pub scores: Sample,
    /// Runs that succeeded, if anything counts as success.
    pub succeeded: u64,
    /// The number of runs.
    pub runs: u64,
    /// The reason why a run failed, or had no score.
    pub error: Option<String>,
}

impl Outcome {
    pub(super) fn of<'a>(experiment: &Experiment, goal: &Goal, rows: impl Iterator<Item = &'a Row>) -> Self {
        let mut outcome = Self::default();
        for row in rows {
            outcome.runs += 1;
            outcome.succeeded += u64::from(experiment.succeeded(row).unwrap_or(true));
            let score = row.outcome.as_ref().map_err(ToString::to_string).and_then(|ran| {
                let lacks = |figure: Figure| {
                    if figure == Figure::GoalTimeS {
                        "the goal was not reached, so there is no score".to_owned()
                    } else {
                        format!("`{}` was not counted, so there is no score", figure.info().name)
                    }
                };
                goal.score(&ran.figures).map_err(lacks)
            });
            match score {
                Ok(score) => outcome.scores.add(score),
                Err(error) => outcome.error = outcome.error.or(Some(error)),
            }
        }
        outcome
    }

    /// The mean score, if all runs have one.
    pub fn score(&self) -> Option<f64> {
        self.scores.mean().filter(|_| self.error.is_none())
    }

    /// The cost to be minimised. A candidate with more successful runs is better than any with fewer. One without a score is
    /// worse than one with a score; of those without, the one with more successful runs is better.
    pub(super) fn cost(&self) -> f64 {
        let failed = 1.0 - self.succeeded as f64 / self.runs.max(1) as f64;
        // In the order of the scores, and never far from 0, however large these are.
        let drawn_in = |score: f64| score.signum() * score.abs().ln_1p();
        failed * FAILURE - self.score().map_or(-NO_SCORE, drawn_in)
    }
}

/// The number of a range at a share of it, with no more digits than matter: to a ten-thousandth of the range. So it can be
/// written down, and what is written is what was run.
pub(crate) fn number_at(range: &Range, share: f64) -> f64 {
    let number = range.at(share);
    if range.whole {
        return number;
    }
    let text = if range.log {
        format!("{number:.3e}")
    } else {
        let decimals = (4.0 - (range.to - range.from).log10()).ceil().clamp(0.0, 300.0) as usize;
        format!("{number:.decimals$}")
    };
    text.parse::<f64>().unwrap_or(number).clamp(range.from, range.to)
}

pub(super) fn levels(ranges: &[Range], values: &[f64]) -> Vec<Level> {
    ranges.iter().zip(values).map(|(range, value)| range.level(*value)).collect()
}

/// The cost of a candidate of which all runs fail. Of a million runs each is worth 2000, and no two scores are
/// farther apart than 1500.
const FAILURE: f64 = 2e9;

/// The cost of a candidate that has no score: more than any score, and nothing beside a failure.
const NO_SCORE: f64 = 800.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn range(from: f64, to: f64, log: bool, whole: bool) -> Range {
        Range { target: "brain.forward".into(), from, to, log, whole }
    }

    #[test]
    fn numbers_have_no_more_digits_than_matter() {
        assert_eq!(number_at(&range(1.0, 3.0, false, false), 1.0 / 3.0), 1.6667);
        assert_eq!(number_at(&range(0.0, 0.05, false, false), 0.123_456_78), 0.006_173);
        assert_eq!(number_at(&range(-2000.0, 2000.0, false, false), 0.6), 400.0);
        assert_eq!(number_at(&range(0.001, 1.0, true, false), 0.5), 0.03162);
        assert_eq!(number_at(&range(1.0, 9.0, false, true), 0.3), 3.0);
        assert_eq!(number_at(&range(0.0, 0.123_456_789, false, false), 1.0), 0.123_456_789);
    }

    #[test]
    fn success_comes_before_score_and_what_has_none_is_worst() {
        let outcome = |score: f64, succeeded| {
            let mut scores = Sample::default();
            scores.add(score);
            Outcome { scores, succeeded, runs: 2, error: None }
        };
        let costs = [outcome(0.1, 2), outcome(0.9, 1), outcome(0.9, 0)].map(|outcome| outcome.cost());
        assert!(costs.is_sorted(), "{costs:?}");
        assert!(outcome(0.9, 2).cost() < costs[0]);
        for (score, succeeded) in [(1e300, 1), (-1e300, 2), (0.0, 0)] {
            let scoreless = Outcome { error: Some("none".into()), ..outcome(score, succeeded) };
            assert!(scoreless.cost() > outcome(-1e9, succeeded).cost());
            assert!(scoreless.cost() < outcome(1e300, succeeded.saturating_sub(1)).cost() || succeeded == 0);
        }
        assert!(outcome(-1e9, 2).cost() < outcome(1e9, 1).cost(), "whatever they score");
        assert!(outcome(2.5e5, 2).cost() < outcome(2.4e5, 2).cost());
    }
}
