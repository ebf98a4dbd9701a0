//! `baudbot tune`: the numbers with which an experiment's runs are best.

use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use anyhow::bail;
use baudbot_experiment::{Experiment, Told, Tuned};

use crate::args::{TuneArgs, WorkArgs};
use crate::signals::INTERRUPTED;
use crate::text::tell;
use crate::{text, work};

pub(crate) async fn tune(args: TuneArgs) -> anyhow::Result<ExitCode> {
    let experiment = work::read(&args.work)?;
    work::until_stopped(move |stop| run(&experiment, &args, stop)).await
}

fn run(experiment: &Experiment, args: &TuneArgs, stop: &AtomicBool) -> anyhow::Result<ExitCode> {
    let (shard, args) = (args.shard, &args.work);
    let out = work::out(args, experiment, "tune");
    let bar = work::progress(args.quiet);
    let progress = |done, total| work::advance(&bar, done, total);
    let tell = |told: &Told| work::tell(&bar, args.quiet, told);
    let tuned =
        baudbot_experiment::tune(experiment, &work::options(args, &out, shard, stop, &progress, &tell));
    bar.finish_and_clear();
    let tuned = tuned.map_err(|error| work::from_experiment(args, error))?;
    if tuned.interrupted {
        let journal = out.join("rows.jsonl");
        let candidates = tuned.candidates.len();
        let journal = journal.display();
        tell!(
            "stopped after {candidates} candidates, recorded in {journal}; the same command continues from there"
        );
        return Ok(ExitCode::from(INTERRUPTED));
    }
    show(experiment, args, &tuned)?;
    match tuned.best() {
        Some(_) => Ok(ExitCode::SUCCESS),
        // Without these options the text has it.
        None if args.quiet || args.json => bail!("no candidate has a score"),
        None => Ok(ExitCode::FAILURE),
    }
}

/// The report at the end, for people or for programs.
fn show(experiment: &Experiment, args: &WorkArgs, tuned: &Tuned) -> anyhow::Result<()> {
    if args.json {
        text::print_json(&tuned.json(experiment))?;
    } else if !args.quiet {
        text::print(&tuned.text(experiment))?;
        for file in &tuned.files {
            tell!("wrote {}", file.display());
        }
    }
    Ok(())
}
