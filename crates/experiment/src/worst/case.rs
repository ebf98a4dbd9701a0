//! A case: a scenario with its brains in which a requirement falls, or is kept least.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use super::Worst;
use super::report::Tightness;
use super::shrink::Draft;
use super::splitting::take;
use crate::design::Cell;
use crate::error::Error;
use crate::experiment::Experiment;
use crate::factor::{Level, Setting};
use crate::pool::Workers;
use crate::requirement::Fall;
use crate::run_options::{RunOptions, quoted};
use crate::run_record::{Ran, RunError, Task};
use crate::sweep::Options;
use crate::told::Told;

/// A scenario that fails, or comes nearest to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The number of the run that it was made of.
    pub run: u64,
    /// The scenario.
    pub toml: String,
    /// The brains, as for `--brain`.
    pub brains: Vec<String>,
    /// The folder in which they run, if they are programs: the experiment's.
    pub folder: Option<PathBuf>,
    /// The parameters of programs, as for `--parameter`.
    pub parameters: Vec<String>,
    /// What differs from the experiment's scenario, as for `--set`.
    pub changes: Vec<String>,
    /// The requirement, as for `--require`.
    pub requirement: String,
    /// The name of the robot.
    pub robot: String,
    /// How the requirement falls.
    pub fall: Fall,
    /// The fingerprint of the final state.
    pub hash: u64,
    /// What happened, in a sentence.
    pub account: String,
    /// The longest control cycle beside what the budget foretells, if a cycle was answered.
    pub tightness: Option<Tightness>,
    /// The number of runs that it took to make the case plain.
    pub trials: u64,
    /// Whether nothing more can be left out of it; if not, the runs for that were used up, or it does not fail.
    pub is_plainest: bool,
}

impl Case {
    /// The options of `baudbot run` besides the scenario.
    pub fn options(&self) -> Vec<String> {
        let option = |name: &'static str| move |text: &String| [name.to_owned(), text.clone()];
        let brains = self.brains.iter().flat_map(option("--brain"));
        let all = brains.chain(self.parameters.iter().flat_map(option("--parameter")));
        all.chain(["--require".to_owned(), self.requirement.clone()]).collect()
    }

    /// How plain it is, in words.
    pub(super) fn plainness(&self) -> String {
        match (self.fall.holds, self.is_plainest) {
            (true, _) => "as it was drawn, since it does not fail".to_owned(),
            (false, true) => format!("made plain with {} runs", self.trials),
            (false, false) => {
                format!(
                    "made plainer with {} runs, the most that this may take; more may be left out",
                    self.trials
                )
            }
        }
    }

    /// The command that does the run again, for a scenario in this file; from any folder, if its brains are programs.
    pub fn command(&self, file: &Path) -> String {
        let words = self.options();
        let words = words.iter().map(|word| if word.starts_with("--") { word.clone() } else { quoted(word) });
        let words = words.collect::<Vec<_>>().join(" ");
        match &self.folder {
            Some(folder) => {
                let [folder, file] =
                    [folder, &absolute(file)].map(|path| quoted(&path.display().to_string()));
                format!("cd {folder} && baudbot run {file} {words}")
            }
            None => format!("baudbot run {} {words}", file.display()),
        }
    }
}

/// The case of the worst run: made as plain as it can be if the robot fails in it; `None` if there is no run, or it was stopped.
pub(super) fn worst_case(
    experiment: &Experiment,
    worst: &Worst,
    options: &Options<'_>,
    by: Trials<'_>,
) -> Result<Option<Case>, Error> {
    let Some(tried) = worst.worst.first() else { return Ok(None) };
    let RunOptions { brains, parameters, sets } = RunOptions::new(experiment, &tried.task.cell.levels);
    let base =
        experiment.text.parse().map_err(|error: toml_edit::TomlError| Error::Syntax(error.to_string()))?;
    let seconds = experiment.seconds.map(|seconds| format!("end.after_s={seconds:?}"));
    let sets = seconds.into_iter().chain(sets).chain([format!("seed={}", tried.task.seed)]).collect();
    let court = Court { experiment, options, by, brains, parameters };
    let mut draft = Draft::new(base, sets);
    let Some(ran) = court.run(&draft.toml()?, 0)? else { return Ok(None) };
    let (mut trials, mut is_plainest) = (1, false);
    let mut ran = ran.map_err(|error| {
        Error::Refused(format!("the worst run, {}, cannot be done again: {error}", tried.task.run))
    })?;
    if ran.hash != tried.hash {
        return Err(Error::Refused(format!(
            "the worst run, {}, ended with the state {:016x}, and done again with {:016x}: the brain is not deterministic, or was changed \
             since (--fresh searches anew), so what was found says nothing; does it use the wall clock, or random numbers of its own?",
            tried.task.run, tried.hash, ran.hash
        )));
    }
    if !tried.fall.holds {
        let note = format!("run {} fails; it is made plain, which takes some hundred runs", tried.task.run);
        (options.tell)(&Told::Note(note));
        match draft.shrink(&court, ran, &mut trials)? {
            Some(plain) => (ran, is_plainest) = plain,
            None => return Ok(None),
        }
    }
    let case = court.case(tried.task.run, &draft, &ran)?;
    Ok(Some(Case { trials, is_plainest, ..case }))
}

/// The means of making a case plain.
#[derive(Clone, Copy)]
pub(super) struct Trials<'a> {
    /// They do its runs.
    pub(super) workers: &'a Workers,
    /// No run begins any more then, by the wall clock.
    pub(super) until: Option<Instant>,
}

/// The path from the root, as far as the current folder is known.
fn absolute(path: &Path) -> PathBuf {
    std::env::current_dir().unwrap_or_default().join(path)
}

/// The place where drafts are tried.
pub(super) struct Court<'a> {
    experiment: &'a Experiment,
    options: &'a Options<'a>,
    by: Trials<'a>,
    brains: Vec<String>,
    parameters: Vec<String>,
}

impl Court<'_> {
    /// Runs of scenarios, side by side; `None` if they were stopped.
    pub(super) fn run_all(&self, texts: &[&str]) -> Result<Option<Vec<Result<Ran, RunError>>>, Error> {
        let (next, mut all) = (AtomicUsize::new(0), vec![None; texts.len()]);
        let work = || -> Result<Vec<_>, Error> {
            let mut done = Vec::new();
            while let Some((place, text)) = take(&next, texts) {
                done.push((place, self.run(text, place)?));
            }
            Ok(done)
        };
        let panicked = || Err(Error::Refused("a run panicked, which is a bug in baudbot".to_owned()));
        let each = std::thread::scope(|scope| {
            let workers: Vec<_> =
                (0..self.options.jobs.clamp(1, texts.len().max(1))).map(|_| scope.spawn(work)).collect();
            let each = workers.into_iter().map(|worker| worker.join().unwrap_or_else(|_| panicked()));
            each.collect::<Result<Vec<_>, _>>()
        })?;
        for (place, ran) in each.into_iter().flatten() {
            all[place] = ran;
        }
        Ok(all.into_iter().collect())
    }

    /// A run of a scenario with the brains of the case, with a number that no other has at the same time; `None` if it was stopped.
    pub(super) fn run(&self, toml: &str, number: usize) -> Result<Option<Result<Ran, RunError>>, Error> {
        let mut experiment = self.experiment.clone();
        experiment.seconds = None;
        toml.clone_into(&mut experiment.text);
        self.brains.clone_into(&mut experiment.brains);
        let parameters = self.parameters.iter().filter_map(|text| text.split_once('='));
        let parameter = |(name, value): (&str, &str)| Setting::Parameter {
            name: name.to_owned(),
            value: value.to_owned(),
        };
        let settings = parameters.map(parameter).collect();
        let level = Level { name: String::new(), number: None, settings };
        let seed = baudbot_scenario::parse(toml).map_or(1, |scenario| scenario.seed);
        let task = Task { run: number as u64, cell: Cell { number: 0, levels: vec![level] }, seed };
        if self.options.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        Ok(Some(self.by.workers.run(&experiment, &task)?.outcome))
    }

    /// Whether no run is to begin any more.
    pub(super) fn is_over(&self) -> bool {
        self.by.until.is_some_and(|until| Instant::now() >= until)
    }

    fn case(&self, run: u64, draft: &Draft, ran: &Ran) -> Result<Case, Error> {
        let toml = draft.toml()?;
        let scenario = baudbot_scenario::parse(&toml).map_err(|error| Error::Refused(error.to_string()))?;
        let fall = ran.fall.ok_or_else(|| Error::Refused("nothing is required of the run".to_owned()))?;
        let demand = &self.experiment.requirements[fall.requirement as usize];
        let spec = &scenario.robots[fall.robot as usize];
        Ok(Case {
            run,
            brains: self.brains.clone(),
            folder: self.experiment.has_programs().then(|| absolute(&self.experiment.folder)),
            parameters: self.parameters.clone(),
            changes: draft.changes(),
            requirement: demand.to_string(),
            robot: spec.name.clone(),
            account: super::report::account(demand, spec, ran, &fall),
            tightness: Tightness::of(&scenario, spec, &fall),
            toml,
            fall,
            hash: ran.hash,
            trials: 0,
            is_plainest: false,
        })
    }
}
