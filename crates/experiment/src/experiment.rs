//! An experiment, as its file describes it.

use std::path::PathBuf;

use baudbot_import::source::SourceError;
use baudbot_run::UnknownName;
use baudbot_run::assignment;
use baudbot_run::programs::{EXEC, Lifetime};
use toml::Value;

use crate::checked_fields::{fields, fields_of, seconds, within};
use crate::design::{Cell, Design};
use crate::error::Error;
use crate::factor::{self, Field, Setting};
use crate::figures::Figure;
use crate::hunt::Hunt;
use crate::places;
use crate::raw::{self, Wants};
use crate::requested_charts::{Chart, chart_of, usual_charts};
use crate::requirement::{Demand, Demands};
use crate::run_record::{self, Ran, Row, Task};
use crate::seeds::Seeds;
use crate::success::Success;
use crate::tuning::Tuning;

/// An experiment. Made by parsing only; whether its paths exist is found by [`check`](crate::check()).
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// A short name.
    pub name: String,
    /// The description of the experiment, for people.
    pub description: String,
    /// The name of the scenario: a file, or one that is part of the program.
    pub scenario: String,
    /// The folder that programs are started in; empty: the current one. The reader of the experiment's file sets it.
    pub folder: PathBuf,
    /// The scenario's text, with all files that it refers to in it.
    pub text: String,
    /// Brains: `NAME[:K=V,…]` or `exec:PROGRAM` for all robots, `ROBOT=NAME[:K=V,…]` for one.
    pub brains: Vec<String>,
    /// The lifetime of programs' processes.
    pub lifetime: Lifetime,
    /// Simulated length of a run, in seconds; `None` is that of the scenario.
    pub seconds: Option<f64>,
    /// Each combination is run with each of them.
    pub seeds: Seeds,
    /// The combinations that are run.
    pub design: Design,
    /// The factors: the fields that are varied.
    pub fields: Vec<Field>,
    /// The criterion of success, if there is one.
    pub success: Option<Success>,
    /// What must hold of each run, instant by instant.
    pub requirements: Demands,
    /// Its tables have how near each run came to a failure, whatever is required.
    pub nearness: bool,
    /// The search for limits.
    pub find: Find,
    /// The tuning of the fields, if they can be tuned.
    pub tuning: Option<Tuning>,
    /// The search for the worst run.
    pub hunt: Hunt,
    /// The charts that are drawn.
    pub charts: Vec<Chart>,
}

/// The search for a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Find {
    /// The wanted end of the values.
    pub wants: Wants,
    /// Share of the seeds that must succeed, above 0 and at most 1.
    pub share: f64,
    /// The tolerance of the limit, in the unit of a range's field.
    pub tolerance: Option<f64>,
}

impl Experiment {
    /// Reads an experiment. `stem` is its name if it gives none; `find` finds the text of a scenario.
    ///
    /// # Errors
    /// An error with the field and the remedy.
    pub fn parse(
        toml: &str,
        stem: &str,
        find: impl FnOnce(&str) -> Result<String, SourceError>,
    ) -> Result<Self, Error> {
        let raw: raw::Experiment = fields(toml, "experiment")?;
        let text = find(&raw.scenario).map_err(|problem| Error::field("scenario", problem))?;
        Self::checked(raw, stem, text)
    }

    fn checked(raw: raw::Experiment, stem: &str, text: String) -> Result<Self, Error> {
        let fields = raw.fields.into_iter().enumerate();
        let fields: Vec<_> =
            fields.map(|(i, field)| Field::new(&format!("fields[{i}]"), field)).collect::<Result<_, _>>()?;
        unique(&fields)?;
        places::unique(&fields, &text)?;
        let success = raw.success.as_ref().map(|table| Success::new("success", table)).transpose()?;
        let requirements = Demand::all(raw.require)?;
        let has_success = success.is_some() || !requirements.is_empty();
        let charts = if raw.charts.is_empty() && raw.tune.is_none() {
            usual_charts(fields.len(), has_success)
        } else {
            raw.charts
        };
        let charts = charts.into_iter().enumerate();
        let charts = charts.map(|(i, chart)| chart_of(i, chart, &fields, has_success));
        let (brains, lifetime) = brains(raw.brain, raw.brains)?;
        let experiment = Self {
            name: raw.name.filter(|name| !name.is_empty()).unwrap_or_else(|| stem.to_owned()),
            description: raw.description,
            scenario: raw.scenario,
            folder: PathBuf::new(),
            text,
            brains,
            lifetime,
            seconds: raw.seconds.map(seconds).transpose()?,
            seeds: Seeds::of(raw.seeds.as_ref())?,
            design: Design::new(raw.design, raw.samples, raw.seed)?,
            charts: charts.collect::<Result<_, _>>()?,
            find: find_of(&raw.find)?,
            tuning: raw.tune.map(Tuning::new).transpose()?,
            hunt: Hunt::new(&raw.worst)?,
            fields,
            success,
            requirements,
            nearness: raw.nearness,
        };
        experiment.refuse_differences()?;
        Ok(experiment)
    }

    /// Differences are from a first combination, seed by seed.
    fn refuse_differences(&self) -> Result<(), Error> {
        let chart = self.charts.iter().position(|chart| chart.is_difference);
        match chart.filter(|_| !self.has_pairs()) {
            Some(i) => {
                let problem = "needs several `seeds`, and values or levels in place of random combinations";
                Err(Error::field(format!("charts[{i}].difference"), problem))
            }
            None => Ok(()),
        }
    }

    /// Whether combinations are compared with the first, seed by seed: there are several seeds, and the first means something.
    pub(crate) fn has_pairs(&self) -> bool {
        self.seeds.count() > 1 && matches!(self.design, Design::Grid | Design::List)
    }

    /// Whether any of its brains is a program.
    pub fn has_programs(&self) -> bool {
        self.all_brains().any(|text| assignment::split(text).1.starts_with(EXEC))
    }

    /// The brains of the experiment, and those that fields set.
    pub(crate) fn all_brains(&self) -> impl Iterator<Item = &str> {
        let levels = self.fields.iter().filter_map(Field::levels).flatten();
        let varied = levels.flat_map(|level| &level.settings).filter_map(|setting| match setting {
            Setting::Brain(brain) => Some(brain),
            Setting::Scenario { .. } | Setting::Parameter { .. } => None,
        });
        self.brains.iter().chain(varied).map(String::as_str)
    }

    /// The number of runs: at most [`MOST_RUNS`].
    ///
    /// # Errors
    /// If there are none or more, or the fields do not suit the design.
    pub fn runs(&self) -> Result<u64, Error> {
        self.refuse_tuning()?;
        let (cells, seeds) = (self.design.cells(&self.fields)?, self.seeds.count());
        let path = match self.design {
            _ if seeds >= cells => "seeds",
            Design::Random { .. } => "samples",
            Design::Grid | Design::List => "fields",
        };
        bounded(path, u128::from(cells) * u128::from(seeds))
    }

    /// Ranges are for a tuning if there is one.
    fn refuse_tuning(&self) -> Result<(), Error> {
        let range = self.fields.iter().position(|field| field.levels().is_none());
        match (range, &self.design) {
            (Some(i), Design::Grid | Design::List) if self.tuning.is_some() => {
                let problem = "is a range that is tuned: with its table [tune] this is an experiment for `baudbot tune`; \
                               for a sweep give `values`";
                Err(Error::field(format!("fields[{i}]"), problem))
            }
            (Some(_) | None, Design::Grid | Design::List | Design::Random { .. }) => Ok(()),
        }
    }

    /// The combination of this number.
    pub fn cell(&self, number: u64) -> Cell {
        self.design.cell(&self.fields, number)
    }

    /// The run of this number: all seeds of a combination, then those of the next.
    pub fn task(&self, run: u64) -> Task {
        let seeds = self.seeds.count();
        Task { run, cell: self.cell(run / seeds), seed: self.seeds.get(run % seeds) }
    }

    /// The columns of the table.
    pub fn columns(&self) -> Vec<String> {
        let labels = self.fields.iter().map(|field| field.label.as_str());
        run_record::columns(labels, self.has_success(), !self.requirements.is_empty())
            .map(str::to_owned)
            .collect()
    }

    /// Whether anything counts as success.
    pub fn has_success(&self) -> bool {
        self.success.is_some() || !self.requirements.is_empty()
    }

    /// Whether a run succeeded, if anything counts as success: it meets the conditions and keeps to what is required. One that could not
    /// be did not.
    pub fn succeeded(&self, row: &Row) -> Option<bool> {
        let meets = |ran: &Ran| self.success.as_ref().is_none_or(|success| success.of(&ran.figures));
        let keeps = |ran: &Ran| ran.fall.is_none_or(|fall| fall.holds);
        self.has_success().then(|| row.outcome.as_ref().is_ok_and(|ran| meets(ran) && keeps(ran)))
    }

    /// What counts as success, in words.
    pub fn success_text(&self) -> Option<String> {
        let conditions = self.success.iter().map(ToString::to_string);
        let all: Vec<_> = conditions.chain(self.requirements.iter().map(ToString::to_string)).collect();
        self.has_success().then(|| all.join(", "))
    }

    /// Whether its runs are to be seen at each tick, which only a world in this process lets anybody do.
    pub(crate) fn is_observed(&self) -> bool {
        let conditions = self.success.iter().flat_map(|success| success.figures());
        let charts = self.charts.iter().filter_map(|chart| chart.figure);
        let goals = self.tuning.iter().flat_map(|tuning| tuning.goal.figures());
        let is_asked = self.nearness || !self.requirements.is_empty();
        is_asked || conditions.chain(charts).chain(goals).any(Figure::is_observed)
    }

    /// The place of a field by its label, or by the path that it varies.
    ///
    /// # Errors
    /// If there is none, with those that there are.
    pub fn place(&self, name: &str) -> Result<usize, UnknownName> {
        factor::place(&self.fields, name)
    }
}

/// Refuses more runs than an experiment can have; `path` is the field that they are so many by.
pub(crate) fn bounded(path: &str, runs: u128) -> Result<u64, Error> {
    let few = u64::try_from(runs).ok().filter(|&runs| runs <= MOST_RUNS);
    few.ok_or_else(|| {
        Error::field(path, format!("make {runs} runs, and an experiment has at most {MOST_RUNS}"))
    })
}

fn unique(fields: &[Field]) -> Result<(), Error> {
    for (i, field) in fields.iter().enumerate() {
        let at = || format!("fields[{i}].label");
        if field.label.is_empty() {
            return Err(Error::field(at(), "is empty"));
        }
        if run_record::is_column(&field.label) {
            return Err(Error::field(
                at(),
                format!("`{}` is a column of the table already; choose another", field.label),
            ));
        }
        if fields[..i].iter().any(|other| other.label == field.label) {
            return Err(Error::field(
                at(),
                format!("`{}` appears twice; change one of the labels", field.label),
            ));
        }
    }
    Ok(())
}

fn brains(one: Option<Value>, many: Option<Vec<String>>) -> Result<(Vec<String>, Lifetime), Error> {
    let (brains, lifetime) = match (one, many) {
        (Some(_), Some(_)) => {
            return Err(Error::field("brains", "conflicts with `brain`; give only one of them"));
        }
        (Some(brain), None) => {
            let (brain, lifetime) = brain_text(brain)?;
            (vec![brain], lifetime)
        }
        (None, Some(brains)) => (brains, Lifetime::Run),
        (None, None) => (vec![assignment::DEFAULT.to_owned()], Lifetime::Run),
    };
    Ok((brains, lifetime))
}

/// The brain of all robots: its name, or a program as a table.
fn brain_text(brain: Value) -> Result<(String, Lifetime), Error> {
    if let Value::String(name) = brain {
        return Ok((name, Lifetime::Run));
    }
    let Value::Table(table) = brain else {
        let problem = format!("must be the name of a brain, or a table with `exec`, is {brain}");
        return Err(Error::field("brain", problem));
    };
    if let Some(Value::String(name)) = table.get("name").filter(|_| !table.contains_key("exec")) {
        let problem = format!("is a table, which is for a program; write brain = {name:?}");
        return Err(Error::field("brain", problem));
    }
    let at = |path: &str| if path.is_empty() { "brain".to_owned() } else { format!("brain.{path}") };
    let program: raw::Program = fields_of(table, at)?;
    if program.exec.trim().is_empty() {
        return Err(Error::field("brain.exec", "is empty; write it as in exec = \"python3 follow.py\""));
    }
    let lifetime = if program.reuse { Lifetime::ManyRuns } else { Lifetime::Run };
    Ok((format!("{EXEC}{}", program.exec), lifetime))
}

fn find_of(raw: &raw::Find) -> Result<Find, Error> {
    let share = within("find.share", raw.share.unwrap_or(1.0), 1.0)?;
    if let Some(tolerance) = raw.tolerance.filter(|tolerance| !(tolerance.is_finite() && *tolerance > 0.0)) {
        return Err(Error::field("find.tolerance", format!("must be positive, is {tolerance}")));
    }
    Ok(Find { wants: raw.wants, share, tolerance: raw.tolerance })
}

/// Most runs of an experiment. The journal of so many has about ten gigabytes, and what is known of its lines needs a few hundred
/// megabytes.
pub const MOST_RUNS: u64 = 10_000_000;
