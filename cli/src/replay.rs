//! `baudbot replay`: a recorded run is simulated again, and compared with the recording.

use std::io::{BufReader, IsTerminal};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use baudbot_import::opened;
use baudbot_recording::{Coverage, RecordedRun, RecordingError, Replay};
use baudbot_server::{Pace, WorldConfig, pace_of};
use baudbot_sim::{Scenario, World};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use crate::args::{PaceName, ReplayArgs, WatchdogArgs};
use crate::error::Refused;
use crate::serving::{Serving, Viewing};
use crate::text::tell;
use crate::{record, text};

/// The outcome.
#[derive(Debug, Serialize)]
struct Finding {
    recording: String,
    world: String,
    scenario: String,
    seed: u64,
    recorded_by: String,
    first_tick: u64,
    last_tick: u64,
    simulated_s: f64,
    ticks_with_inputs: usize,
    events: usize,
    identical: bool,
    /// Nothing that was recorded is missing before the last tick.
    complete: bool,
    compared_ticks: u64,
    /// The number of ticks; `None` if the end is missing and its place is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    recorded_ticks: Option<u64>,
    /// The first tick that differs, and what of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    differs_at_tick: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    differs: Option<String>,
    /// The reason why the file ends too early.
    #[serde(skip_serializing_if = "Option::is_none")]
    cut_off: Option<String>,
    /// Hexadecimal, as JSON's numbers have too few bits.
    state_hash: String,
}

pub(crate) async fn replay(args: &ReplayArgs) -> anyhow::Result<ExitCode> {
    check(args)?;
    let (mut replay, mut world) = open(&args.recording)?;
    let recorded = Arc::clone(replay.recorded());
    if !args.quiet {
        note(&args.recording, &recorded);
    }
    if args.fork {
        let pace = pace(args.pace, &args.watchdog, &recorded)?;
        to(args, &mut replay, &mut world)?;
        if let Some(difference) = replay.difference() {
            tell!("warning: the replay differs from the recorded world at {difference}");
        }
        let name = recorded.header().world.clone();
        return live(args, name, world, pace).await.map(|()| ExitCode::SUCCESS);
    }
    if args.view {
        to(args, &mut replay, &mut world)?;
        return view(args, replay, world).await.map(|()| ExitCode::SUCCESS);
    }
    let last_tick = args.to.map_or_else(|| recorded.last_tick(), |to_s| tick(to_s, recorded.scenario()));
    go_on(&mut replay, &mut world, last_tick, args.quiet)?;
    let finding = finding(args, &replay, &world);
    if args.json {
        text::print_json(&finding)?;
    } else {
        text::print(&words(&finding))?;
    }
    Ok(match finding {
        Finding { identical: false, .. } => ExitCode::FAILURE,
        Finding { complete: false, .. } => ExitCode::from(INCOMPLETE),
        Finding { .. } => ExitCode::SUCCESS,
    })
}

/// Prints a note on the damage of the file.
fn note(file: &Path, recorded: &RecordedRun) {
    let file = file.display();
    if let Some(problem) = recorded.problem() {
        tell!("note: {file}: {problem}; it is replayed as far as possible");
    } else if let Some(scratch) = recorded.scratch() {
        tell!("note: {file}: {scratch}, but all inputs of the run are present");
    }
}

/// Refuses options that would be of no use.
fn check(args: &ReplayArgs) -> anyhow::Result<()> {
    let (listen, watchdog) = (&args.listen, &args.watchdog);
    let listens = listen.viewer.is_some() || listen.given().is_some();
    let waits =
        watchdog.watchdog_ms.is_some() || watchdog.on_timeout.is_some() || watchdog.lookahead.is_some();
    let lags = watchdog.max_lag_ms.is_some();
    let refused = |text: &str| Err(Refused::error(text));
    if args.again.record.is_some() && !args.fork {
        return refused("--record: a replayed run is already recorded; use it with --fork");
    }
    if listens && !args.fork && !args.view {
        return refused(
            "--listen, --viewer and the options about access and limits need --view or --fork: otherwise nothing is served",
        );
    }
    if waits && !args.fork {
        return refused(
            "--watchdog-ms, --on-timeout and --lookahead need --fork: otherwise there are no brains",
        );
    }
    if lags && !args.fork {
        return refused("--max-lag-ms needs --fork: a view never catches up with more than 100 ms");
    }
    Ok(())
}

/// A recording at its first tick.
pub(crate) fn open(path: &Path) -> anyhow::Result<(Replay, World)> {
    let recorded = recorded_run(path).map_err(|error| refused(path, &error))?;
    Replay::start(Arc::new(recorded)).map_err(|error| refused(path, &error))
}

/// Reads a recording.
pub(crate) fn recorded_run(path: &Path) -> Result<RecordedRun, RecordingError> {
    RecordedRun::read(BufReader::with_capacity(1 << 20, opened::plain(path)?))
}

/// Goes on to a tick, and shows how far it is.
pub(crate) fn go_on(
    replay: &mut Replay,
    world: &mut World,
    last_tick: u64,
    quiet: bool,
) -> anyhow::Result<()> {
    let last_tick = replay.recorded().nearest(last_tick);
    let bar = progress(world.tick(), last_tick, quiet);
    while world.tick() < last_tick && replay.step(world).context("the recording cannot be replayed")? {
        if world.tick().is_multiple_of(REDRAW_TICKS) {
            bar.set_position(world.tick());
        }
    }
    bar.finish_and_clear();
    Ok(())
}

/// The pace that is asked for, or that of the recording, with the options for it.
pub(crate) fn pace(
    asked: Option<PaceName>,
    watchdog: &WatchdogArgs,
    recorded: &RecordedRun,
) -> anyhow::Result<Pace> {
    let as_recorded = || recorded.header().pace.and_then(pace_of).unwrap_or(Pace::REAL_TIME);
    watchdog.apply(asked.map_or_else(as_recorded, PaceName::pace))
}

/// The reason why there is no recording, or that something else is in its place.
pub(crate) fn refused(path: &Path, error: &RecordingError) -> anyhow::Error {
    let is_absent =
        matches!(error, RecordingError::Io(cause) if cause.kind() == std::io::ErrorKind::NotFound);
    let no_recording = (is_absent || matches!(error, RecordingError::NotMcap(_)))
        .then(|| baudbot_import::source::no_recording(path));
    match no_recording.flatten() {
        Some(mistaken) => Refused::error(mistaken.to_string()),
        None => Refused::error(format!("{}: {error}", path.display())),
    }
}

/// Goes to the tick of `--to`.
fn to(args: &ReplayArgs, replay: &mut Replay, world: &mut World) -> anyhow::Result<()> {
    let recorded = Arc::clone(replay.recorded());
    let Some(to_s) = args.to else {
        // A fork without a place goes on where the recording ends.
        return if args.fork { go_on(replay, world, recorded.last_tick(), args.quiet) } else { Ok(()) };
    };
    let tick = tick(to_s, recorded.scenario());
    if !(recorded.first_tick()..=recorded.last_tick()).contains(&tick) {
        let [first, last] =
            [recorded.first_tick(), recorded.last_tick()].map(|tick| seconds(tick, recorded.scenario()));
        return Err(Refused::error(format!("--to {to_s}: the recording is from {first} s to {last} s")));
    }
    if recorded.nearest(tick) != tick {
        let behind =
            recorded.stretches().iter().map(|stretch| stretch.first_tick).find(|first| *first > tick);
        let [before, behind] = [recorded.nearest(tick), behind.unwrap_or(tick)];
        let [before, behind] = [before, behind].map(|tick| seconds(tick, recorded.scenario()));
        return Err(Refused::error(format!(
            "--to {to_s}: the recording is damaged from {before} s to {behind} s; choose another time"
        )));
    }
    replay.seek(world, tick).context("the recording cannot be replayed")
}

async fn live(args: &ReplayArgs, name: String, world: World, pace: Pace) -> anyhow::Result<()> {
    let mut serving = Serving::new(&args.listen)?;
    let config = record::add(WorldConfig::from_state(name.clone(), world.clone()).pace(pace), &args.again);
    serving.add(&name, world.scenario(), config);
    serving.until_stopped(Viewing::IfOpen).await
}

async fn view(args: &ReplayArgs, replay: Replay, world: World) -> anyhow::Result<()> {
    let mut serving = Serving::new(&args.listen)?;
    let name = replay.recorded().header().world.clone();
    serving.add_replay(&name, WorldConfig::replay(name.clone(), (replay, world)));
    serving.until_stopped(Viewing::Always).await
}

fn finding(args: &ReplayArgs, replay: &Replay, world: &World) -> Finding {
    let (recorded, difference) = (replay.recorded(), replay.difference());
    let header = recorded.header();
    let asked = args.to.map(|to_s| tick(to_s, recorded.scenario()));
    let Coverage { is_complete, compared_ticks, recorded_ticks } = recorded.coverage(asked);
    Finding {
        recording: args.recording.display().to_string(),
        world: header.world.clone(),
        scenario: recorded.scenario().name.clone(),
        seed: header.seed,
        recorded_by: format!("baudbot {}", header.program_version),
        first_tick: recorded.first_tick(),
        last_tick: world.tick(),
        simulated_s: seconds(world.tick().saturating_sub(recorded.first_tick()), recorded.scenario()),
        ticks_with_inputs: recorded.inputs(),
        events: recorded.events().len(),
        identical: difference.is_none(),
        complete: is_complete,
        compared_ticks,
        recorded_ticks,
        differs_at_tick: difference.map(|difference| difference.tick),
        differs: difference.map(|difference| difference.what.clone()),
        cut_off: recorded.problem().map(str::to_owned),
        state_hash: format!("{:016x}", world.hash()),
    }
}

fn words(finding: &Finding) -> String {
    let Finding { world, first_tick, last_tick, simulated_s, recorded_by, .. } = finding;
    let head = format!(
        "world {world}, ticks {first_tick} to {last_tick} ({simulated_s} s), {} with inputs, recorded by {recorded_by}\n",
        finding.ticks_with_inputs
    );
    let verdict = match (&finding.differs_at_tick, &finding.differs) {
        (Some(tick), Some(what)) => format!("differs at tick {tick}: {what}\n"),
        _ if !finding.complete => {
            let Finding { complete, compared_ticks, recorded_ticks, state_hash, .. } = finding;
            let share = Coverage {
                is_complete: *complete,
                compared_ticks: *compared_ticks,
                recorded_ticks: *recorded_ticks,
            };
            format!("incomplete: identical in {share}: state hash {state_hash}\n")
        }
        _ => format!("identical: state hash {}\n", finding.state_hash),
    };
    head + &verdict
}

fn tick(at_s: f64, scenario: &Scenario) -> u64 {
    (at_s * 1e9 / scenario.step_ns as f64).round() as u64
}

fn seconds(ticks: u64, scenario: &Scenario) -> f64 {
    ticks.saturating_mul(scenario.step_ns) as f64 / 1e9
}

fn progress(first: u64, last: u64, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(last), ProgressDrawTarget::stderr());
    bar.set_position(first);
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} ticks, {eta} to go");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// The exit code if nothing differs, but not all could be compared.
const INCOMPLETE: u8 = 3;

/// The number of ticks between two looks at the bar.
const REDRAW_TICKS: u64 = 256;
