//! The arguments of `baudbot conform`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

use super::ChangeArgs;
use super::value::whole;

#[derive(Debug, Args)]
pub(crate) struct ConformArgs {
    /// The brain to examine: `exec:PROGRAM ARGUMENTS…`, as for `baudbot run`
    #[arg(required_unless_present_any = ["external", "list"])]
    pub(crate) brain: Option<String>,
    /// Listen here for a brain that you start yourself, once for each run
    #[arg(long, value_name = "IP:PORT", conflicts_with = "brain")]
    pub(crate) external: Option<SocketAddr>,
    /// List the cases, with the sentences of the contract that they test
    #[arg(long, conflicts_with_all = ["brain", "external"])]
    pub(crate) list: bool,
    /// Scenario with a robot that the brain can drive
    #[arg(long, value_name = "SCENARIO", default_value = crate::scenarios::DEFAULT)]
    pub(crate) scenario: String,
    /// The robot to drive [default: the scenario's first]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Time in which the brain must attach, answer and end, in seconds
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = whole(1_u32..=600))]
    pub(crate) patience: u32,
    /// Write the result as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the result as JUnit XML, for continuous integration; `-` is stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) junit: Option<PathBuf>,
    /// Suppress progress and text (JSON is still written)
    #[arg(long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot conform 'exec:./follow'                a program in any language
  baudbot conform 'exec:python3 follow.py' --scenario my.toml --junit conform.xml
  baudbot conform --external 127.0.0.1:7400      a program that you start yourself
  baudbot conform --list                         the cases

Each case says that the brain `does` what a sentence of the contract asks, `does not`, or that the sentence is `not used`
by it. Exit codes: 0: nothing that it does not, 1: something, 2: the command line is wrong.";
