//! An experiment's file and what its runs are done with, for `sweep` and `tune`; runs on threads, for `grade`, too.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use baudbot_experiment::{Error, Experiment, Options, Place, Seeds, Shard};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::args::WorkArgs;
use crate::error::Refused;
use crate::signals::Stop;

/// Lets work be done on threads of its own. A signal sets what the work is given; the work then ends by itself.
pub(crate) async fn until_stopped(
    work: impl FnOnce(&AtomicBool) -> anyhow::Result<ExitCode> + Send + 'static,
) -> anyhow::Result<ExitCode> {
    let mut listening = Stop::listen().context("cannot listen for Ctrl-C")?;
    let stop = Arc::new(AtomicBool::new(false));
    let told = Arc::clone(&stop);
    let mut work = tokio::task::spawn_blocking(move || work(&told));
    tokio::select! {
        done = &mut work => return done.context("the experiment panicked")?,
        () = listening.wait() => stop.store(true, Ordering::Relaxed),
    }
    work.await.context("the experiment panicked")?
}

/// The experiment that the arguments name.
pub(crate) fn read(args: &WorkArgs) -> anyhow::Result<Experiment> {
    let read = Experiment::read(&args.experiment);
    let mut experiment = read.map_err(|error| Refused::error(error.to_string()))?;
    if let Some(seeds) = &args.seeds {
        experiment.seeds = Seeds::parse(seeds).map_err(|error| Refused::error(format!("--{error}")))?;
    }
    Ok(experiment)
}

/// Where it is done, and how.
pub(crate) fn options<'a>(
    args: &WorkArgs,
    out: &'a Path,
    shard: Option<Shard>,
    stop: &'a AtomicBool,
    progress: &'a (dyn Fn(u64, u64) + Sync),
    tell: &'a (dyn Fn(&str) + Sync),
) -> Options<'a> {
    let (place, jobs) = (place(args), jobs(args));
    Options { out, fresh: args.fresh, shard, place, jobs, confirmed: args.yes, stop, progress, tell }
}

pub(crate) fn place(args: &WorkArgs) -> Place {
    args.connect.clone().map_or(Place::Here, Place::Server)
}

pub(crate) fn jobs(args: &WorkArgs) -> usize {
    jobs_of(args.jobs)
}

/// As many as there are processors, unless the arguments say how many.
pub(crate) fn jobs_of(jobs: Option<u16>) -> usize {
    let processors = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    jobs.map_or_else(processors, usize::from)
}

/// The folder for what comes of it.
pub(crate) fn out(args: &WorkArgs, experiment: &Experiment, ending: &str) -> PathBuf {
    args.out.clone().unwrap_or_else(|| default_out(experiment, ending))
}

/// The folder if the arguments name none.
pub(crate) fn default_out(experiment: &Experiment, ending: &str) -> PathBuf {
    let fits = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let name: String = experiment.name.chars().take(64).map(|c| if fits(c) { c } else { '-' }).collect();
    PathBuf::from(format!("{name}.{ending}"))
}

/// Errors of the file begin with its name.
pub(crate) fn from_experiment(args: &WorkArgs, error: Error) -> anyhow::Error {
    if matches!(error, Error::Field { .. } | Error::Syntax(_)) {
        Refused::error(format!("{}: {error}", args.experiment.display()))
    } else if error.is_refusal() {
        Refused::error(error.to_string())
    } else {
        error.into()
    }
}

pub(crate) fn progress(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} to go");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
