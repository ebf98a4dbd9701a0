//! `baudbot sweep`: a scenario many times, with some of its fields varied.

use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use anyhow::bail;
use baudbot_experiment::find::{Limit, find};
use baudbot_experiment::{Experiment, Merged, Swept, Told, Workers, merge, table, unique_name};
use baudbot_fields::printable::Printable;
use indicatif::ProgressBar;

use crate::args::{SweepArgs, WorkArgs};
use crate::signals::INTERRUPTED;
use crate::text::tell;
use crate::{shards, text, work};

pub(crate) async fn sweep(args: SweepArgs) -> anyhow::Result<ExitCode> {
    shards::refuse_search(&args)?;
    let experiment = work::read(&args.work)?;
    work::until_stopped(move |stop| match &args.find {
        Some(field) => look(&experiment, &args.work, field, stop),
        None => run(&experiment, &args, stop),
    })
    .await
}

fn run(experiment: &Experiment, args: &SweepArgs, stop: &AtomicBool) -> anyhow::Result<ExitCode> {
    let out = match args.shard {
        Some(shard) => shards::folder(args, experiment, shard),
        None => work::out(&args.work, experiment, "sweep"),
    };
    let bar = work::progress(args.work.quiet);
    let progress = |done, total| work::advance(&bar, done, total);
    let tell = |told: &Told| work::tell(&bar, args.work.quiet, told);
    let options = work::options(&args.work, &out, args.shard, stop, &progress, &tell);
    let merged = match args.merge.as_slice() {
        [] => baudbot_experiment::sweep(experiment, &options).map(Merged::Whole),
        sources => merge(experiment, sources, &options),
    };
    bar.finish_and_clear();
    match merged.map_err(|error| work::from_experiment(&args.work, error))? {
        Merged::Missing(missing) => shards::tell_missing(experiment, args, &missing),
        Merged::Whole(swept) => report(experiment, args, &out, &swept),
    }
}

/// Reports the result, and gives the exit code.
fn report(experiment: &Experiment, args: &SweepArgs, out: &Path, swept: &Swept) -> anyhow::Result<ExitCode> {
    if swept.interrupted {
        tell!(
            "stopped after {} of {} runs, recorded in {}; the same command continues from there",
            swept.done,
            swept.total,
            out.join("rows.jsonl").display()
        );
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if let Some(shard) = args.shard {
        return shards::show(args, shard, out, swept);
    }
    show(experiment, &args.work, swept)?;
    let failed = swept.summary.failed;
    match swept.summary.failures.first() {
        // Without these options the table has the error.
        Some((run, error)) if args.work.quiet || args.work.json => {
            bail!("{failed} of {} runs failed; the first, run {run}: {error}", swept.total)
        }
        Some(_) => Ok(ExitCode::FAILURE),
        None => Ok(ExitCode::SUCCESS),
    }
}

/// `--find`: each limit is reported as soon as it is found.
fn look(
    experiment: &Experiment,
    args: &WorkArgs,
    field: &str,
    stop: &AtomicBool,
) -> anyhow::Result<ExitCode> {
    let workers =
        Workers::new(work::place(args), work::jobs(args), unique_name("find"), work::brain_timeout(args));
    let quiet = args.quiet || args.json || !std::io::stderr().is_terminal();
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    let told = |value: &str| {
        bar.set_message(format!("{field} = {}: {} seeds", Printable(value), experiment.seeds.count()));
    };
    let found = find(experiment, field, &workers, args.yes, stop, &told);
    bar.finish_and_clear();
    let Some(limits) = found.map_err(|error| work::from_experiment(args, error))? else {
        tell!("stopped before a limit was found");
        return Ok(ExitCode::from(INTERRUPTED));
    };
    if args.json {
        let json = serde_json::json!({ "field": field, "limits": limits.iter().map(Limit::json).collect::<Vec<_>>() });
        text::print_json(&json)?;
    } else if !args.quiet {
        let limits: String = limits.iter().map(|limit| limit.text(experiment, field)).collect();
        text::print(&limits)?;
    }
    Ok(if limits.iter().all(|limit| limit.limit.is_some()) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The report at the end, for people or for programs.
fn show(experiment: &Experiment, args: &WorkArgs, swept: &Swept) -> anyhow::Result<()> {
    if args.json {
        text::print_json(&swept.summary.json(experiment))?;
    } else if !args.quiet {
        text::print(&table::text(experiment, &swept.summary, MOST_CELLS))?;
        for file in &swept.files {
            tell!("wrote {}", file.display());
        }
    }
    Ok(())
}

/// Combinations that are printed to a terminal; the file has all of them.
const MOST_CELLS: usize = 60;
