//! An experiment's file and what its runs are done with, for `sweep` and `tune`; runs on threads, for `grade`, too.

use std::fmt;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Context;
use baudbot_experiment::{Error, Experiment, Options, Place, Seeds, Shard, Told};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::args::WorkArgs;
use crate::error::Refused;
use crate::signals::Stop;
use crate::text::tell;

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

/// The options of the place and the means.
pub(crate) fn options<'a>(
    args: &WorkArgs,
    out: &'a Path,
    shard: Option<Shard>,
    stop: &'a AtomicBool,
    progress: &'a (dyn Fn(u64, u64) + Sync),
    tell: &'a (dyn Fn(&Told) + Sync),
) -> Options<'a> {
    let (place, jobs, brain_timeout) = (place(args), jobs(args), brain_timeout(args));
    Options {
        out,
        fresh: args.fresh,
        shard,
        place,
        jobs,
        brain_timeout,
        confirmed: args.yes,
        stop,
        progress,
        tell,
    }
}

pub(crate) fn brain_timeout(args: &WorkArgs) -> Duration {
    Duration::from_secs_f64(args.brain_timeout)
}

pub(crate) fn place(args: &WorkArgs) -> Place {
    args.connect.clone().map_or(Place::Here, Place::Server)
}

pub(crate) fn jobs(args: &WorkArgs) -> usize {
    jobs_of(args.jobs)
}

/// The number of processors, unless the arguments have one.
pub(crate) fn jobs_of(jobs: Option<u16>) -> usize {
    let processors = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    jobs.map_or_else(processors, usize::from)
}

/// The folder for the results.
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

/// A bar on stderr, if that is a terminal.
pub(crate) fn progress(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    bar.with_style(style())
}

/// Writes a line above the bar; no notes if all is to be quiet.
pub(crate) fn tell(bar: &ProgressBar, quiet: bool, told: &Told) {
    match told {
        Told::Note(_) if quiet => {}
        Told::Note(_) | Told::Warning(_) => bar.suspend(|| tell!("{told}")),
    }
}

/// Shows how many runs of how many are done. Those of an earlier command are no measure of the time that is needed.
pub(crate) fn advance(bar: &ProgressBar, done: u64, total: u64) {
    let is_first = bar.length().is_none();
    bar.set_length(total);
    bar.set_position(done);
    if is_first {
        bar.reset_eta();
    }
}

fn style() -> ProgressStyle {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs{to_go}");
    style.unwrap_or_else(|_| ProgressStyle::default_bar()).with_key("to_go", to_go)
}

fn to_go(state: &ProgressState, out: &mut dyn fmt::Write) {
    // A bar that cannot be drawn is left out.
    let _ = out.write_str(&left(state.eta()));
}

/// The time that is still needed, once a run has shown it.
fn left(time: Duration) -> String {
    if time.is_zero() { String::new() } else { format!(", {:#} to go", HumanDuration(time)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_names_no_time_until_a_run_has_shown_it() {
        let bar = ProgressBar::hidden();
        advance(&bar, 400, 803);
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(left(bar.eta()), "", "runs of an earlier command took no time");
        advance(&bar, 401, 803);
        assert!(left(bar.eta()).ends_with("s to go"), "{:?}", bar.eta());
    }
}
