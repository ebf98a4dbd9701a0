//! Experiments: many runs on all cores, as the commands `sweep`, `tune` and `worst` do them.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use baudbot_experiment::{
    BRAIN_TIMEOUT, Error, Experiment, Limit, Merged, Missing, Options, Packed, Place, ReadError, Seeds,
    Shard, ShardError, trial,
};
use pyo3::prelude::*;

use crate::errors::{apart, failed, invalid};

/// The result of a sweep or a tuning: its report, as JSON, the files, whether it was stopped, and its warnings.
type Done = (String, Vec<String>, bool, Vec<String>);

/// An experiment without files: the text of its file, the name that it has without one of its own, the text of its scenario, and programs
/// of microcontrollers by the names of their files.
type Parts = (String, String, String, BTreeMap<String, String>);

/// An experiment's file, or an experiment that came from another machine.
#[derive(FromPyObject)]
pub(crate) enum Given {
    Packed(Parts),
    File(PathBuf),
}

/// The request for an experiment.
struct Asked {
    experiment: Given,
    out: PathBuf,
    seeds: Option<String>,
    jobs: usize,
    fresh: bool,
    shard: Option<Shard>,
}

/// Runs an experiment, or a shard of it. `progress`, if it is not None, is called with the numbers of runs done and of all.
#[pyfunction]
#[pyo3(signature = (experiment, out, seeds, jobs, fresh, progress, shard))]
#[expect(
    clippy::too_many_arguments,
    reason = "the interpreter is one of them, and a Python module passes the others"
)]
pub(crate) fn sweep(
    py: Python<'_>,
    experiment: Given,
    out: PathBuf,
    seeds: Option<String>,
    jobs: usize,
    fresh: bool,
    progress: Option<Py<PyAny>>,
    shard: Option<&str>,
) -> PyResult<Done> {
    work(
        py,
        Asked { experiment, out, seeds, jobs, fresh, shard: shard_of(py, shard)? },
        progress.as_ref(),
        |experiment, options| {
            let swept = baudbot_experiment::sweep(experiment, options)?;
            let json = swept.summary.json(experiment).to_string();
            Ok((json, swept.files, swept.interrupted))
        },
    )
}

fn shard_of(py: Python<'_>, shard: Option<&str>) -> PyResult<Option<Shard>> {
    let wrong = |error: ShardError| invalid(py, &format!("shard: {error}"), Some("shard".to_owned()));
    shard.map(Shard::from_str).transpose().map_err(wrong)
}

/// Makes the tables of an experiment of the journals of its shards.
#[pyfunction]
#[pyo3(signature = (experiment, sources, out, seeds, fresh))]
pub(crate) fn merge(
    py: Python<'_>,
    experiment: Given,
    sources: Vec<PathBuf>,
    out: PathBuf,
    seeds: Option<String>,
    fresh: bool,
) -> PyResult<Done> {
    let asked = Asked { experiment, out, seeds, jobs: 1, fresh, shard: None };
    work(py, asked, None, move |experiment, options| {
        match baudbot_experiment::merge(experiment, &sources, options)? {
            Merged::Whole(swept) => {
                Ok((swept.summary.json(experiment).to_string(), swept.files, swept.interrupted))
            }
            Merged::Missing(Missing { runs, total, .. }) => Err(Error::Refused(format!(
                "{runs} of {total} runs are missing, so that nothing was written"
            ))),
        }
    })
}

/// Tunes an experiment; see [`sweep`].
#[pyfunction]
#[pyo3(signature = (experiment, out, seeds, jobs, fresh, progress))]
pub(crate) fn tune(
    py: Python<'_>,
    experiment: Given,
    out: PathBuf,
    seeds: Option<String>,
    jobs: usize,
    fresh: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Done> {
    let asked = Asked { experiment, out, seeds, jobs, fresh, shard: None };
    work(py, asked, progress.as_ref(), |experiment, options| {
        let tuned = baudbot_experiment::tune(experiment, options)?;
        Ok((tuned.json(experiment).to_string(), tuned.files.clone(), tuned.interrupted))
    })
}

/// Looks for the worst runs of an experiment, or does a shard of that; see [`sweep`]. At most so many `runs`, none of which begins after so
/// many seconds.
#[pyfunction]
#[pyo3(signature = (experiment, out, seeds, jobs, fresh, progress, runs, within_s, first, shard))]
#[expect(
    clippy::too_many_arguments,
    reason = "the interpreter is one of them, and a Python module passes the others"
)]
pub(crate) fn worst(
    py: Python<'_>,
    experiment: Given,
    out: PathBuf,
    seeds: Option<String>,
    jobs: usize,
    fresh: bool,
    progress: Option<Py<PyAny>>,
    runs: Option<u64>,
    within_s: Option<f64>,
    first: bool,
    shard: Option<&str>,
) -> PyResult<Done> {
    let within = within_s.map(Duration::try_from_secs_f64).transpose();
    let within =
        within.map_err(|error| invalid(py, &format!("within_s: {error}"), Some("within_s".to_owned())))?;
    let asked = Asked { experiment, out, seeds, jobs, fresh, shard: shard_of(py, shard)? };
    work(py, asked, progress.as_ref(), move |experiment, options| {
        let worst = baudbot_experiment::worst(experiment, options, Limit { runs, within, first })?;
        Ok((worst.json(experiment).to_string(), worst.files.clone(), worst.interrupted))
    })
}

/// Makes the results of a search of the journals of its shards, which did so many `runs` together.
#[pyfunction]
#[pyo3(signature = (experiment, sources, out, seeds, fresh, runs))]
pub(crate) fn merge_worst(
    py: Python<'_>,
    experiment: Given,
    sources: Vec<PathBuf>,
    out: PathBuf,
    seeds: Option<String>,
    fresh: bool,
    runs: u64,
) -> PyResult<Done> {
    let asked = Asked { experiment, out, seeds, jobs: 1, fresh, shard: None };
    work(py, asked, None, move |experiment, options| {
        let limit = Limit { runs: Some(runs), within: None, first: false };
        let worst = baudbot_experiment::merge_worst(experiment, &sources, options, limit)?;
        Ok((worst.json(experiment).to_string(), worst.files.clone(), worst.interrupted))
    })
}

/// A run of an experiment with these values of its fields and this seed: how it keeps to what is required, as JSON.
#[pyfunction]
pub(crate) fn cost(
    py: Python<'_>,
    file: PathBuf,
    values: BTreeMap<String, f64>,
    seed: u64,
) -> PyResult<String> {
    let run = move || -> Result<String, Problem> {
        let experiment = Experiment::read(&file).map_err(of_reading)?;
        let tried = trial(&experiment, &values, seed).map_err(|error| (error.to_string(), error.path()))?;
        Ok(tried.to_string())
    };
    apart(py, run)?.map_err(|(text, path)| invalid(py, &text, path))
}

/// An experiment for other machines, and how many runs it has. A search has as many as are wanted, in shards if its method has them.
#[pyfunction]
#[pyo3(signature = (file, seeds, search_runs))]
pub(crate) fn pack(
    py: Python<'_>,
    file: PathBuf,
    seeds: Option<&str>,
    search_runs: Option<u64>,
) -> PyResult<(Parts, u64)> {
    let pack = || -> Result<_, Problem> {
        let (packed, experiment) = Packed::of_file(&file).map_err(of_reading)?;
        let experiment = with_seeds(experiment, seeds)?;
        let runs = search_runs.map_or_else(
            || experiment.runs(),
            |runs| baudbot_experiment::worst::check_shards(&experiment).map(|()| runs),
        );
        Ok((packed, runs.map_err(|error| (format!("{}: {error}", file.display()), error.path()))?))
    };
    let (packed, runs) = apart(py, pack)?.map_err(|(text, path)| invalid(py, &text, path))?;
    let Packed { text, name, scenario, programs } = packed;
    Ok(((text, name, scenario, programs), runs))
}

/// The report of an experiment, as JSON, its files, and whether it was stopped.
type Told = (String, Vec<PathBuf>, bool);

type Outcome = Result<Told, Error>;

/// The state that a worker shares with the thread that called it.
#[derive(Default)]
struct Watched {
    stop: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    warnings: Mutex<Vec<String>>,
}

/// A fault, and the path of the field that has it, if it is one.
type Problem = (String, Option<String>);

/// Does it, and tells how far it is.
fn work(
    py: Python<'_>,
    asked: Asked,
    progress: Option<&Py<PyAny>>,
    what: impl FnOnce(&Experiment, &Options<'_>) -> Outcome + Send + 'static,
) -> PyResult<Done> {
    let watched = Arc::new(Watched::default());
    let theirs = Arc::clone(&watched);
    let worker = thread::spawn(move || theirs.work(&asked, what));
    let counted = || (watched.done.load(Ordering::Relaxed), watched.total.load(Ordering::Relaxed));
    let told = Cell::new(None);
    let tell = || match progress {
        Some(progress) if told.replace(Some(counted())) != Some(counted()) => {
            progress.call1(py, counted()).map(|_| ())
        }
        Some(_) | None => Ok(()),
    };
    let outcome = join(py, worker, &watched.stop, tell)?;
    let (json, files, interrupted) = outcome.map_err(|(text, path)| invalid(py, &text, path))?;
    let warnings = std::mem::take(&mut *locked(&watched.warnings));
    Ok((json, files.iter().map(|file| file.display().to_string()).collect(), interrupted, warnings))
}

impl Watched {
    fn work(
        &self,
        asked: &Asked,
        what: impl FnOnce(&Experiment, &Options<'_>) -> Outcome,
    ) -> Result<Told, Problem> {
        let experiment = read(&asked.experiment, asked.seeds.as_deref())?;
        let count = |now: u64, all: u64| {
            self.done.store(now, Ordering::Relaxed);
            self.total.store(all, Ordering::Relaxed);
        };
        let options = Options {
            out: &asked.out,
            fresh: asked.fresh,
            place: Place::Here,
            jobs: asked.jobs,
            brain_timeout: BRAIN_TIMEOUT,
            confirmed: true,
            shard: asked.shard,
            stop: &self.stop,
            progress: &count,
            tell: &|told| match told {
                baudbot_experiment::Told::Warning(text) => locked(&self.warnings).push(text.clone()),
                // A notebook that runs a cell again expects this.
                baudbot_experiment::Told::Note(_) => {}
            },
        };
        what(&experiment, &options)
            .map_err(|error| (format!("{}: {error}", name(&asked.experiment)), error.path()))
    }
}

/// Waits for what another thread does, looks for Ctrl-C and calls `tell`. If either raises an exception, the work is told to stop, and what
/// was begun is waited for, so that it is in the journal. Who does not want that either presses Ctrl-C again.
fn join<T>(
    py: Python<'_>,
    worker: JoinHandle<T>,
    stop: &AtomicBool,
    tell: impl Fn() -> PyResult<()>,
) -> PyResult<T> {
    let mut stopped = None;
    loop {
        let is_done = worker.is_finished();
        if stopped.is_some() {
            py.check_signals()?;
        } else if let Err(error) = tell().and_then(|()| py.check_signals()) {
            stop.store(true, Ordering::Relaxed);
            stopped = Some(error);
        }
        if is_done {
            let outcome = worker.join();
            return stopped.map_or_else(
                || outcome.map_err(|_| failed(py, "baudbot panicked, which is a bug in it")),
                Err,
            );
        }
        py.detach(|| thread::sleep(INTERVAL));
    }
}

fn read(given: &Given, seeds: Option<&str>) -> Result<Experiment, Problem> {
    let experiment = match given {
        Given::File(path) => Experiment::read(path).map_err(of_reading)?,
        Given::Packed((text, name, scenario, programs)) => {
            let (text, name, scenario) = (text.clone(), name.clone(), scenario.clone());
            let packed = Packed { text, name, scenario, programs: programs.clone() };
            packed.experiment().map_err(|error| (error.to_string(), error.path()))?
        }
    };
    with_seeds(experiment, seeds)
}

fn with_seeds(experiment: Experiment, seeds: Option<&str>) -> Result<Experiment, Problem> {
    let seeds = seeds.map(Seeds::parse).transpose().map_err(|error| (error.to_string(), error.path()))?;
    Ok(Experiment { seeds: seeds.unwrap_or_else(|| experiment.seeds.clone()), ..experiment })
}

fn of_reading(error: ReadError) -> Problem {
    let path = match &error {
        ReadError::File(_) => None,
        ReadError::Content { error, .. } => error.path(),
    };
    (error.to_string(), path)
}

/// The value behind a lock. A thread that panicked meanwhile has said so.
fn locked<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The name of an experiment in errors.
fn name(given: &Given) -> String {
    match given {
        Given::File(path) => path.display().to_string(),
        Given::Packed((_, name, ..)) => name.clone(),
    }
}

const INTERVAL: Duration = Duration::from_millis(10);
