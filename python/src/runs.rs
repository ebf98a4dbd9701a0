//! Experiments: many runs on all cores, as the commands `sweep` and `tune` do them.

use std::cell::Cell;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use baudbot_experiment::{Error, Experiment, Merged, Missing, Options, Place, Seeds, Shard, ShardError};
use baudbot_launch::EXEC;
use pyo3::prelude::*;

use crate::errors::{apart, failed, invalid};

/// How a sweep or a tuning went: what it told, as JSON, the files, whether it was stopped, and its warnings.
type Done = (String, Vec<String>, bool, Vec<String>);

/// An experiment without files: the text of its file, the name that it has without one of its own, and the text of its scenario.
type Packed = (String, String, String);

/// An experiment's file, or an experiment that came from another machine.
#[derive(FromPyObject)]
pub(crate) enum Given {
    Packed(Packed),
    File(PathBuf),
}

/// What is asked for.
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
    let wrong = |error: ShardError| invalid(py, &format!("shard: {error}"), Some("shard".to_owned()));
    let shard = shard.map(Shard::from_str).transpose().map_err(wrong)?;
    work(
        py,
        Asked { experiment, out, seeds, jobs, fresh, shard },
        progress.as_ref(),
        |experiment, options| {
            let swept = baudbot_experiment::sweep(experiment, options)?;
            let json = swept.summary.json(experiment).to_string();
            Ok((json, swept.files, swept.interrupted))
        },
    )
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
    work(py, asked, None, |experiment, options| {
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

/// An experiment for other machines, and how many runs it has.
#[pyfunction]
pub(crate) fn pack(py: Python<'_>, file: PathBuf, seeds: Option<String>) -> PyResult<(Packed, u64)> {
    let experiment = read(py, &Given::File(file.clone()), seeds.as_deref())?;
    if experiment.brains.iter().any(|brain| brain.contains(EXEC)) {
        let problem = format!("{}: its brain is a program, which other machines do not have", file.display());
        return Err(invalid(py, &problem, Some("brain.exec".to_owned())));
    }
    let text = baudbot_import::source::read(&file.display().to_string())
        .map_err(|error| failed(py, &error.to_string()))?;
    let runs = experiment.runs().map_err(|error| invalid(py, &error.to_string(), error.path()))?;
    Ok(((text, experiment.name.clone(), experiment.text), runs))
}

type Outcome = Result<(String, Vec<PathBuf>, bool), Error>;

/// Does it, and tells how far it is.
fn work(
    py: Python<'_>,
    asked: Asked,
    progress: Option<&Py<PyAny>>,
    what: impl FnOnce(&Experiment, &Options<'_>) -> Outcome + Send,
) -> PyResult<Done> {
    let experiment = read(py, &asked.experiment, asked.seeds.as_deref())?;
    let (stop, done, total) = (AtomicBool::new(false), AtomicU64::new(0), AtomicU64::new(0));
    let warnings = Mutex::new(Vec::new());
    let tell =
        |text: &str| warnings.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(text.to_owned());
    let count = |now: u64, all: u64| {
        done.store(now, Ordering::Relaxed);
        total.store(all, Ordering::Relaxed);
    };
    let options = Options {
        out: &asked.out,
        fresh: asked.fresh,
        place: Place::Here,
        jobs: asked.jobs,
        confirmed: true,
        shard: asked.shard,
        stop: &stop,
        progress: &count,
        tell: &tell,
    };
    let counted = || (done.load(Ordering::Relaxed), total.load(Ordering::Relaxed));
    let told = Cell::new(None);
    let tell = || match progress {
        Some(progress) if told.replace(Some(counted())) != Some(counted()) => {
            progress.call1(py, counted()).map(|_| ())
        }
        Some(_) | None => Ok(()),
    };
    let outcome = watched(py, || what(&experiment, &options), &stop, tell)?;
    let (json, files, interrupted) = outcome
        .map_err(|error| invalid(py, &format!("{}: {error}", name(&asked.experiment)), error.path()))?;
    let warnings = warnings.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    Ok((json, files.iter().map(|file| file.display().to_string()).collect(), interrupted, warnings))
}

/// Does it on another thread, while this one looks for Ctrl-C and calls `tell`. If either raises an exception, the work is told to stop.
fn watched(
    py: Python<'_>,
    work: impl FnOnce() -> Outcome + Send,
    stop: &AtomicBool,
    tell: impl Fn() -> PyResult<()>,
) -> PyResult<Outcome> {
    std::thread::scope(|scope| {
        let worker = scope.spawn(work);
        loop {
            let is_done = worker.is_finished();
            if let Err(error) = tell().and_then(|()| py.check_signals()) {
                stop.store(true, Ordering::Relaxed);
                // What was begun is finished, and is in the journal.
                let _ = py.detach(|| worker.join());
                return Err(error);
            }
            if is_done {
                return worker.join().map_err(|_| failed(py, "baudbot panicked, which is a bug in it"));
            }
            py.detach(|| std::thread::sleep(INTERVAL));
        }
    })
}

fn read(py: Python<'_>, given: &Given, seeds: Option<&str>) -> PyResult<Experiment> {
    let read = || match given {
        Given::File(path) => Experiment::read(path).map_err(|error| error.to_string()),
        Given::Packed((text, name, scenario)) => {
            Experiment::parse(text, name, |_| Ok(scenario.clone())).map_err(|error| error.to_string())
        }
    };
    let mut experiment = apart(py, read)?.map_err(|error| invalid(py, &error, None))?;
    if let Some(seeds) = seeds {
        let wrong = |error: &dyn std::fmt::Display| invalid(py, &error.to_string(), Some("seeds".to_owned()));
        experiment.seeds = Seeds::parse(seeds).map_err(|error| wrong(&error))?;
    }
    Ok(experiment)
}

/// How errors name an experiment.
fn name(given: &Given) -> String {
    match given {
        Given::File(path) => path.display().to_string(),
        Given::Packed((_, name, _)) => name.clone(),
    }
}

const INTERVAL: Duration = Duration::from_millis(10);
