//! Looking for the value of a field at which a brain just succeeds.

use std::fmt::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::{Value, json};

use crate::check::check;
use crate::design::Cell;
use crate::error::Error;
use crate::estimate::Estimate;
use crate::experiment::{Experiment, bounded};
use crate::factor::{Choice, Level, Range};
use crate::pool::Workers;
use crate::raw::Wants;
use crate::run_record::Task;
use crate::statistics::wilson;

/// The limit of a field for one combination of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Labels and names of the other fields' values.
    pub others: Vec<(String, String)>,
    /// All values that were tried, from the one where success is hardest to the one where it is easiest.
    pub probes: Vec<Probe>,
    /// The place in `probes` of the limit; `None` if not even the easiest value will do.
    pub limit: Option<usize>,
}

/// A value that was tried with all seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// The value.
    pub value: f64,
    /// The name of the value.
    pub name: String,
    /// Runs that succeeded.
    pub succeeded: u64,
    /// The number of runs.
    pub runs: u64,
    /// The reason why runs failed, if some did.
    pub error: Option<String>,
    /// The wanted number of runs succeeded.
    pub is_enough: bool,
}

/// Looks for the limit of a field, by its label or path, for each combination of the other fields' values. `None` if it
/// was stopped. One that takes long must be `confirmed`.
///
/// # Errors
/// If the field has no numbers to look through, nothing counts as success, it would take long and is not confirmed, or the
/// server fails.
pub fn find(
    experiment: &Experiment,
    field: &str,
    workers: &Workers,
    confirmed: bool,
    stop: &AtomicBool,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Option<Vec<Limit>>, Error> {
    if experiment.success.is_none() {
        return Err(Error::field(
            "success",
            "is missing: what makes a run a success, such as collisions_at_most = 0",
        ));
    }
    let place = experiment.place(field).map_err(|problem| Error::Refused(format!("--find: {problem}")))?;
    check(experiment)?;
    let (mut limits, all) = (Vec::new(), others(experiment, place)?);
    // There is a run for each seed at the least.
    bounded("seeds", u128::from(experiment.seeds.count()) * all.len() as u128)?;
    for (i, others) in all.iter().enumerate() {
        let others = others.clone();
        let mut search =
            Search { experiment, place, others, workers, stop, progress, tried: Vec::new(), runs: 0 };
        if i == 0 && !confirmed {
            search.pilot(all.len() as u64)?;
        }
        match search.limit()? {
            Some(limit) => limits.push(limit),
            None => return Ok(None),
        }
    }
    workers.finish(experiment)?;
    Ok(Some(limits))
}

/// The combinations of all fields but one, that one at its first value.
fn others(experiment: &Experiment, place: usize) -> Result<Vec<Vec<Level>>, Error> {
    let mut all: Vec<Vec<Level>> = vec![Vec::new()];
    for (i, field) in experiment.fields.iter().enumerate() {
        let levels = match &field.choice {
            _ if i == place => vec![Level { name: String::new(), number: None, settings: Vec::new() }],
            Choice::Levels(levels) => levels.clone(),
            Choice::Range(_) => {
                let problem = "--find needs `values` for the fields that it does not search";
                return Err(Error::field(format!("fields[{i}]"), problem));
            }
        };
        if all.len().saturating_mul(levels.len()) > MOST_SEARCHES {
            return Err(Error::field(
                "fields",
                format!("--find would search for more than {MOST_SEARCHES} limits"),
            ));
        }
        let with = |cell: &Vec<Level>| {
            let cell = cell.clone();
            levels.clone().into_iter().map(move |level| cell.iter().cloned().chain([level]).collect())
        };
        all = all.iter().flat_map(with).collect();
    }
    Ok(all)
}

/// A search for one limit.
struct Search<'a> {
    experiment: &'a Experiment,
    place: usize,
    others: Vec<Level>,
    workers: &'a Workers,
    stop: &'a AtomicBool,
    progress: &'a (dyn Fn(&str) + Sync),
    /// Values with their places: 0 is the hardest.
    tried: Vec<(f64, Probe)>,
    runs: u64,
}

/// Values to look through, by a number that grows from the hardest to the easiest.
enum Line {
    Levels(Vec<Level>),
    /// With how near is near enough, as a share of the range, and whether the hardest is the highest.
    Range(Range, f64, bool),
}

impl Line {
    fn new(experiment: &Experiment, place: usize) -> Result<Self, Error> {
        let field = &experiment.fields[place];
        let is_down = experiment.find.wants == Wants::Highest;
        if !field.is_numeric() {
            return Err(Error::Refused(format!("--find: the values of `{}` are not numbers", field.label)));
        }
        Ok(match &field.choice {
            Choice::Levels(levels) => {
                let mut levels = levels.clone();
                levels.sort_by(|a, b| a.number.unwrap_or(0.0).total_cmp(&b.number.unwrap_or(0.0)));
                if is_down {
                    levels.reverse();
                }
                Self::Levels(levels)
            }
            Choice::Range(range) => {
                let width = range.to - range.from;
                let near = experiment.find.tolerance.map_or(0.01, |tolerance| tolerance / width);
                Self::Range(range.clone(), near.clamp(1e-9, 1.0), is_down)
            }
        })
    }

    fn ends(&self) -> (f64, f64) {
        match self {
            Self::Levels(levels) => (0.0, (levels.len() - 1) as f64),
            Self::Range(..) => (0.0, 1.0),
        }
    }

    fn level(&self, at: f64) -> Level {
        match self {
            Self::Levels(levels) => levels[(at as usize).min(levels.len() - 1)].clone(),
            Self::Range(range, _, is_down) => range.level(range.at(if *is_down { 1.0 - at } else { at })),
        }
    }

    /// The value to try between one that fails and one that succeeds; `None` if they are near enough.
    fn between(&self, hard: f64, easy: f64) -> Option<f64> {
        match self {
            Self::Levels(_) => (easy - hard > 1.5).then(|| (0.5 * (hard + easy)).floor()),
            Self::Range(_, near, _) => {
                let (middle, number) = (0.5 * (hard + easy), |at| self.level(at).number);
                let is_new = number(middle) != number(hard) && number(middle) != number(easy);
                (easy - hard > *near && is_new).then_some(middle)
            }
        }
    }

    /// Most values that a search tries: both ends, those that halve what is between, and two neighbours.
    fn most_probes(&self) -> u64 {
        match self {
            Self::Levels(levels) => {
                let count = levels.len() as u64;
                count.min(4 + u64::from(count.next_power_of_two().ilog2()))
            }
            Self::Range(_, near, _) => 4 + near.recip().log2().ceil() as u64,
        }
    }

    /// The values beyond both ends of the limit, to see that it is one.
    fn neighbours(&self, hard: f64, easy: f64) -> [Option<f64>; 2] {
        let step = match self {
            Self::Levels(_) => 1.0,
            Self::Range(_, near, _) => *near,
        };
        let (first, last) = self.ends();
        [Some(hard - step).filter(|at| *at >= first), Some(easy + step).filter(|at| *at <= last)]
    }
}

impl Search<'_> {
    /// A run for each worker, to see how long so many searches may take. Nothing is kept of them.
    fn pilot(&self, searches: u64) -> Result<(), Error> {
        let line = Line::new(self.experiment, self.place)?;
        // The seeds of one value are run at a time.
        let jobs = self.experiment.seeds.count().min(self.workers.jobs() as u64);
        let runs = searches.saturating_mul(line.most_probes()).saturating_mul(self.experiment.seeds.count());
        let easiest = line.level(line.ends().1);
        let mut time = Duration::ZERO;
        self.workers.work(self.experiment, self.tasks(&easiest, jobs), self.stop, |_, took| {
            time += took;
            Ok(())
        })?;
        if self.stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        Estimate::new(runs, jobs, time, jobs as usize).refuse_long("up to ")
    }

    /// Runs with a value and the first seeds.
    fn tasks(&self, level: &Level, count: u64) -> impl Iterator<Item = Task> + Send {
        let mut levels = self.others.clone();
        levels[self.place] = level.clone();
        let (seeds, first) = (&self.experiment.seeds, self.runs);
        (0..count).map(move |i| {
            let cell = Cell { number: 0, levels: levels.clone() };
            Task { run: first + i, cell, seed: seeds.get(i) }
        })
    }

    fn limit(&mut self) -> Result<Option<Limit>, Error> {
        let line = Line::new(self.experiment, self.place)?;
        let (mut hard, mut easy) = line.ends();
        let Some(can) = self.try_at(&line, easy)? else { return Ok(None) };
        if can && hard < easy {
            let Some(cannot) = self.try_at(&line, hard)?.map(|is_enough| !is_enough) else { return Ok(None) };
            if cannot {
                while let Some(middle) = line.between(hard, easy) {
                    match self.try_at(&line, middle)? {
                        Some(true) => easy = middle,
                        Some(false) => hard = middle,
                        None => return Ok(None),
                    }
                }
                for at in line.neighbours(hard, easy).into_iter().flatten() {
                    if self.try_at(&line, at)?.is_none() {
                        return Ok(None);
                    }
                }
            } else {
                easy = hard;
            }
        }
        Ok(Some(self.told(can.then_some(easy))))
    }

    fn told(&mut self, limit: Option<f64>) -> Limit {
        self.tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let limit = limit.and_then(|limit| self.tried.iter().position(|(at, _)| *at == limit));
        let fields = self.experiment.fields.iter().zip(&self.others).enumerate();
        let others = fields.filter(|(i, _)| *i != self.place);
        Limit {
            others: others.map(|(_, (field, level))| (field.label.clone(), level.name.clone())).collect(),
            probes: self.tried.drain(..).map(|(_, probe)| probe).collect(),
            limit,
        }
    }

    /// Runs all seeds with the value at this place, unless that was done; whether it is enough. `None` if stopped.
    fn try_at(&mut self, line: &Line, at: f64) -> Result<Option<bool>, Error> {
        if let Some((_, probe)) = self.tried.iter().find(|(tried, _)| *tried == at) {
            return Ok(Some(probe.is_enough));
        }
        let level = line.level(at);
        (self.progress)(&level.name);
        let seeds = self.experiment.seeds.count();
        let tasks = self.tasks(&level, seeds);
        let (mut runs, mut succeeded, mut error) = (0, 0, None);
        self.workers.work(self.experiment, tasks, self.stop, |row, _| {
            runs += 1;
            succeeded += u64::from(self.experiment.succeeded(&row).unwrap_or_default());
            error = error.take().or_else(|| row.outcome.err().map(|error| error.to_string()));
            Ok(())
        })?;
        self.runs += seeds;
        if self.stop.load(Ordering::Relaxed) && runs < seeds {
            return Ok(None);
        }
        let share = succeeded as f64 / runs.max(1) as f64;
        let is_enough = share >= self.experiment.find.share;
        let value = level.number.unwrap_or(f64::NAN);
        self.tried.push((at, Probe { value, name: level.name, succeeded, runs, error, is_enough }));
        Ok(Some(is_enough))
    }
}

impl Limit {
    /// Whether every value that is easier than the limit succeeded, and every one that is harder did not.
    pub fn is_monotone(&self) -> bool {
        let limit = self.limit.unwrap_or(self.probes.len());
        self.probes.iter().enumerate().all(|(i, probe)| probe.is_enough == (i >= limit))
    }

    /// The limit's report.
    pub fn text(&self, experiment: &Experiment, field: &str) -> String {
        let others = self.others.iter().map(|(label, level)| format!("{label} {level}: "));
        others.collect::<String>() + &self.headline(experiment, field) + "\n" + &self.notes()
    }

    fn headline(&self, experiment: &Experiment, field: &str) -> String {
        let label = experiment.place(field).map_or(field, |place| &experiment.fields[place].label);
        let end = if experiment.find.wants == Wants::Lowest { "lowest" } else { "highest" };
        let what = experiment.success.as_ref().map(ToString::to_string).unwrap_or_default();
        let length = experiment.seconds.map(|s| format!(" in {s} s")).unwrap_or_default();
        let keeps = format!("{label} at which {} has {what}{length}", experiment.brains.join(" "));
        let Some(i) = self.limit else {
            let tried = self.probes.last().map(Probe::told).unwrap_or_default();
            return format!(
                "found no {keeps}: even the easiest value fails, {tried}, and the others were not tried; `wants` in \
                 [find] defines which end is easy"
            );
        };
        let beyond = match i.checked_sub(1).map(|i| &self.probes[i]) {
            Some(harder) => format!("at {}: {} of {}", harder.name, harder.succeeded, harder.runs),
            None => "nothing harder was given".to_owned(),
        };
        format!("{end} {keeps}: {}; {beyond}", self.probes[i].told())
    }

    fn notes(&self) -> String {
        let mut text = String::new();
        if !self.is_monotone() {
            let told = |p: &Probe| format!("{}: {} of {}", p.name, p.succeeded, p.runs);
            let all: Vec<_> = self.probes.iter().map(told).collect();
            let all = all.join(", ");
            let _ = writeln!(
                text,
                "  note: success does not change exactly once ({all}); more seeds may show why"
            );
        }
        for probe in &self.probes {
            if let Some(error) = &probe.error {
                let _ = writeln!(text, "  note: at {}, runs failed: {error}", probe.name);
            }
        }
        text
    }

    /// The limit as an object of JSON.
    pub fn json(&self) -> Value {
        let probe = |probe: &Probe| {
            let interval = wilson(probe.succeeded, probe.runs).map(|(_, low, high)| [low, high]);
            json!({
                "value": probe.value, "runs": probe.runs, "succeeded": probe.succeeded,
                "is_enough": probe.is_enough, "interval": interval, "error": probe.error,
            })
        };
        json!({
            "others": self.others.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
            "limit": self.limit.map(|i| self.probes[i].value),
            "is_monotone": self.is_monotone(),
            "probes": self.probes.iter().map(probe).collect::<Vec<_>>(),
        })
    }
}

impl Probe {
    fn told(&self) -> String {
        let (_, low, high) = wilson(self.succeeded, self.runs).unwrap_or((0.0, 0.0, 1.0));
        format!(
            "{} ({} of {} seeds, 95 % interval {:.0}–{:.0} %)",
            self.name,
            self.succeeded,
            self.runs,
            low * 100.0,
            high * 100.0
        )
    }
}

/// Most limits that are looked for at a time.
const MOST_SEARCHES: usize = 1000;
