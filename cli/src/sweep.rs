//! `baudbot sweep`: a scenario many times, with some of its fields varied.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use baudbot_experiment::find::{Limit, find};
use baudbot_experiment::{Error, Experiment, Options, Place, Seeds, Swept, Workers, table, unique_name};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::args::SweepArgs;
use crate::error::Refused;
use crate::scenarios::{self, Source};
use crate::signals::{INTERRUPTED, Stop};
use crate::text;

pub(crate) async fn sweep(args: SweepArgs) -> anyhow::Result<ExitCode> {
    let experiment = read(&args)?;
    let mut listening = Stop::listen().context("cannot listen for Ctrl-C")?;
    let stop = Arc::new(AtomicBool::new(false));
    let told = Arc::clone(&stop);
    // The runs are on threads of their own; this one waits for a signal meanwhile.
    let mut work = tokio::task::spawn_blocking(move || match &args.find {
        Some(field) => look(&experiment, &args, field, &told),
        None => run(&experiment, &args, &told),
    });
    tokio::select! {
        done = &mut work => return done.context("the sweep panicked")?,
        () = listening.wait() => stop.store(true, Ordering::Relaxed),
    }
    work.await.context("the sweep panicked")?
}

/// The experiment that the arguments name.
fn read(args: &SweepArgs) -> anyhow::Result<Experiment> {
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
    if let Some(seeds) = &args.seeds {
        experiment.seeds = Seeds::parse(seeds).map_err(|error| Refused::error(format!("--{error}")))?;
    }
    Ok(experiment)
}

fn run(experiment: &Experiment, args: &SweepArgs, stop: &AtomicBool) -> anyhow::Result<ExitCode> {
    let out = args.out.clone().unwrap_or_else(|| default_out(experiment));
    let bar = progress(args.quiet);
    let options = Options {
        out: &out,
        fresh: args.fresh,
        place: place(args),
        jobs: jobs(args),
        confirmed: args.yes,
        stop,
        progress: &|done, total| {
            bar.set_length(total);
            bar.set_position(done);
        },
    };
    let swept = baudbot_experiment::sweep(experiment, &options);
    bar.finish_and_clear();
    let swept = swept.map_err(|error| from_experiment(args, error))?;
    if swept.interrupted {
        eprintln!(
            "stopped after {} of {} runs, which {} has; the same command goes on from there",
            swept.done,
            swept.total,
            out.join("rows.jsonl").display()
        );
        return Ok(ExitCode::from(INTERRUPTED));
    }
    show(experiment, args, &swept)?;
    Ok(if swept.summary.failed > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// `--find`: each limit is told as it is found.
fn look(
    experiment: &Experiment,
    args: &SweepArgs,
    field: &str,
    stop: &AtomicBool,
) -> anyhow::Result<ExitCode> {
    let workers = Workers { place: place(args), jobs: jobs(args), name: unique_name("find") };
    let quiet = args.quiet || args.json || !std::io::stderr().is_terminal();
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    let told =
        |value: &str| bar.set_message(format!("{field} = {value}: {} seeds", experiment.seeds.count()));
    let found = find(experiment, field, &workers, args.yes, stop, &told);
    bar.finish_and_clear();
    let Some(limits) = found.map_err(|error| from_experiment(args, error))? else {
        eprintln!("stopped before a limit was found");
        return Ok(ExitCode::from(INTERRUPTED));
    };
    if args.json {
        let json = serde_json::json!({ "field": field, "limits": limits.iter().map(Limit::json).collect::<Vec<_>>() });
        text::print(&format!(
            "{}\n",
            serde_json::to_string_pretty(&json).context("cannot write the limits")?
        ))?;
    } else if !args.quiet {
        let limits: String = limits.iter().map(|limit| limit.text(experiment, field)).collect();
        text::print(&limits)?;
    }
    Ok(if limits.iter().all(|limit| limit.limit.is_some()) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn place(args: &SweepArgs) -> Place {
    args.connect.clone().map_or(Place::Here, Place::Server)
}

/// What a person or a program is told at the end.
fn show(experiment: &Experiment, args: &SweepArgs, swept: &Swept) -> anyhow::Result<()> {
    if args.json {
        let json = serde_json::to_string_pretty(&swept.summary.json(experiment));
        text::print(&format!("{}\n", json.context("cannot write the summary")?))?;
    } else if !args.quiet {
        text::print(&table::text(experiment, &swept.summary, MOST_CELLS))?;
        for file in &swept.files {
            eprintln!("wrote {}", file.display());
        }
    }
    Ok(())
}

/// Errors of the file begin with its name.
fn from_experiment(args: &SweepArgs, error: Error) -> anyhow::Error {
    match &error {
        Error::Field { .. } | Error::Syntax(_) => {
            Refused::error(format!("{}: {error}", args.experiment.display()))
        }
        error if error.is_refusal() => Refused::error(error.to_string()),
        _ => error.into(),
    }
}

fn default_out(experiment: &Experiment) -> PathBuf {
    let fits = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let name: String = experiment.name.chars().take(64).map(|c| if fits(c) { c } else { '-' }).collect();
    PathBuf::from(format!("{name}.sweep"))
}

fn jobs(args: &SweepArgs) -> usize {
    let processors = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    args.jobs.map_or_else(processors, usize::from)
}

fn progress(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} runs, {eta} to go");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Combinations that are told on a screen; the file has them all.
const MOST_CELLS: usize = 60;
