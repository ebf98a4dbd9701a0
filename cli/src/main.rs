//! The program `baudbot`: runs, serves, watches and checks worlds of mobile robots.
//!
//! From the command line inwards:
//!
//! 1. `args` is the command line; `error` is why a command fails, in one line, and `failure` how it ends then.
//! 2. `run`, `sweep`, `tune`, `worst`, `grade`, `serve`, `replay`, `brain`, `check`, `budget`, `diagram`, `plan`, `locate`, `umbmark`, `measure`,
//!    `preset`, `evidence`, `fit`, `export`, `export_brain`, `watch`, `new`, `token`, `state`, `cert`, `list` and `pages` are the commands, one a file or folder; `work` is
//!    what `sweep`, `tune`, `worst` and `grade` share, and `class` grades many brains.
//! 3. `scenarios` finds scenarios, `connect` finds servers, `serving` starts a server, `state` finds the worlds that a server has left, which `kept` checks, `assignment` reads `--brain`.
//!    `opened` opens files for reading, `output_files` writes files during a run, `record` reads the options of recordings.
//! 4. `summary` collects the results of a run and `report` prints them; `csv` is the table of a run, `trace` its timeline
//!    for Perfetto, `map` an arena in characters, `gdb` lets debuggers in, `link` a link in words, `together` warns of sensors whose readings arrive
//!    too far apart, `robot_groups` groups the robots of one table. `escapes` are bytes as a command line has them. `text`
//!    lays out columns and is the only module that writes to a terminal, `viewer` prints the address of a page, and
//!    `foxglove` serves Foxglove. Pictures are `baudbot-plot`'s.
//! 5. `logs` writes the log, to stderr or, with the feature `otel`, to a collector.
//!
//! Worlds have threads of their own, in `baudbot-server`, and `signals` has one; everything else shares one thread.

#![deny(clippy::print_stderr, clippy::print_stdout)]

mod announcement;
mod args;
mod assignment;
mod brain;
mod budget;
mod cert;
mod check;
mod chips;
mod class;
mod completions;
mod conform;
mod connect;
mod csv;
mod diagram;
mod error;
mod escapes;
mod evidence;
mod export;
mod export_brain;
mod failure;
mod fit;
mod foxglove;
mod gdb;
mod grade;
mod kept;
mod link;
mod list;
mod load;
mod locate;
mod logs;
mod man;
mod map;
mod measure;
mod natural;
mod new;
mod output_files;
mod plan;
mod port_watch;
mod ports;
mod preset;
mod record;
mod replay;
mod report;
mod robot_groups;
mod run;
mod scenarios;
mod serial;
mod serve;
mod serving;
mod shards;
mod signals;
mod state;
mod summary;
mod sweep;
mod text;
mod together;
mod token;
mod trace;
mod tune;
mod umbmark;
mod vcd;
mod viewer;
mod watch;
mod work;
mod worst;

use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use tokio::runtime::Runtime;

use crate::args::{Command, NewCommand, PortCommand};

/// Worlds and clients of a server come and go for weeks. With the system's allocator its memory grew, in an hour of `./test soak`, by 9 MB that
/// were not in use.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let cli = match args::parsed() {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let (filter, format) = (cli.log.clone(), cli.log_format);
    let command = cli.into_command();
    let serves = matches!(command, Command::Run(_) | Command::Program(_) | Command::Serve(_));
    // The logs live until the end: what is to be exported goes out when they are dropped.
    let _logs = logs::start(filter, format, serves);
    match execute(command) {
        Ok(code) => code,
        Err(error) => failure::told(&error),
    }
}

fn execute(command: Command) -> anyhow::Result<ExitCode> {
    // A brain and the server next to it talk in turn: a second thread would only pass their messages on.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.context("cannot start the runtime")?;
    let done = execute_on(&runtime, command);
    // The exit does not wait for work that still hangs, such as a disk.
    runtime.shutdown_timeout(PATIENCE);
    done
}

/// The time for which background work may continue at the end.
const PATIENCE: Duration = Duration::from_secs(1);

fn execute_on(runtime: &Runtime, command: Command) -> anyhow::Result<ExitCode> {
    match command {
        Command::Run(args) => return runtime.block_on(run::run(&args)),
        Command::Program(args) => return runtime.block_on(run::run(&args.into_run())),
        Command::Sweep(args) => return runtime.block_on(sweep::sweep(args)),
        Command::Worst(args) => return runtime.block_on(worst::worst(args)),
        Command::Tune(args) => return runtime.block_on(tune::tune(args)),
        Command::Grade(args) => return runtime.block_on(grade::grade(args)),
        Command::Conform(args) => return runtime.block_on(conform::conform(&args)),
        Command::Serve(args) => runtime.block_on(serve::serve(&args)),
        Command::Brain(args) => runtime.block_on(brain::brain(args)),
        Command::Diagram(args) => return runtime.block_on(diagram::diagram(args)),
        Command::Replay(args) => return runtime.block_on(replay::replay(&args)),
        Command::Check(args) => check::check(&args),
        Command::Budget(args) => return budget::budget(&args),
        Command::Plan(args) => return plan::plan(&args),
        Command::Locate(args) => return locate::locate(&args),
        Command::Evidence(args) => return evidence::evidence(&args),
        Command::Measure(command) => return measure::measure(&command),
        Command::Umbmark(args) => return umbmark::umbmark(&args),
        Command::Preset(args) => preset::preset(&args),
        Command::Fit(args) => return fit::fit(&args),
        Command::Export(args) => return runtime.block_on(export::export(&args)),
        Command::ExportBrain(args) => export_brain::export_brain(&args),
        Command::New(NewCommand::Brain(args)) => new::brain(&args),
        Command::New(NewCommand::Firmware(args)) => new::firmware(&args),
        Command::Watch(args) => runtime.block_on(watch::watch(&args)),
        Command::Port(PortCommand::Open(args)) => runtime.block_on(ports::open(&args)),
        Command::Port(PortCommand::Watch(args)) => runtime.block_on(port_watch::watch(&args)),
        Command::State(command) => return kept::state(&command),
        Command::Token(command) => token::token(command),
        Command::Cert(command) => cert::cert(&command),
        Command::List(args) => list::list(&args),
        Command::Init(args) => list::init(&args),
        Command::Schema => text::print_json(&baudbot_scenario::schema()),
        Command::Completions(args) => completions::completions(&args),
        Command::Man(args) => man::man(&args),
    }?;
    Ok(ExitCode::SUCCESS)
}
