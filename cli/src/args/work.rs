//! What an experiment's runs are done with.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Look for the limit of a field, by its label or path, at which the brain still succeeds
    #[arg(long, value_name = "FIELD", conflicts_with_all = ["out", "fresh"])]
    pub(crate) find: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct TuneArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
}

#[derive(Debug, Args)]
pub(crate) struct WorkArgs {
    /// An experiment file; docs/experiments.md describes them
    pub(crate) experiment: PathBuf,
    /// The folder for what comes of it [default: NAME.sweep here; of a tuning NAME.tune]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Delete what is in that folder of another experiment, and begin anew
    #[arg(long)]
    pub(crate) fresh: bool,
    /// Runs at a time [default: as many as there are processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Run on a server instead of in this process: HOST:PORT or unix:/PATH
    #[arg(long, value_name = "ADDR")]
    pub(crate) connect: Option<String>,
    /// Other seeds than the file's: N (1 to N), A..B (both too) or A,B,C
    #[arg(long, value_name = "SEEDS")]
    pub(crate) seeds: Option<String>,
    /// Go ahead even if it takes long: more than 10,000 runs, or an hour
    #[arg(long)]
    pub(crate) yes: bool,
    /// Write what is told at the end as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// No progress bar, no notes, no summary (JSON is still written)
    #[arg(long)]
    pub(crate) quiet: bool,
}
