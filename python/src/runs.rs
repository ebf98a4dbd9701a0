//! Experiments: many runs on all cores, as the commands `sweep` and `tune` do them.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use baudbot_experiment::{Experiment, Options, Place, Seeds};
use pyo3::prelude::*;

use crate::errors::{apart, failed, invalid};

/// How a sweep or a tuning went: what it told, as JSON, the files, whether it was stopped, and its warnings.
type Done = (String, Vec<String>, bool, Vec<String>);

/// What is asked for.
struct Asked {
    experiment: PathBuf,
    out: PathBuf,
    seeds: Option<String>,
    jobs: usize,
    fresh: bool,
}

/// Runs an experiment's file. `progress`, if it is not None, is called with the numbers of runs done and of all.
#[pyfunction]
#[pyo3(signature = (experiment, out, seeds, jobs, fresh, progress))]
pub(crate) fn sweep(
    py: Python<'_>,
    experiment: PathBuf,
    out: PathBuf,
    seeds: Option<String>,
    jobs: usize,
    fresh: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Done> {
    work(py, Asked { experiment, out, seeds, jobs, fresh }, progress.as_ref(), |experiment, options| {
        let swept = baudbot_experiment::sweep(experiment, options)?;
        let json = swept.summary.json(experiment).to_string();
        Ok((json, swept.files, swept.interrupted))
    })
}

/// Tunes an experiment's file; see [`sweep`].
#[pyfunction]
#[pyo3(signature = (experiment, out, seeds, jobs, fresh, progress))]
pub(crate) fn tune(
    py: Python<'_>,
    experiment: PathBuf,
    out: PathBuf,
    seeds: Option<String>,
    jobs: usize,
    fresh: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Done> {
    work(py, Asked { experiment, out, seeds, jobs, fresh }, progress.as_ref(), |experiment, options| {
        let tuned = baudbot_experiment::tune(experiment, options)?;
        Ok((tuned.json(experiment).to_string(), tuned.files.clone(), tuned.interrupted))
    })
}

type Outcome = Result<(String, Vec<PathBuf>, bool), baudbot_experiment::Error>;

/// Does it on another thread, so that this one can look for Ctrl-C and tell how far it is.
fn work(
    py: Python<'_>,
    asked: Asked,
    progress: Option<&Py<PyAny>>,
    what: impl FnOnce(&Experiment, &Options<'_>) -> Outcome + Send,
) -> PyResult<Done> {
    let experiment = read(py, &asked)?;
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
        shard: None,
        stop: &stop,
        progress: &count,
        tell: &tell,
    };
    let (experiment, options, stop, done, total) = (&experiment, &options, &stop, &done, &total);
    let outcome = std::thread::scope(|scope| -> PyResult<Outcome> {
        let worker = scope.spawn(move || what(experiment, options));
        let mut told = None;
        loop {
            if worker.is_finished() {
                return worker.join().map_err(|_| failed(py, "baudbot panicked, which is a bug in it"));
            }
            py.detach(|| std::thread::sleep(INTERVAL));
            let now = (done.load(Ordering::Relaxed), total.load(Ordering::Relaxed));
            let told_all = match progress {
                Some(progress) if told != Some(now) => progress.call1(py, now).map(|_| ()),
                Some(_) | None => Ok(()),
            };
            told = Some(now);
            if let Err(error) = told_all.and_then(|()| py.check_signals()) {
                stop.store(true, Ordering::Relaxed);
                // What was begun is finished, and is in the journal.
                let _ = py.detach(|| worker.join());
                return Err(error);
            }
        }
    })?;
    let (json, files, interrupted) = outcome
        .map_err(|error| invalid(py, &format!("{}: {error}", asked.experiment.display()), error.path()))?;
    let warnings = warnings.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    Ok((json, files.iter().map(|file| file.display().to_string()).collect(), interrupted, warnings))
}

fn read(py: Python<'_>, asked: &Asked) -> PyResult<Experiment> {
    let path: &Path = &asked.experiment;
    let read = apart(py, || Experiment::read(path))?;
    let mut experiment = read.map_err(|error| invalid(py, &error.to_string(), None))?;
    if let Some(seeds) = &asked.seeds {
        experiment.seeds =
            Seeds::parse(seeds).map_err(|error| invalid(py, &error.to_string(), Some("seeds".to_owned())))?;
    }
    Ok(experiment)
}

const INTERVAL: Duration = Duration::from_millis(10);
