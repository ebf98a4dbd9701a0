//! The means with which an experiment's runs are done.

use std::path::PathBuf;
use std::time::Duration;

use baudbot_experiment::{BRAIN_TIMEOUT, Shard};
use clap::Args;

use super::value::{patience, wall_time, whole};

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Search for the limit of a field, given by its label or path, at which the brain still succeeds
    #[arg(long, value_name = "FIELD", conflicts_with_all = ["out", "fresh"])]
    pub(crate) find: Option<String>,
    /// Run only shard I of N, counted from 0, and write only its journal (rows.jsonl)
    ///
    /// Each of N machines runs one shard, in any order; --merge then writes the outputs. In Kubernetes I/N is
    /// "$(JOB_COMPLETION_INDEX)/8", in a shell "$JOB_COMPLETION_INDEX/8". The default folder is NAME.shards/I-of-N.
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Write the outputs from the journals of all shards, or report the missing runs and the commands that do them
    ///
    /// Each DIR is the folder of a shard, a folder of such folders, or a journal itself. Journals are not modified.
    #[arg(
        long, value_name = "DIR", num_args = 1..,
        conflicts_with_all = ["shard", "jobs", "connect", "yes"],
    )]
    pub(crate) merge: Vec<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct TuneArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Refused, with the reason
    #[arg(long, value_name = "I/N", hide = true)]
    pub(crate) shard: Option<Shard>,
}

#[derive(Debug, Args)]
pub(crate) struct WorstArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Number of runs; the same number gives the same runs on any machine [default: 1000, or as many as --within allows]
    #[arg(long, value_name = "N", value_parser = whole(1_u64..=10_000_000))]
    pub(crate) runs: Option<u64>,
    /// Begin no more runs after this wall-clock time, such as 90s, 5m or 1h
    ///
    /// Once a run has failed half of it is for the search, and half for leaving out of that run whatever does not matter.
    #[arg(long, value_name = "TIME", value_parser = wall_time)]
    pub(crate) within: Option<Duration>,
    /// End the search as soon as a run fails
    #[arg(long)]
    pub(crate) first: bool,
    /// Do only shard I of N of the runs, counted from 0 (method `random`), and write only its journal
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Write the results from the journals of all shards
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with_all = ["shard", "connect"])]
    pub(crate) merge: Vec<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct WorkArgs {
    /// An experiment file (docs/reference/experiments.md)
    pub(crate) experiment: PathBuf,
    /// The folder for the results [default: NAME.sweep in the current folder; NAME.tune for a tuning run; NAME.worst for a search; NAME.shards/I-of-N for a shard]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Delete the results of an earlier experiment in that folder, and start over
    #[arg(long)]
    pub(crate) fresh: bool,
    /// Number of parallel runs [default: the number of processors]
    #[arg(long, value_name = "N", value_parser = whole(1_u16..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Run on a server instead of in this process: HOST:PORT or unix:/PATH
    #[arg(long, value_name = "ADDR")]
    pub(crate) connect: Option<String>,
    /// Give up a run in which a brain that is a program does not answer within this wall-clock time
    #[arg(long, value_name = "S", value_parser = patience, default_value_t = BRAIN_TIMEOUT.as_secs_f64())]
    pub(crate) brain_timeout: f64,
    /// Seeds in place of the file's: N (1 to N), A..B (inclusive) or A,B,C
    #[arg(long, value_name = "SEEDS")]
    pub(crate) seeds: Option<String>,
    /// Confirm a long experiment: more than 10,000 runs, or more than an hour
    #[arg(long)]
    pub(crate) yes: bool,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Suppress the progress bar, notes and the summary (JSON is still written)
    #[arg(long)]
    pub(crate) quiet: bool,
}
