//! The outcome of a tuning: its report, and its files.

use std::fmt::Write;
use std::path::PathBuf;

use baudbot_brains::catalogue;
use baudbot_fields::printable::PrintableLines;
use baudbot_plot::chart::progress::{self, Progress};
use baudbot_run::assignment;
use serde_json::{Value, json};

use super::candidate::{Candidate, Outcome, levels};
use super::plan::ranges;
use crate::chart;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Choice, Field};
use crate::goal::Goal;
use crate::outputs::{Content, Folder};
use crate::run_options::RunOptions;

/// The result of a tuning.
#[derive(Debug)]
pub struct Tuned {
    /// The search was stopped before its end: there is a journal, and nothing else.
    pub interrupted: bool,
    /// The optimizer saw no use in more generations.
    pub converged: bool,
    /// The brain as it is, if its runs were done.
    pub untuned: Option<Candidate>,
    /// All candidates, in the order of their numbers.
    pub candidates: Vec<Candidate>,
    /// The best and the untuned with seeds that had no part in the search.
    pub checked: Option<(Outcome, Outcome)>,
    /// The files that were written.
    pub files: Vec<PathBuf>,
}

impl Tuned {
    pub(super) fn new(untuned: Option<Candidate>) -> Self {
        let interrupted = untuned.is_none();
        let (candidates, files) = (Vec::new(), Vec::new());
        Self { interrupted, converged: false, untuned, candidates, checked: None, files }
    }

    /// The best candidate that has a score: of equal ones the first.
    pub fn best(&self) -> Option<&Candidate> {
        let scored = self.candidates.iter().filter(|candidate| candidate.outcome.score().is_some());
        scored.min_by(|a, b| a.outcome.cost().total_cmp(&b.outcome.cost()))
    }

    /// An error if no run of any candidate so far had a score, and no other will have one either.
    pub(super) fn refuse_hopeless(&self, goal: &Goal) -> Result<(), Error> {
        let has_any = self.candidates.iter().any(|candidate| candidate.outcome.scores.count() > 0);
        match self.candidates.iter().find_map(|candidate| candidate.outcome.error.as_ref()) {
            Some(error) if !has_any && !goal.may_be_missed() => Err(Error::Refused(format!(
                "none of {} candidates has a score: {error}",
                self.candidates.len()
            ))),
            _ => Ok(()),
        }
    }

    pub(super) fn write(&mut self, experiment: &Experiment, folder: &Folder) -> Result<(), Error> {
        let mut texts = vec![
            (SUMMARY, PrintableLines(self.text(experiment)).to_string()),
            (TRACE, progress::draw(&self.progress(experiment))),
            (CANDIDATES, self.table(experiment)),
        ];
        folder.remove(BEST)?;
        if let Some(toml) = self.best().and_then(|best| description(experiment, best)) {
            texts.push((BEST, toml));
        }
        for (name, text) in texts {
            let content = |out: &mut std::io::BufWriter<_>| -> Result<(), Content> {
                Ok(std::io::Write::write_all(out, text.as_bytes())?)
            };
            folder.write(name, content)?;
            self.files.push(folder.file(name));
        }
        Ok(())
    }

    /// The report of the search.
    pub fn text(&self, experiment: &Experiment) -> String {
        let mut text = String::new();
        let Some(tuning) = &experiment.tuning else { return text };
        let seeds = experiment.seeds.count();
        let generations = self.candidates.last().map_or(0, |candidate| candidate.generation);
        let _ = writeln!(
            text,
            "{}: {} maximized by {} candidates in {generations} generations, each with {seeds} seed{}{}",
            experiment.name,
            tuning.goal,
            self.candidates.len(),
            if seeds == 1 { "" } else { "s" },
            if self.converged { "; it has converged" } else { "" }
        );
        if let Some(untuned) = &self.untuned {
            let _ = writeln!(text, "untuned: {}", told(experiment, &untuned.outcome));
        }
        let Some(best) = self.best() else { return text + "no candidate has a score\n" };
        let of = format!("candidate {} of generation {}", best.number, best.generation);
        let _ = writeln!(text, "best:    {}  ({of})", told(experiment, &best.outcome));
        let width = experiment.fields.iter().map(|field| field.label.chars().count()).max().unwrap_or(0);
        for (field, value) in experiment.fields.iter().zip(&best.values) {
            let _ = writeln!(text, "    {:width$}  {value}{}", field.label, at_an_end(field, *value));
        }
        if let Some((best, untuned)) = &self.checked {
            let runs = best.runs;
            let _ = writeln!(text, "with {runs} seeds that were not used in the search:");
            let _ = writeln!(text, "    untuned: {}", told(experiment, untuned));
            let _ = writeln!(text, "    best:    {}", told(experiment, best));
        }
        let _ = writeln!(text, "as options of `baudbot run`: {}", settings(experiment, best).options());
        text
    }

    /// The result as an object of JSON.
    pub fn json(&self, experiment: &Experiment) -> Value {
        let outcome = |outcome: &Outcome| {
            json!({
                "score": outcome.score(), "half_width": outcome.scores.half_width(), "runs": outcome.runs,
                "succeeded": experiment.success.as_ref().map(|_| outcome.succeeded), "error": outcome.error,
            })
        };
        let values = |candidate: &Candidate| -> serde_json::Map<String, Value> {
            let labels = experiment.fields.iter().map(|field| field.label.clone());
            labels.zip(candidate.values.iter().map(|value| json!(value))).collect()
        };
        json!({
            "candidates": self.candidates.len(),
            "converged": self.converged,
            "untuned": self.untuned.as_ref().map(|untuned| outcome(&untuned.outcome)),
            "best": self.best().map(|best| json!({
                "number": best.number, "generation": best.generation, "values": values(best),
                "outcome": outcome(&best.outcome), "options": settings(experiment, best).options(),
            })),
            "checked": self.checked.as_ref().map(|(best, untuned)| {
                json!({ "best": outcome(best), "untuned": outcome(untuned) })
            }),
        })
    }

    /// The way to the best, for a picture.
    fn progress(&self, experiment: &Experiment) -> Progress {
        let goal = experiment.tuning.as_ref().map(|tuning| tuning.goal.to_string()).unwrap_or_default();
        let mut best: Vec<&Candidate> = Vec::new();
        let mut scores = Vec::new();
        for candidate in &self.candidates {
            let Some(score) = candidate.outcome.score() else { continue };
            let words = format!("candidate {}: {}", candidate.number, told(experiment, &candidate.outcome));
            scores.push((candidate.generation as f64, score, words));
            if best.last().is_none_or(|best| candidate.outcome.cost() < best.outcome.cost()) {
                best.push(candidate);
            }
        }
        let last = self.candidates.last().map_or(1, |candidate| candidate.generation) as f64;
        let steps = |of: &dyn Fn(&Candidate) -> Option<f64>| {
            let step = |candidate: &&Candidate| Some((candidate.generation as f64, of(candidate)?));
            best.iter().filter_map(step).collect::<Vec<_>>()
        };
        let numbers =
            experiment.fields.iter().enumerate().map(|(i, field)| {
                (field.label.clone(), steps(&|candidate| share(field, candidate.values[i])))
            });
        Progress {
            title: experiment.name.clone(),
            subtitle: format!(
                "{}; each point is a candidate, a mean over {}",
                chart::of_what(experiment),
                chart::seeds(experiment)
            ),
            goal,
            generations: last,
            untuned: self.untuned.as_ref().and_then(|untuned| untuned.outcome.score()),
            scores,
            best: steps(&|candidate| candidate.outcome.score()),
            numbers: numbers.collect(),
        }
    }

    /// All candidates as a table in CSV.
    fn table(&self, experiment: &Experiment) -> String {
        let mut table = csv::Writer::from_writer(Vec::new());
        let labels = experiment.fields.iter().map(|field| field.label.as_str());
        let head = ["candidate", "generation"].into_iter().chain(labels);
        // A text in memory is never full.
        let _ = table.write_record(head.chain(["score", "succeeded", "runs", "error"]));
        for candidate in self.untuned.iter().chain(&self.candidates) {
            let outcome = &candidate.outcome;
            let values = (0..experiment.fields.len())
                .map(|i| candidate.values.get(i).map(ToString::to_string).unwrap_or_default());
            let mut record = vec![candidate.number.to_string(), candidate.generation.to_string()];
            record.extend(values);
            record.push(outcome.score().map(|score| score.to_string()).unwrap_or_default());
            record.extend([outcome.succeeded.to_string(), outcome.runs.to_string()]);
            record.push(outcome.error.clone().unwrap_or_default());
            let _ = table.write_record(record);
        }
        String::from_utf8(table.into_inner().unwrap_or_default()).unwrap_or_default()
    }
}

/// A score in words.
fn told(experiment: &Experiment, outcome: &Outcome) -> String {
    let Some(score) = outcome.score() else {
        return format!("no score: {}", outcome.error.as_deref().unwrap_or("no runs"));
    };
    let half = outcome.scores.half_width().map(|half| format!(" ± {half:.4}")).unwrap_or_default();
    let success = match &experiment.success {
        Some(_) => format!(", {} of {} runs succeed", outcome.succeeded, outcome.runs),
        None => String::new(),
    };
    format!("{score:.4}{half}{success}")
}

/// A hint that the range may be too narrow.
fn at_an_end(field: &Field, value: f64) -> &'static str {
    match share(field, value) {
        Some(share) if share < NEAR_END => "  (at the low end of its range)",
        Some(share) if share > 1.0 - NEAR_END => "  (at the high end of its range)",
        _ => "",
    }
}

/// The fraction of its range below a value.
fn share(field: &Field, value: f64) -> Option<f64> {
    match &field.choice {
        Choice::Range(range) => Some(range.share(value)),
        Choice::Levels(_) => None,
    }
}

fn settings(experiment: &Experiment, candidate: &Candidate) -> RunOptions {
    let levels = ranges(experiment).map(|ranges| levels(&ranges, &candidate.values)).unwrap_or_default();
    RunOptions::new(experiment, &levels)
}

/// The tuned brain as a description, if there is one brain and it is described.
fn description(experiment: &Experiment, best: &Candidate) -> Option<String> {
    let settings = settings(experiment, best);
    let [brain] = settings.brains.as_slice() else { return None };
    catalogue::described(assignment::split(brain).1).ok().flatten()
}

/// The files that a tuning makes of its journal.
pub(super) const FILES: [&str; 4] = [SUMMARY, TRACE, CANDIDATES, BEST];
const SUMMARY: &str = "summary.txt";
const TRACE: &str = "trace.svg";
const CANDIDATES: &str = "candidates.csv";
const BEST: &str = "best.toml";

/// So near to an end of its range, as a share of it, a number may want to go beyond.
const NEAR_END: f64 = 0.02;
