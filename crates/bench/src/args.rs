//! The arguments of `baudbot-bench`.

use std::path::PathBuf;

use clap::{Parser, Subcommand};

/// Measures how fast worlds and the path to their brains are
#[derive(Debug, Parser)]
#[command(name = "baudbot-bench", version, after_long_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) action: Option<Action>,
    /// Workloads, such as W2 or W3/100; W3 is all of its kind [default: all]
    #[arg(value_name = "WORKLOAD")]
    pub(crate) workloads: Vec<String>,
    /// List the workloads
    #[arg(long)]
    pub(crate) list: bool,
    /// About this many seconds of measurement per repeat
    #[arg(long, global = true, value_name = "S", default_value_t = 2.0, allow_negative_numbers = true, value_parser = seconds)]
    pub(crate) seconds: f64,
    /// Repeats; the table has their median
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) repeats: u32,
    /// Threads that step a world of W1 to W4 and G
    #[arg(long, global = true, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: u16,
    /// The program `baudbot` that R runs [default: the one beside this program]
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) program: Option<PathBuf>,
    /// Run each of W1 to W4, G and V for exactly this many ticks and measure nothing: for profilers
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), conflicts_with = "json")]
    pub(crate) ticks: Option<u64>,
    /// Count instructions with valgrind instead of measuring time
    #[arg(long, conflicts_with = "ticks")]
    pub(crate) instructions: bool,
    /// Compare the counts with the known ones; one that is higher by more than 2 % is a failure
    #[arg(long, value_name = "FILE.toml", requires = "instructions")]
    pub(crate) check: Option<PathBuf>,
    /// Write the counts as the known ones from now on
    #[arg(long, value_name = "FILE.toml", requires = "instructions", conflicts_with = "check")]
    pub(crate) renew: Option<PathBuf>,
    /// Write all that was measured as JSON; `-` is stdout, and the table is then left out
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write the figures of this run into a page of the manual, in place of the table that it has
    #[arg(long, value_name = "FILE.md", conflicts_with_all = ["ticks", "instructions"])]
    pub(crate) page: Option<PathBuf>,
    /// No progress bar, no notes, no table (files are still written)
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
    /// What a process of its own is to measure: for `baudbot-bench` itself
    #[arg(long, value_name = "TASK", hide = true, exclusive = true)]
    pub(crate) child: Option<String>,
}

/// What is done other than to measure.
#[derive(Debug, Subcommand)]
pub(crate) enum Action {
    /// Measure workloads and another program in turn, A B A B; report the median of the ratios
    Beside(BesideArgs),
}

#[derive(Debug, clap::Args)]
pub(crate) struct BesideArgs {
    /// The other program's command, for the shell
    #[arg(value_name = "CMD")]
    pub(crate) command: String,
    /// Workloads of this program
    #[arg(value_name = "WORKLOAD", required = true)]
    pub(crate) workloads: Vec<String>,
    /// A regular expression whose first group is the figure; its last match in the other program's output counts [default: what
    /// baudbot-bench writes, as JSON or table]
    #[arg(long, value_name = "REGEX")]
    pub(crate) pattern: Option<String>,
    /// How many pairs
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) pairs: u32,
}

/// A text that is no length of a repeat.
#[derive(Debug, thiserror::Error)]
#[error("must be above 0 and at most {MOST_S}, is {0}")]
struct SecondsError(String);

fn seconds(text: &str) -> Result<f64, SecondsError> {
    let fits = |seconds: &f64| *seconds > 0.0 && *seconds <= MOST_S;
    text.parse().ok().filter(fits).ok_or_else(|| SecondsError(text.to_owned()))
}

/// A repeat of an hour.
const MOST_S: f64 = 3600.0;

const EXAMPLES: &str = "\
Examples:
  baudbot-bench                                  all workloads, five repeats of two seconds each
  baudbot-bench W2 W3/1000 --repeats 3 --seconds 0.5
  baudbot-bench W3/1000 --threads 2
  baudbot-bench beside '/old/baudbot-bench W1 --repeats 1 --json -' W1
  baudbot-bench --instructions W1 W2             what valgrind counts, the same on a busy machine
  baudbot-bench --json before.json               to compare with later
  valgrind --tool=callgrind baudbot-bench W1/onboard --ticks 10000

Each workload runs in a process of its own. Just before each repeat a fixed loop is timed: the column \"per 10^6 rounds\"
is the figure for a million of its rounds, and compares between machines better than the figure does. crates/bench/README.md
has the workloads. The exit code is 1 if one of them could not be measured.";
