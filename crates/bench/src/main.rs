//! The program `baudbot-bench`: how fast worlds and the path to their brains are.

mod args;
mod count;
mod files;
mod page;
mod pairs;
mod table;

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::Context;
use baudbot_bench::catalogue::{self, Workload};
use baudbot_bench::measure::Effort;
use baudbot_bench::outcome::Outcome;
use baudbot_bench::{Means, worker};
use clap::Parser;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::args::{Action, Args};

/// The arguments name what cannot be measured. Exit code 2, as for options that do not exist.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Refused(String);

fn main() -> ExitCode {
    match bench(&Args::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(if error.is::<Refused>() { 2 } else { 1 })
        }
    }
}

fn bench(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(task) = &args.child {
        return Ok(worker::serve(task, child_command()?));
    }
    if let Some(Action::Beside(beside)) = &args.action {
        return pairs::run(args, beside);
    }
    let chosen = catalogue::select(&args.workloads).map_err(|error| Refused(error.to_string()))?;
    if args.list {
        print(&table::list(&chosen))?;
        return Ok(ExitCode::SUCCESS);
    }
    if args.instructions {
        return count::run(args, &chosen);
    }
    if let Some(ticks) = args.ticks {
        run_ticks(&chosen, ticks, args)?;
        return Ok(ExitCode::SUCCESS);
    }
    if cfg!(debug_assertions) {
        eprintln!("warning: {DEBUG_BUILD}");
    }
    let (measured, failed) = measure(args, &chosen)?;
    if let Some(path) = &args.json {
        write(path, &files::json(&measured)?)?;
    }
    if let Some(path) = args.page.as_ref().filter(|_| failed == 0) {
        page::write(path, &measured)?;
    }
    if !args.quiet && args.json.as_deref() != Some(Path::new("-")) {
        print(&table::text(&measured))?;
    }
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// `--ticks`.
fn run_ticks(chosen: &[&Workload], ticks: u64, args: &Args) -> anyhow::Result<()> {
    for workload in chosen {
        let hash = workload.run_ticks(ticks, args.threads.into());
        let hash = hash.map_err(|error| Refused(error.to_string()))?;
        if !args.quiet {
            print(&format!("{}  {hash:016x} after {ticks} ticks\n", workload.name))?;
        }
    }
    Ok(())
}

/// The measurements of all workloads, and the number of those that could not be measured.
fn measure(
    args: &Args,
    chosen: &[&'static Workload],
) -> anyhow::Result<(Vec<(&'static Workload, Outcome)>, usize)> {
    let effort = Effort { seconds: args.seconds, repeats: args.repeats };
    let bar = progress(args.quiet, chosen.len() as u64 * u64::from(args.repeats));
    let means = Means { threads: args.threads.into(), program: program(args)? };
    let (mut measured, mut failed) = (Vec::new(), 0);
    for (i, &workload) in chosen.iter().enumerate() {
        let before = i as u64 * u64::from(args.repeats);
        bar.set_message(format!("{}: warm-up", workload.name));
        bar.set_position(before);
        let outcome = worker::measure(child_command()?, workload, effort, means.clone(), |repeat| {
            bar.set_message(format!("{}: repeat {repeat} of {}", workload.name, args.repeats));
            bar.set_position(before + u64::from(repeat) - 1);
        });
        match outcome {
            Ok(outcome) => measured.push((workload, outcome)),
            Err(error) => {
                failed += 1;
                bar.suspend(|| eprintln!("error: {}: {:#}", workload.name, anyhow::Error::from(error)));
            }
        }
    }
    bar.finish_and_clear();
    Ok((measured, failed))
}

/// The program that R runs.
fn program(args: &Args) -> anyhow::Result<PathBuf> {
    let beside = || Ok::<_, anyhow::Error>(this_program()?.with_file_name("baudbot"));
    args.program.clone().map_or_else(beside, Ok)
}

fn this_program() -> anyhow::Result<PathBuf> {
    std::env::current_exe().context("cannot find this program")
}

/// Begins a process for the task in its last argument.
fn child_command() -> anyhow::Result<Command> {
    let mut command = Command::new(this_program()?);
    command.arg("--child");
    Ok(command)
}

/// Writes to stdout; a reader that is gone is an error, no panic.
fn print(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to stdout")
}

/// Writes to a file, or to stdout for `-`.
fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    if path == Path::new("-") {
        return print(text);
    }
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn progress(quiet: bool, repeats: u64) -> ProgressBar {
    if quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(repeats), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:40} {msg}, {eta} to go");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

const DEBUG_BUILD: &str =
    "this is a debug build: its figures mean nothing; build with `cargo build --release` to measure";
