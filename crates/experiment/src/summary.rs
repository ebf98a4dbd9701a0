//! The summary of each combination: means over its seeds.

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::experiment::Experiment;
use crate::figures::{Figures, INFOS, Info};
use crate::paired::{Baseline, Comparison};
use crate::run_record::Row;
use crate::statistics::{Sample, wilson};

/// The results of a combination's runs.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSummary {
    /// The number of the cell.
    pub number: u64,
    /// The names of its values.
    pub levels: Vec<String>,
    /// Runs, failed ones too.
    pub runs: u64,
    /// Runs that could not be.
    pub failed: u64,
    /// Runs that succeeded, if anything counts as success.
    pub succeeded: Option<u64>,
    /// The values of each figure, in the order of [`INFOS`].
    pub figures: [Sample; Figures::COUNT],
    /// The cell beside the first one, seed by seed, if they are compared.
    pub beside_first: Option<Comparison>,
}

/// The results of all runs.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// The combinations, one by one; of very many only the first.
    pub cells: Vec<CellSummary>,
    /// Combinations that are not in `cells`.
    pub left_out: u64,
    /// All runs.
    pub runs: u64,
    /// Runs that could not be.
    pub failed: u64,
    /// The first of them: the number of the run, and what was wrong.
    pub failures: Vec<(u64, String)>,
    first: Baseline,
}

impl Summary {
    /// Takes in a row; rows come in the order of their runs.
    pub(crate) fn add(&mut self, experiment: &Experiment, row: &Row) {
        self.runs += 1;
        if let Err(problem) = &row.outcome {
            self.failed += 1;
            if self.failures.len() < MOST_FAILURES {
                self.failures.push((row.run, problem.to_string()));
            }
        }
        let seeds = experiment.seeds.count();
        let number = row.run / seeds;
        if self.cells.last().is_none_or(|cell| cell.number != number) {
            if self.cells.len() >= MOST_CELLS {
                self.left_out += u64::from(row.run.is_multiple_of(seeds));
                return;
            }
            self.cells.push(CellSummary::new(experiment, number));
        }
        let Some(cell) = self.cells.last_mut() else { return };
        cell.add(experiment, row);
        match &mut cell.beside_first {
            Some(comparison) => self.first.compare(experiment, (row.run % seeds) as usize, row, comparison),
            None if experiment.has_pairs() => self.first.add(experiment, row),
            None => {}
        }
    }

    /// The summary as an object of JSON.
    pub fn json(&self, experiment: &Experiment) -> Value {
        json!({
            "experiment": experiment.name,
            "scenario": experiment.scenario,
            "success": experiment.success_text(),
            "runs": self.runs,
            "failed": self.failed,
            "failures": self.failures.iter().map(|(run, error)| json!({ "run": run, "error": error })).collect::<Vec<_>>(),
            "cells": self.cells.iter().map(|cell| cell.json(experiment)).collect::<Vec<_>>(),
            "cells_left_out": self.left_out,
        })
    }
}

impl CellSummary {
    fn new(experiment: &Experiment, number: u64) -> Self {
        let levels = experiment.cell(number).levels.into_iter().map(|level| level.name).collect();
        let succeeded = experiment.has_success().then_some(0);
        let beside_first = (number > 0 && experiment.has_pairs()).then(Comparison::default);
        Self { number, levels, runs: 0, failed: 0, succeeded, figures: Default::default(), beside_first }
    }

    fn add(&mut self, experiment: &Experiment, row: &Row) {
        self.runs += 1;
        self.failed += u64::from(row.outcome.is_err());
        if let (Some(succeeded), Some(success)) = (&mut self.succeeded, experiment.succeeded(row)) {
            *succeeded += u64::from(success);
        }
        let Ok(ran) = &row.outcome else { return };
        for (sample, value) in self.figures.iter_mut().zip(ran.figures.0) {
            value.into_iter().for_each(|value| sample.add(value));
        }
    }

    /// The fraction of successful runs, of those that could be, with its interval.
    pub fn success(&self) -> Option<(f64, f64, f64)> {
        wilson(self.succeeded?, self.runs - self.failed)
    }

    fn json(&self, experiment: &Experiment) -> Value {
        let values = experiment.fields.iter().zip(&self.levels);
        let values: Map<_, _> = values.map(|(field, level)| (field.label.clone(), json!(level))).collect();
        let figure = |(info, sample): (&Info, &Sample)| {
            let mean = Mean { runs: sample.count(), mean: sample.mean(), plus_minus: sample.half_width() };
            (info.name.to_owned(), json!(mean))
        };
        let figures: Map<_, _> = INFOS.iter().zip(&self.figures).map(figure).collect();
        let success =
            self.success().map(|(share, low, high)| json!({ "share": share, "low": low, "high": high }));
        json!({
            "cell": self.number, "values": values, "runs": self.runs, "failed": self.failed,
            "success": success, "figures": figures,
            "beside_first": self.beside_first.as_ref().map(Comparison::json),
        })
    }
}

/// A mean with its interval of 95 %.
#[derive(Serialize)]
struct Mean {
    runs: u64,
    mean: Option<f64>,
    plus_minus: Option<f64>,
}

/// Most combinations that are listed.
const MOST_CELLS: usize = 10_000;

/// Most failures that are listed.
const MOST_FAILURES: usize = 20;
