//! Throws altered bytes at all that reads bytes from outside: nothing may panic, hang or grow without bound.
//!
//! Each target takes bytes and says in a number what came of them. The loop alters what it has, and keeps what led to a
//! number that it has not seen: so it gets past the first check of a format. It needs no instrumented build, so it runs
//! on stable Rust; it sees less of the code than a fuzzer that counts branches.
//!
//! ```text
//! xtask/tools/fuzz            every target for 5 seconds
//! xtask/tools/fuzz 600        for ten minutes each
//! xtask/tools/fuzz 60 states recordings
//! xtask/tools/fuzz --wanted frames               as many inputs as are wanted before a release
//! xtask/tools/fuzz --executions 1000000 hex      so many
//! xtask/tools/fuzz --coverage 20                 which lines are reached
//! ```
//!
//! It begins with the inputs of the targets, and those in `tests/examples/fuzz/corpus/TARGET/`. An input that fails is written into
//! that folder, so that it is tried first from then on, and the command is told that tries it alone. With `--keep` the shortest
//! inputs that lead to something new are kept there, too.

mod alter;
mod chance;
mod fuzzer;
mod targets;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Parser;

use fuzzer::{Fuzzer, Until};

#[derive(Parser)]
struct Args {
    /// The targets; all of them if none is named
    targets: Vec<String>,
    /// Time for each target, in seconds
    #[arg(long, default_value_t = 5.0, value_parser = seconds)]
    seconds: f64,
    /// Try this many altered inputs of each instead
    #[arg(long, conflicts_with = "seconds")]
    executions: Option<u64>,
    /// Try as many as are wanted before a release: 100 million of each protocol, a million of the others
    #[arg(long, conflicts_with_all = ["seconds", "executions"])]
    wanted: bool,
    /// Keep the shortest inputs that led to something new in tests/examples/fuzz/corpus/TARGET
    #[arg(long)]
    keep: bool,
    /// Seed of the random numbers; another one tries other inputs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Try this input alone
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// List the targets
    #[arg(long)]
    list: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let fits = |seconds: &f64| (0.0..=1e6).contains(seconds);
    text.parse().ok().filter(fits).ok_or_else(|| format!("must be from 0 to 1000000 s, is `{text}`"))
}

fn main() -> anyhow::Result<ExitCode> {
    let args = Args::parse();
    let all = targets::all()?;
    if args.list {
        all.iter().for_each(|target| println!("{:12} {}", target.name, target.what));
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(name) = args.targets.iter().find(|name| all.iter().all(|target| target.name != **name)) {
        bail!("{name}: there is no such target; --list names them");
    }
    let is_wanted = |name: &str| args.targets.is_empty() || args.targets.iter().any(|wanted| wanted == name);
    let mut failed = false;
    for target in all.into_iter().filter(|target| is_wanted(target.name)) {
        let until = match args.executions {
            _ if args.wanted => Until::Executions(target.wanted()),
            Some(executions) => Until::Executions(executions),
            None => Until::Time(Duration::from_secs_f64(args.seconds)),
        };
        let mut fuzzer = Fuzzer::new(target, args.seed)?;
        match &args.input {
            Some(file) => {
                fuzzer.once(&std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?);
            }
            None => fuzzer.run(until),
        }
        if args.keep {
            fuzzer.keep()?;
        }
        failed |= fuzzer.report()?;
    }
    Ok(if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `BAUDBOT_FUZZ_SECONDS` gives each target longer than it takes to see that its own inputs are sound.
    #[test]
    fn no_target_fails_in_a_moment() {
        let seconds = std::env::var("BAUDBOT_FUZZ_SECONDS").ok().and_then(|text| text.parse().ok());
        for target in targets::all().unwrap() {
            let name = target.name;
            let mut fuzzer = Fuzzer::new(target, 1).unwrap();
            fuzzer.run(Until::Time(Duration::from_secs_f64(seconds.unwrap_or(0.1))));
            assert!(!fuzzer.report().unwrap(), "{name}");
        }
    }
}
