//! An experiment's file and what its runs are done with, for `sweep` and `tune`.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use baudbot_experiment::factor::{Choice, Setting};
use baudbot_experiment::{Error, Experiment, Options, Place, Seeds};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::args::WorkArgs;
use crate::error::Refused;
use crate::scenarios::{self, Source};
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
    let path = args.experiment.display().to_string();
    let toml = scenarios::read(&path)?;
    let stem = args.experiment.file_stem().and_then(|stem| stem.to_str()).unwrap_or("experiment");
    let folder = args.experiment.parent().unwrap_or_else(|| Path::new(""));
    let find = |name: &str| match Source::beside(folder, name) {
        Ok(source) => Ok(source.into_text()),
        Err(error) => Err(error.to_string()),
    };
    let mut experiment =
        Experiment::parse(&toml, stem, find).map_err(|error| Refused::error(format!("{path}: {error}")))?;
    put_programs(&mut experiment, folder).map_err(|error| Refused::error(format!("{path}: {error}")))?;
    experiment.folder = folder.to_owned();
    if let Some(seeds) = &args.seeds {
        experiment.seeds = Seeds::parse(seeds).map_err(|error| Refused::error(format!("--{error}")))?;
    }
    Ok(experiment)
}

/// Puts programs of microcontrollers into the places of their files' names, which are beside the experiment.
fn put_programs(experiment: &mut Experiment, folder: &Path) -> Result<(), String> {
    for (i, field) in experiment.fields.iter_mut().enumerate() {
        let Choice::Levels(levels) = &mut field.choice else { continue };
        for setting in levels.iter_mut().flat_map(|level| &mut level.settings) {
            let Setting::Scenario { path, value } = setting else { continue };
            if path.ends_with(PROGRAM) && !value.starts_with('{') {
                let file = folder.join(value.trim_matches(['"', '\'']));
                *value = baudbot_import::program(&file).map_err(|error| format!("fields[{i}]: {error}"))?;
            }
        }
    }
    Ok(())
}

/// The field that names a file which only a scenario's reader would read.
const PROGRAM: &str = ".microcontroller.program";

/// Where it is done, and how.
pub(crate) fn options<'a>(
    args: &WorkArgs,
    out: &'a Path,
    stop: &'a AtomicBool,
    progress: &'a (dyn Fn(u64, u64) + Sync),
    tell: &'a (dyn Fn(&str) + Sync),
) -> Options<'a> {
    let (place, jobs) = (place(args), jobs(args));
    Options { out, fresh: args.fresh, place, jobs, confirmed: args.yes, stop, progress, tell }
}

pub(crate) fn place(args: &WorkArgs) -> Place {
    args.connect.clone().map_or(Place::Here, Place::Server)
}

pub(crate) fn jobs(args: &WorkArgs) -> usize {
    let processors = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    args.jobs.map_or_else(processors, usize::from)
}

/// The folder for what comes of it.
pub(crate) fn out(args: &WorkArgs, experiment: &Experiment, ending: &str) -> PathBuf {
    let fits = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let name: String = experiment.name.chars().take(64).map(|c| if fits(c) { c } else { '-' }).collect();
    args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.{ending}")))
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
