//! `baudbot bench`: how fast worlds and the path to their brains are.

mod files;
mod table;

use std::io::IsTerminal;
use std::process::{Command, ExitCode};

use anyhow::Context;
use baudbot_bench::catalogue::{self, Workload};
use baudbot_bench::child;
use baudbot_bench::measure::Effort;
use baudbot_bench::outcome::Outcome;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::args::BenchArgs;
use crate::error::{self, Refused};
use crate::text;
use crate::text::tell;

pub(crate) fn bench(args: &BenchArgs) -> anyhow::Result<ExitCode> {
    if let Some(task) = &args.child {
        return Ok(child::serve(task, child_command()?));
    }
    let chosen = catalogue::select(&args.workloads).map_err(|error| Refused::error(error.to_string()))?;
    if args.list {
        text::print(&table::list(&chosen))?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(ticks) = args.ticks {
        run_ticks(&chosen, ticks, args)?;
        return Ok(ExitCode::SUCCESS);
    }
    if cfg!(debug_assertions) {
        tell!("warning: {DEBUG_BUILD}");
    }
    let (measured, failed) = measure(args, &chosen)?;
    let file = args.json.as_ref().or(args.csv.as_ref());
    if let Some(path) = file {
        let content = if args.json.is_some() { files::json(&measured)? } else { files::csv(&measured)? };
        text::write(path, &content)?;
    }
    if !args.quiet && file.is_none_or(|path| path.as_os_str() != "-") {
        text::print(&table::text(&measured))?;
    }
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// `--ticks`.
fn run_ticks(chosen: &[&Workload], ticks: u64, args: &BenchArgs) -> anyhow::Result<()> {
    for workload in chosen {
        let hash = workload.run_ticks(ticks, args.threads.into());
        let hash = hash.map_err(|error| Refused::error(error.to_string()))?;
        if !args.quiet {
            text::print(&format!("{}  {hash:016x} after {ticks} ticks\n", workload.name))?;
        }
    }
    Ok(())
}

/// What was measured of each, and how many could not be.
fn measure(
    args: &BenchArgs,
    chosen: &[&'static Workload],
) -> anyhow::Result<(Vec<(&'static Workload, Outcome)>, usize)> {
    let effort = Effort { seconds: args.seconds, repeats: args.repeats };
    let bar = progress(args.quiet, chosen.len() as u64 * u64::from(args.repeats));
    let (mut measured, mut failed) = (Vec::new(), 0);
    for (i, &workload) in chosen.iter().enumerate() {
        let before = i as u64 * u64::from(args.repeats);
        bar.set_message(format!("{}: warm-up", workload.name));
        bar.set_position(before);
        let outcome = child::measure(child_command()?, workload, effort, args.threads.into(), |repeat| {
            bar.set_message(format!("{}: repeat {repeat} of {}", workload.name, args.repeats));
            bar.set_position(before + u64::from(repeat) - 1);
        });
        match outcome {
            Ok(outcome) => measured.push((workload, outcome)),
            Err(error) => {
                failed += 1;
                bar.suspend(|| tell!("error: {}: {}", workload.name, error::text(&error.into())));
            }
        }
    }
    bar.finish_and_clear();
    Ok((measured, failed))
}

/// Begins a process that does what its last argument says.
fn child_command() -> anyhow::Result<Command> {
    let mut command = Command::new(std::env::current_exe().context("cannot find this program")?);
    command.args(["bench", "--child"]);
    Ok(command)
}

fn progress(quiet: bool, repeats: u64) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(repeats), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:40} {msg}, {eta} to go");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

const DEBUG_BUILD: &str =
    "this is a debug build: its figures mean nothing; build with `cargo build --release` to measure";
