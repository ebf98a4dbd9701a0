//! `baudbot sweep --shard` and `--merge`: an experiment on many machines.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use baudbot_experiment::{Experiment, Missing, MissingShard, Shard, Swept};
use baudbot_fields::printable::Printable;

use crate::args::SweepArgs;
use crate::error::Refused;
use crate::text::tell;
use crate::{text, work};

/// A search has neither shards nor journals.
pub(crate) fn refuse_search(args: &SweepArgs) -> anyhow::Result<()> {
    let option = match (&args.find, args.shard, args.merge.is_empty()) {
        (None, _, _) | (_, None, true) => return Ok(()),
        (Some(_), Some(_), _) => "--shard",
        (Some(_), None, false) => "--merge",
    };
    Err(Refused::error(format!(
        "{option}: --find has no shards, as each value that it tries depends on the results of those before; --jobs and \
         --connect share its work, or sweep the whole field in shards"
    )))
}

/// The folder for the journal of a shard.
pub(crate) fn folder(args: &SweepArgs, experiment: &Experiment, shard: Shard) -> PathBuf {
    args.work.out.clone().unwrap_or_else(|| default_folder(experiment, shard))
}

pub(crate) fn default_folder(experiment: &Experiment, shard: Shard) -> PathBuf {
    work::default_out(experiment, "shards").join(shard.folder())
}

/// The report at the end of a shard, and the exit code. Runs that failed are results: the merge reports them, and the
/// same command does them again.
pub(crate) fn show(args: &SweepArgs, shard: Shard, out: &Path, swept: &Swept) -> anyhow::Result<ExitCode> {
    let journal = out.join("rows.jsonl");
    if args.work.json {
        let failures = swept.summary.failures.iter();
        text::print_json(&serde_json::json!({
            "shard": shard.to_string(),
            "runs": swept.total,
            "failed": swept.summary.failed,
            "failures": failures.map(|(run, error)| serde_json::json!({ "run": run, "error": error })).collect::<Vec<_>>(),
            "journal": journal,
        }))?;
    } else if !args.work.quiet {
        let failed = match swept.summary.failed {
            0 => String::new(),
            failed => format!(", {failed} of them failed"),
        };
        tell!("shard {shard}: all of its {} runs are recorded in {}{failed}", swept.total, journal.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// Reports the missing shards, and the commands that run them.
pub(crate) fn tell_missing(
    experiment: &Experiment,
    args: &SweepArgs,
    missing: &Missing,
) -> anyhow::Result<ExitCode> {
    tell!(
        "error: {} of {} runs are missing, so nothing was written; these commands do them:",
        missing.runs,
        missing.total
    );
    for shard in missing.shards.iter().take(MOST_COMMANDS) {
        tell!("{}  # {}", command(experiment, args, shard)?, what(shard));
    }
    let others = missing.shards.len().saturating_sub(MOST_COMMANDS);
    if others > 0 {
        tell!("… and {others} more");
    }
    Ok(ExitCode::FAILURE)
}

/// The effect of a command.
fn what(missing: &MissingShard) -> String {
    let runs: Vec<_> = missing.first.iter().map(u64::to_string).collect();
    let more = if missing.runs > runs.len() as u64 { ", …" } else { "" };
    format!("{} missing: {}{more}", missing.runs, runs.join(", "))
}

fn command(experiment: &Experiment, args: &SweepArgs, missing: &MissingShard) -> anyhow::Result<String> {
    let path = args.work.experiment.display().to_string();
    let mut words = vec!["baudbot".to_owned(), "sweep".to_owned(), path];
    if let Some(seeds) = &args.work.seeds {
        words.extend(["--seeds".to_owned(), seeds.clone()]);
    }
    words.extend(missing.shard.into_iter().flat_map(|shard| ["--shard".to_owned(), shard.to_string()]));
    let default = missing.shard.map(|shard| default_folder(experiment, shard));
    if let Some(folder) = missing.folder.as_ref().filter(|folder| default.as_ref() != Some(folder)) {
        words.extend(["--out".to_owned(), folder.display().to_string()]);
    }
    let words = words.iter().map(|word| Printable(word).to_string()).collect::<Vec<_>>();
    shlex::try_join(words.iter().map(String::as_str)).context("a path has a byte that no shell takes")
}

/// Commands that are shown.
const MOST_COMMANDS: usize = 20;
