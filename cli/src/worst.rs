//! `baudbot worst`: the run in which the robot fails, or comes nearest to it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use anyhow::Context;
use baudbot_experiment::worst::Case;
use baudbot_experiment::{Experiment, Limit, Told, Worst};
use clap::Parser;

use crate::args::{Cli, Command, WorstArgs};
use crate::signals::INTERRUPTED;
use crate::text::tell;
use crate::{diagram, run, shards, text, work};

/// What a search leaves to be done once it is over.
#[derive(Default)]
struct Remainder {
    case: Option<Case>,
    out: PathBuf,
}

pub(crate) async fn worst(args: WorstArgs) -> anyhow::Result<ExitCode> {
    let experiment = work::read(&args.work)?;
    let found = std::sync::Arc::new(Mutex::new(Remainder::default()));
    let told = std::sync::Arc::clone(&found);
    let quiet = args.work.quiet || args.work.json;
    let code = work::until_stopped(move |stop| search(&experiment, &args, stop, &told)).await?;
    let found = std::mem::take(&mut *found.lock().unwrap_or_else(PoisonError::into_inner));
    if let Some(case) = &found.case {
        let Pictures { recording, diagram } = picture(case, &found.out).await?;
        if !quiet {
            for file in [found.out.join(CASE), recording, diagram] {
                tell!("wrote {}", file.display());
            }
            tell!("{}", case.command(&found.out.join(CASE)));
        }
    }
    Ok(code)
}

fn search(
    experiment: &Experiment,
    args: &WorstArgs,
    stop: &AtomicBool,
    found: &Mutex<Remainder>,
) -> anyhow::Result<ExitCode> {
    let limit = Limit { runs: args.runs, within: args.within, first: args.first };
    let out = match (args.shard, &args.work.out) {
        (Some(shard), None) => shards::default_folder(experiment, shard),
        (Some(_) | None, _) => work::out(&args.work, experiment, "worst"),
    };
    let bar = work::progress(args.work.quiet);
    let progress = |done, total| work::advance(&bar, done, total);
    let tell = |told: &Told| work::tell(&bar, args.work.quiet, told);
    let options = work::options(&args.work, &out, args.shard, stop, &progress, &tell);
    let worst = match args.merge.as_slice() {
        [] => baudbot_experiment::worst(experiment, &options, limit),
        sources => baudbot_experiment::merge_worst(experiment, sources, &options, limit),
    };
    bar.finish_and_clear();
    let worst = worst.map_err(|error| work::from_experiment(&args.work, error))?;
    if worst.interrupted {
        let journal = out.join("rows.jsonl");
        tell!(
            "stopped after {} runs, recorded in {}; the same command continues from there",
            worst.runs,
            journal.display()
        );
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if let Some(shard) = args.shard {
        let (runs, journal) = (worst.runs, out.join("rows.jsonl"));
        tell!("shard {shard}: all of its {runs} runs are recorded in {}", journal.display());
        return Ok(ExitCode::SUCCESS);
    }
    show(experiment, args, &worst)?;
    // As in a sweep, runs that could not be done are no success.
    let is_good = !worst.has_fallen() && worst.failed == 0;
    let code = if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
    *found = Remainder { case: worst.case, out };
    Ok(code)
}

/// The report at the end, for people or for programs.
fn show(experiment: &Experiment, args: &WorstArgs, worst: &Worst) -> anyhow::Result<()> {
    if args.work.json {
        return text::print_json(&worst.json(experiment));
    }
    if args.work.quiet {
        return Ok(());
    }
    text::print(&worst.text(experiment))?;
    if let (Some(within), None, false) = (args.within, args.runs, args.first) {
        let (runs, within_s) = (worst.runs, within.as_secs_f64());
        tell!("{runs} runs were done within {within_s} s; --runs {runs} does the same ones");
    }
    Ok(())
}

/// Files that show what happened in a case.
struct Pictures {
    recording: PathBuf,
    diagram: PathBuf,
}

/// Records the case, and draws its timing at the instant that decides, as the commands for that do.
async fn picture(case: &Case, out: &Path) -> anyhow::Result<Pictures> {
    let before = std::env::current_dir()?;
    let pictures = Pictures { recording: out.join("worst.mcap"), diagram: out.join("worst.svg") };
    for file in [&pictures.recording, &pictures.diagram] {
        match std::fs::remove_file(file) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error.into()),
            _ => {}
        }
    }
    // Programs are found from the experiment's folder.
    let [scenario, recording, diagram] = [&out.join(CASE), &pictures.recording, &pictures.diagram]
        .map(|path| before.join(path).display().to_string());
    std::env::set_current_dir(case.folder.as_ref().unwrap_or(&before))?;
    let drawn = draw(case, &scenario, &recording, &diagram).await;
    std::env::set_current_dir(before)?;
    drawn.map(|()| pictures)
}

async fn draw(case: &Case, scenario: &str, recording: &str, picture: &str) -> anyhow::Result<()> {
    if let Command::Run(args) = command(case, &["run", scenario, "--quiet", "--record", recording])? {
        run::run(&args).await?;
    }
    let (at_s, span_ms) = ((case.fall.at_s() - BEFORE_S).max(0.0).to_string(), SPAN_MS.to_string());
    let diagram = ["diagram", scenario, "--robot", &case.robot];
    let window = ["--at", &at_s, "--span", &span_ms, "--svg", picture];
    if let Command::Diagram(args) = command(case, &[&diagram[..], &window].concat())? {
        diagram::diagram(args).await?;
    }
    Ok(())
}

/// A command with the brains of a case.
fn command(case: &Case, words: &[&str]) -> anyhow::Result<Command> {
    let brains = case.brains.iter().flat_map(|brain| ["--brain", brain]);
    let parameters = case.parameters.iter().flat_map(|text| ["--parameter", text]);
    let words = ["baudbot"].into_iter().chain(words.iter().copied());
    let parsed = Cli::try_parse_from(words.chain(brains).chain(parameters))?;
    parsed.command.context("it has a command")
}

/// The scenario of the worst run.
const CASE: &str = "worst.toml";

/// The diagram begins so long before the instant that decides,
const BEFORE_S: f64 = 0.15;

/// and shows as much, and a little more.
const SPAN_MS: f64 = 200.0;
