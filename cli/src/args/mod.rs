//! The command line.

mod access;
mod brain;
mod budget;
mod cert;
mod chips;
mod conform;
mod diagram;
mod export;
mod export_brain;
mod fit;
mod gdb;
mod grade;
mod groups;
mod help;
mod limits;
mod list;
mod locate;
mod measure;
mod new;
mod over;
mod pace;
mod places;
mod plan;
mod port;
mod port_watch;
mod preset;
mod program;
mod record;
mod state;
mod token;
mod umbmark;
mod value;
mod work;

use std::path::PathBuf;

use baudbot_experiment::Demand;
use baudbot_port::PortAddress;
use baudbot_server::Address;
use clap::{Args, Parser, Subcommand};

pub(crate) use self::brain::BrainArgs;
pub(crate) use self::budget::BudgetArgs;
pub(crate) use self::cert::CertCommand;
#[cfg(feature = "certificates")]
pub(crate) use self::cert::{AuthorityArgs, ClientCertificateArgs, ServerCertificateArgs};
pub(crate) use self::chips::{ChipArgs, ChipOutput};
pub(crate) use self::conform::ConformArgs;
pub(crate) use self::diagram::DiagramArgs;
pub(crate) use self::export::{ExportArgs, FilmArgs, RowArgs, Theme, WindowArgs};
pub(crate) use self::export_brain::{ExportBrainArgs, ExportLanguage};
pub(crate) use self::fit::FitArgs;
pub(crate) use self::gdb::GdbAddress;
pub(crate) use self::grade::GradeArgs;
pub(crate) use self::groups::{command, parsed};
use self::help::{
    BRAIN_EXAMPLES, BUDGET_EXAMPLES, CHECK_EXAMPLES, DIAGRAM_EXAMPLES, EVIDENCE_EXAMPLES, PACE_HELP,
    PRESET_EXAMPLES, REPLAY_EXAMPLES, RUN_EXAMPLES, SERVE_EXAMPLES, SERVED_PACE_HELP, SWEEP_EXAMPLES,
    TUNE_EXAMPLES, WATCH_EXAMPLES, WORST_EXAMPLES,
};
pub(crate) use self::list::{CompletionsArgs, InitArgs, ListArgs, ManArgs};
pub(crate) use self::locate::{LocateArgs, Search};
pub(crate) use self::measure::{Bytes, CurveArgs, EchoArgs, MeasureCommand, PortArgs, StepArgs};
pub(crate) use self::new::{FirmwareLanguage, Language, NewBrainArgs, NewCommand, NewFirmwareArgs};
pub(crate) use self::over::Over;
pub(crate) use self::pace::{PaceName, WatchdogArgs};
pub(crate) use self::places::{ConnectArgs, DEFAULT_ADDRESS, ListenArgs};
pub(crate) use self::plan::{Method, PlanArgs};
pub(crate) use self::port::{OpenPortArgs, PortCommand};
pub(crate) use self::port_watch::WatchPortArgs;
pub(crate) use self::preset::{EvidenceArgs, PresetArgs};
pub(crate) use self::program::ProgramArgs;
pub(crate) use self::record::{RecordArgs, ReplayArgs};
pub(crate) use self::state::{CheckStateArgs, RecoverArgs, StateCommand};
pub(crate) use self::token::{ListTokensArgs, NewTokenArgs, RevokeTokenArgs, TokenCommand, TokenFileArgs};
pub(crate) use self::umbmark::UmbmarkArgs;
use self::value::{finite, instant, patience, span, whole};
pub(crate) use self::work::{SweepArgs, TuneArgs, WorkArgs, WorstArgs};
use crate::logs::{LogFilter, LogFormat};

/// A simulation server for mobile robots whose controllers (brains) run as separate programs.
///
/// Without a command, `baudbot` lets a robot wander for 60 simulated seconds and prints a summary.
#[derive(Debug, Parser)]
#[command(
    name = "baudbot",
    version,
    after_help = "`baudbot help COMMAND` shows a command's options with examples."
)]
pub(crate) struct Cli {
    /// Log level on stderr: off, error, warn, info, debug or trace; also per module, such as warn,baudbot_server=info
    #[arg(long, value_name = "LEVEL", default_value = "warn", env = "BAUDBOT_LOG", global = true, help_heading = LOG)]
    pub(crate) log: LogFilter,
    /// Log format: text, or one JSON object per line
    #[arg(long, value_name = "FORMAT", default_value = "text", global = true, help_heading = LOG)]
    pub(crate) log_format: LogFormat,
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Runs a scenario with its brains in this process and prints a summary
    #[command(after_long_help = RUN_EXAMPLES)]
    Run(RunArgs),
    /// Runs an unmodified program that opens serial ports of a robot, in simulated time
    #[command(after_long_help = program::EXAMPLES)]
    Program(ProgramArgs),
    /// Runs an experiment: a scenario many times, with some of its fields varied
    #[command(after_long_help = SWEEP_EXAMPLES)]
    Sweep(SweepArgs),
    /// Searches for the parameters of a brain or a scenario that maximize the score of an experiment
    #[command(after_long_help = TUNE_EXAMPLES)]
    Tune(TuneArgs),
    /// Searches an experiment for the run in which the robot fails, or comes nearest to it
    #[command(after_long_help = WORST_EXAMPLES)]
    Worst(WorstArgs),
    /// Grades a brain on an exercise, with points and advice; without one, lists the exercises
    #[command(after_long_help = grade::EXAMPLES)]
    Grade(GradeArgs),
    /// Examines whether a brain in any language keeps to the contract
    #[command(after_long_help = conform::EXAMPLES)]
    Conform(ConformArgs),
    /// Serves worlds to brains in other processes until Ctrl-C
    #[command(after_long_help = SERVE_EXAMPLES)]
    Serve(ServeArgs),
    /// Replays a recording: verifies it, shows it, or continues from it
    #[command(after_long_help = REPLAY_EXAMPLES)]
    Replay(ReplayArgs),
    /// Runs a brain against a server; without a name, lists the brains
    #[command(after_long_help = BRAIN_EXAMPLES)]
    Brain(BrainArgs),
    /// Describes a scenario, or reports its errors
    #[command(after_long_help = CHECK_EXAMPLES)]
    Check(CheckArgs),
    /// Draws a timing diagram of a run: sensors, microcontroller, cable, brain and motors over time
    #[command(after_long_help = DIAGRAM_EXAMPLES)]
    Diagram(DiagramArgs),
    /// Computes the duration of each robot's control cycle, compares it with the deadline, and suggests remedies
    #[command(after_long_help = BUDGET_EXAMPLES)]
    Budget(BudgetArgs),
    /// Plans a path through a scenario's arena, and shows the examined cells
    #[command(after_long_help = plan::EXAMPLES)]
    Plan(PlanArgs),
    /// Localizes a robot from a scan of its laser, and shows the poses tried
    #[command(after_long_help = locate::EXAMPLES)]
    Locate(LocateArgs),
    /// Measures the systematic errors of a robot's odometry by driving squares in both directions (UMBmark)
    #[command(after_long_help = umbmark::EXAMPLES)]
    Umbmark(UmbmarkArgs),
    /// Measures a real robot on the bench: echoes on its serial port, a sensor's curve, its motors' step response
    #[command(subcommand)]
    Measure(MeasureCommand),
    /// Lists presets of robots and their parts, or shows one with the sources of its numbers
    #[command(after_long_help = PRESET_EXAMPLES)]
    Preset(PresetArgs),
    /// Compares presets with measurements of real robots: all comparisons, or only the comparisons or presets named
    #[command(after_long_help = EVIDENCE_EXAMPLES)]
    Evidence(EvidenceArgs),
    /// Fits parameters of a robot to a log of a real one, with 95 % confidence intervals
    #[command(after_long_help = fit::EXAMPLES)]
    Fit(FitArgs),
    /// Exports tables, traces, pictures and films from a recording, or describes it
    #[command(after_long_help = export::EXAMPLES)]
    Export(ExportArgs),
    /// Writes a brain as one C file for a robot's own microcontroller
    #[command(after_long_help = export_brain::EXAMPLES)]
    ExportBrain(ExportBrainArgs),
    /// Creates a small project as a starting point
    #[command(subcommand)]
    New(NewCommand),
    /// Shows a running world on a server
    #[command(after_long_help = WATCH_EXAMPLES)]
    Watch(WatchArgs),
    /// Opens serial ports on this machine for a server's robots, or prints and decodes the bytes on a cable
    #[command(subcommand)]
    Port(PortCommand),
    /// Creates, lists and revokes tokens, which give clients their rights on a server
    #[command(subcommand)]
    Token(TokenCommand),
    /// Checks the folder of a server with --state, and recovers damaged worlds
    #[command(subcommand)]
    State(StateCommand),
    /// Lists the built-in scenarios, experiments, exercises, brains and presets
    #[command(after_long_help = list::LIST_EXAMPLES)]
    List(ListArgs),
    /// Writes a built-in scenario or experiment to a file, as a starting point for your own
    #[command(after_long_help = list::LIST_EXAMPLES)]
    Init(InitArgs),
    /// Prints a JSON Schema for scenario files, for completion and error checking in editors
    #[command(after_long_help = list::SCHEMA_EXAMPLES)]
    Schema,
    /// Prints completions of commands and options for a shell
    #[command(after_long_help = list::COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Writes man pages into a folder
    Man(ManArgs),
    /// Creates certificates for servers and clients, and an authority for them
    #[command(subcommand)]
    Cert(CertCommand),
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// A scenario file, or a built-in scenario, such as wander or devices/laser (`baudbot list`)
    pub(crate) scenario: Option<String>,
    /// A brain for one robot, or for all robots that no other --brain names; `none` leaves a robot without a brain
    ///
    /// BRAIN is a name, a brain's description file in TOML, or `exec:PROGRAM ARGUMENTS…`, a program of your own, which attaches to the
    /// server, world and robot given by the environment variables BAUDBOT_CONNECT, BAUDBOT_WORLD and BAUDBOT_ROBOT. `program:PROGRAM
    /// ARGUMENTS…` opens serial ports instead, in simulated time (`baudbot help program`). ROBOT may be a pattern such as
    /// 'cell-*'. By default every robot gets `avoid`, which needs IR sensors. `baudbot brain --list` lists the brains.
    #[arg(long = "brain", value_name = "[ROBOT=]BRAIN[:K=V,…]")]
    pub(crate) brains: Vec<String>,
    /// Set a parameter of all brains that have it; programs get it in the environment variable BAUDBOT_PARAMETERS
    #[arg(long = "parameter", value_name = "NAME=VALUE")]
    pub(crate) parameters: Vec<String>,
    /// Wait for other programs to attach to N robots before the run begins; robots that no --brain names are left to them
    #[arg(long, value_name = "N", value_parser = whole(1_u16..=u16::MAX))]
    pub(crate) external: Option<u16>,
    /// Pass the output of brains that are programs on to stderr [default: only the last lines of a brain that fails]
    #[arg(long)]
    pub(crate) show_output: bool,
    /// End the run with exit code 1 if a brain that is a program does not answer within this wall-clock time [default: only print a
    /// message, after 10 s]
    #[arg(long, value_name = "S", value_parser = patience)]
    pub(crate) brain_timeout: Option<f64>,
    /// End after this much simulated time
    #[arg(long, value_name = "S", conflicts_with = "ticks", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) seconds: Option<f64>,
    /// End after this many ticks
    #[arg(long, value_name = "N", value_parser = whole(1_u64..=u64::MAX))]
    pub(crate) ticks: Option<u64>,
    /// Something that must hold of the run, such as 'always clearance_m > 0.05'; exit code 1 if it does not
    ///
    /// RULE is always FORMULA, never FORMULA, eventually FORMULA [within S s], or whenever FORMULA then FORMULA within S s; at its end
    /// may stand `, from S s on` and `(of ROBOT)`. The quantities are those of [require] in an experiment
    /// (docs/reference/experiments.md).
    #[arg(long = "require", value_name = "RULE")]
    pub(crate) requirements: Vec<Demand>,
    /// Write the state at every tick as a CSV table; `-` is stdout, and the summary then goes to stderr
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write the events of robots, cables and brains as a trace for ui.perfetto.dev
    #[arg(long, value_name = "FILE")]
    pub(crate) timeline: Option<PathBuf>,
    /// Write the summary as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Suppress the progress bar, notes and the summary (JSON is still written)
    #[arg(long)]
    pub(crate) quiet: bool,
    /// When a tick ends: lockstep, real-time, scaled:X or free
    #[arg(long, value_name = "PACE", default_value = "lockstep", long_help = PACE_HELP, help_heading = PACE)]
    pub(crate) pace: PaceName,
    /// Connection between the brains and their world; the run is the same either way [default: direct, or grpc where a server is needed]
    ///
    /// A server is needed for paces other than lockstep, for --listen and --viewer, for the options about access and limits, for
    /// --external, --brain-timeout, brains that are programs, --watchdog-ms, --on-timeout and --lookahead, and for exporting OTLP traces.
    /// `direct` is many times faster.
    #[arg(long, value_name = "PATH")]
    pub(crate) over: Option<Over>,
    #[command(flatten)]
    pub(crate) chips: ChipArgs,
    #[command(flatten)]
    pub(crate) watchdog: WatchdogArgs,
    #[command(flatten)]
    pub(crate) record: RecordArgs,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
    #[command(flatten)]
    pub(crate) listen: ListenArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Scenario files, or built-in scenarios (`baudbot list`) [default: wander]
    ///
    /// Each becomes a world with the name of the scenario, or of the file if the scenario has no name.
    pub(crate) scenarios: Vec<String>,
    /// Keep the worlds paused until an operator starts them (ControlService.StartWorld)
    #[arg(long)]
    pub(crate) paused: bool,
    /// When a tick ends: lockstep, real-time, scaled:X or free [default: real-time; with --resume, the recorded pace]
    #[arg(long, value_name = "PACE", long_help = SERVED_PACE_HELP, help_heading = PACE)]
    pub(crate) pace: Option<PaceName>,
    /// Let operators record worlds into this folder, and replay the recordings in it
    #[arg(long, value_name = "FOLDER", help_heading = record::HEADING)]
    pub(crate) recordings: Option<PathBuf>,
    /// Store worlds, snapshots and recordings in this folder, so that they survive even a crash of the server
    ///
    /// The folder is created if needed. Worlds in the folder continue; a scenario whose world is among them is not started again
    /// (docs/reference/state.md).
    #[arg(long, value_name = "FOLDER")]
    pub(crate) state: Option<PathBuf>,
    /// After Ctrl-C or SIGTERM, exit with code 1 if worlds and recordings take longer than this to close, in seconds
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = whole(1_u32..=3600))]
    pub(crate) stop_within: u32,
    /// Once the server is ready, write its first address into this file: one line, such as 127.0.0.1:7400
    ///
    /// For tests: with `--listen 127.0.0.1:0` the system chooses a free port. The file appears in one step, so it is complete as soon as it
    /// is there; an older one is removed first.
    #[arg(long, value_name = "FILE")]
    pub(crate) port_file: Option<PathBuf>,
    /// Once the server is ready, print one line of JSON with its addresses and worlds, and nothing else on stdout
    #[arg(long)]
    pub(crate) json: bool,
    /// Listen for trainers, which drive robots and get their true poses: 127.0.0.1:PORT or unix:/PATH
    ///
    /// A trainer also creates its worlds through this address (docs/how-to/training.md), which only this machine can reach.
    #[arg(long, value_name = "ADDR")]
    pub(crate) trainer: Option<Address>,
    /// Open a serial port on the cable of a robot, or of one of its sensors, for programs not written for baudbot
    #[arg(long = "port", value_name = "ROBOT[/SENSOR]=KIND:WHERE", long_help = port::PORT_HELP)]
    pub(crate) ports: Vec<PortAddress>,
    /// Continue the world of a recording from the recording's end; brains can attach to it again
    #[arg(long, value_name = "FILE.mcap", conflicts_with_all = ["scenarios", "sets", "seed", "no_noise"])]
    pub(crate) resume: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) watchdog: WatchdogArgs,
    #[command(flatten)]
    pub(crate) record: RecordArgs,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
    #[command(flatten)]
    pub(crate) listen: ListenArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// A scenario file, or a built-in scenario, such as wander or devices/laser (`baudbot list`)
    pub(crate) scenario: String,
    /// Draw the arena from above as an SVG picture; `-` is stdout, without other output
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write the description as one JSON object, even for an invalid scenario
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}

#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    pub(crate) server: ConnectArgs,
    /// Print one frame and stop
    #[arg(long)]
    pub(crate) once: bool,
    /// Write each frame as a JSON object on one line
    #[arg(long, conflicts_with = "foxglove")]
    pub(crate) json: bool,
    /// Show the world in Foxglove instead of the terminal; Foxglove connects to ws://IP:PORT
    ///
    /// Needs a program built with `--features foxglove`. docs/how-to/foxglove.md has a layout.
    #[arg(
        long, value_name = "IP:PORT", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765",
        conflicts_with = "once"
    )]
    pub(crate) foxglove: Option<Address>,
}

/// Changes to a scenario.
#[derive(Debug, Args)]
#[command(next_help_heading = "Changes to the scenario")]
pub(crate) struct ChangeArgs {
    /// Change one field of the scenario, such as robots.robot.start.x_m=0.5
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Run your own program (Intel HEX or ELF) on a robot's microcontroller, in place of the scenario's program
    #[arg(long, value_name = "ROBOT=FILE")]
    pub(crate) firmware: Vec<String>,
    /// Seed of all random numbers in the world, and of the brains in this process
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole(0_u64..=i64::MAX as u64))]
    pub(crate) seed: Option<u64>,
    /// Switch off sensor noise
    #[arg(long)]
    pub(crate) no_noise: bool,
}

impl Cli {
    /// The command that `baudbot` alone stands for: `baudbot run`.
    pub(crate) fn into_command(self) -> Command {
        self.command.unwrap_or_else(|| {
            let run = Self::parse_from(["baudbot", "run"]).command;
            run.expect("a command line with a command has one")
        })
    }
}

/// Headings of options.
const LOG: &str = "Log";
const ACCESS: &str = "Access";
const LIMITS: &str = "Limits (docs/reference/limits.md)";
const PACE: &str = "Pace";

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
        assert!(matches!(Cli::parse_from(["baudbot"]).into_command(), Command::Run(_)));
    }
}
