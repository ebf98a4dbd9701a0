//! The arguments of `baudbot bench`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Workloads, such as W2 or W3/100; W3 is all of its kind [default: all]
    #[arg(value_name = "WORKLOAD")]
    pub(crate) workloads: Vec<String>,
    /// List the workloads
    #[arg(long)]
    pub(crate) list: bool,
    /// About so many seconds of measurement a repeat
    #[arg(long, value_name = "S", default_value_t = 2.0, allow_negative_numbers = true, value_parser = seconds)]
    pub(crate) seconds: f64,
    /// Repeats, of which the table has the median
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) repeats: u32,
    /// Threads that step a world of W1 to W4
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: u16,
    /// Run each of W1 to W4 for exactly so many ticks and measure nothing: for profilers
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), conflicts_with_all = ["json", "csv"])]
    pub(crate) ticks: Option<u64>,
    /// Write all that was measured as JSON; `-` is stdout, and the table is then left out
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write a line a workload, comma-separated; `-` is stdout, and the table is then left out
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    pub(crate) csv: Option<PathBuf>,
    /// No progress bar, no notes, no table (files are still written)
    #[arg(long)]
    pub(crate) quiet: bool,
    /// What a process of its own is to measure: for `baudbot bench` itself
    #[arg(long, value_name = "TASK", hide = true, exclusive = true)]
    pub(crate) child: Option<String>,
}

fn seconds(text: &str) -> Result<f64, String> {
    let fits = |seconds: &f64| *seconds > 0.0 && *seconds <= MOST_S;
    let found = text.parse().ok().filter(fits);
    found.ok_or_else(|| format!("must be above 0 and at most {MOST_S}, is {text}"))
}

/// A repeat of an hour.
const MOST_S: f64 = 3600.0;
