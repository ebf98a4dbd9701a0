//! `baudbot run`: a world and its brains in one process, until the run ends.

use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use anyhow::{Context, anyhow};
use baudbot_client::Client;
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_scenario::Override;
use baudbot_server::{OnTick, Pace, Server, WorldConfig};
use baudbot_sim::{Scenario, World};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tokio::sync::Notify;
use tokio::task::JoinSet;
use tonic::transport::Channel;

use crate::args::{ChangeArgs, RunArgs};
use crate::assignment::{self, Assignment, AttachedBrains};
use crate::csv::Table;
use crate::error::{Refused, from_builder, from_server};
use crate::output_files::{self, Files, STDOUT};
use crate::scenarios::{self, Source};
use crate::signals::{INTERRUPTED, Stop};
use crate::summary::Summary;
use crate::text::tell;
use crate::trace::Trace;
use crate::{connect, record, report, text, viewer};

/// What is going to be run.
struct Plan {
    world: String,
    scenario: Arc<Scenario>,
    assignments: Vec<Assignment>,
    pace: Pace,
    /// Seed of the brains.
    seed: u64,
    /// How long a frame of the recording is, if brains are to publish as often.
    frame: Option<Duration>,
    note: Option<String>,
}

pub(crate) async fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    let plan = Plan::new(args)?;
    let quiet = args.quiet;
    if let Some(note) = plan.note.as_ref().filter(|_| !quiet) {
        tell!("{note}");
    }
    let monitor = Arc::new(Monitor::default());
    let (on_tick, files) = hook(args, &plan, Arc::clone(&monitor))?;
    // A FIFO may have kept us waiting until here; there a single signal is to end the program.
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    let server = serve(args, &plan, on_tick).await?;
    let mut run = Running { plan: &plan, server: &server, monitor, files, interrupted: false };
    let status = run.until_over(&mut stop, quiet).await;
    let (interrupted, files) = (run.interrupted, run.files);
    if tokio::time::timeout(PATIENCE, server.shutdown()).await.is_err() {
        tell!("note: a client kept its connection open; it was closed");
    }
    // The world's thread has closed the files, or will at once.
    let status = files.finish().await.and(status)?;
    let summary = Summary::new(&plan.scenario, &status, interrupted, &plan.assignments);
    show(args, &summary)?;
    let unwritten = summary.recording.as_ref().and_then(|recording| recording.problem.as_ref());
    if let Some(problem) = unwritten {
        let file = args.record.record.clone().unwrap_or_default();
        return Err(anyhow!("the recording {} has ended before the run: {problem}", file.display()));
    }
    Ok(if summary.interrupted { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
}

fn show(args: &RunArgs, summary: &Summary) -> anyhow::Result<()> {
    if args.json {
        return text::print_json(summary);
    }
    if args.quiet {
        return Ok(());
    }
    if [&args.csv, &args.timeline].into_iter().flatten().any(|path| path == Path::new(STDOUT)) {
        tell!("{}", report::text(summary).trim_end());
        return Ok(());
    }
    text::print(&report::text(summary))
}

impl Plan {
    fn new(args: &RunArgs) -> anyhow::Result<Self> {
        check_outputs(args)?;
        let pace = args.watchdog.apply(args.pace.pace())?;
        let source = Source::find(args.scenario.as_deref().unwrap_or(scenarios::DEFAULT))?;
        let mut overrides = overrides(&args.changes)?;
        let mut scenario = source.parse(&overrides)?;
        let mut note = None;
        let end = &scenario.end;
        let seconds = args.seconds.map(|seconds| ("--seconds", seconds));
        let limit = seconds.or_else(|| args.ticks.map(|n| ("--ticks", after_s(n, scenario.step_ns))));
        if let Some((option, after_s)) = limit {
            overrides.push(scenarios::set("end.after_s", format_args!("{after_s:?}")));
            let limited = source.parse(&overrides);
            scenario = limited.map_err(|error| Refused::error(format!("{option}: {error}")))?;
        } else if end.after.is_none() && end.goal.is_none() && !scenario.rules.end_runs() {
            overrides.push(scenarios::set("end.after_s", format_args!("{DEFAULT_SECONDS:?}")));
            scenario = source.parse(&overrides)?;
            let text =
                || format!("note: {} sets no end; this run ends after {DEFAULT_SECONDS} s", source.label());
            note = args.scenario.is_some().then(text);
        }
        scenarios::warn(&scenario);
        let assignments = assignment::assign(&args.brains, &scenario.robots)?;
        assignments.iter().try_for_each(|assignment| assignment::check_name(&assignment.brain))?;
        let (world, seed) = (source.world_name(&scenario), scenario.seed);
        let frame = record::short_frame(&args.record, scenario.step_ns);
        Ok(Self { world, scenario: scenario.into(), assignments, pace, seed, frame, note })
    }

    /// How many ticks the run has, if its time is limited.
    fn ticks(&self) -> Option<u64> {
        let after = self.scenario.end.after?;
        Some(after.as_ns().div_ceil(self.scenario.step_ns).max(1))
    }
}

/// Refuses outputs that would be written into each other.
fn check_outputs(args: &RunArgs) -> anyhow::Result<()> {
    let stdout = Some(Path::new(STDOUT));
    let (csv, timeline) = (args.csv.as_deref(), args.timeline.as_deref());
    if args.json && csv == stdout {
        return Err(Refused::error("--json and --csv - both want stdout; write the table to a file"));
    }
    if timeline == stdout && (args.json || csv == timeline) {
        return Err(Refused::error("--timeline - wants stdout for itself; write the trace to a file"));
    }
    let files = [("--csv", csv), ("--timeline", timeline), ("--record", args.record.record.as_deref())];
    output_files::check_apart(files.into_iter().filter_map(|(option, path)| Some((option, path?))))
}

/// The overrides that the arguments ask for.
pub(crate) fn overrides(changes: &ChangeArgs) -> anyhow::Result<Vec<Override>> {
    let mut overrides = scenarios::parse_sets(&changes.sets)?;
    overrides.extend(changes.seed.map(|seed| scenarios::set("seed", seed)));
    overrides.extend(changes.no_noise.then(|| scenarios::set("noise", false)));
    Ok(overrides)
}

/// A run ends at the first tick that is not before `end.after_s`. Half a tick early is after exactly `ticks`
/// of them, however the number is rounded on its way.
fn after_s(ticks: u64, step_ns: u64) -> f64 {
    (ticks as f64 - 0.5) * step_ns as f64 * 1e-9
}

async fn serve(args: &RunArgs, plan: &Plan, on_tick: OnTick) -> anyhow::Result<Server> {
    // It stands until its brains are there.
    let world = WorldConfig::new(plan.world.clone(), Arc::clone(&plan.scenario)).pace(plan.pace).paused(true);
    let world = record::add(world.on_tick(on_tick), &args.record);
    let mut builder = args.listen.builder().world(world);
    for address in &args.listen.listen {
        builder = builder.listen(address.clone());
    }
    // What is over in a moment nobody can look at.
    builder = viewer::add(builder, args.listen.viewer, matches!(plan.pace, Pace::Timed(_)));
    let server = builder.serve().await.map_err(from_builder)?;
    if !args.quiet {
        server.addresses().iter().for_each(|address| tell!("listening on {address}"));
        viewer::link(&server).iter().for_each(|link| tell!("{link}"));
    }
    Ok(server)
}

/// What the world's thread tells the rest of the program.
#[derive(Default)]
struct Monitor {
    tick: AtomicU64,
    ended: Notify,
}

/// The world's thread's end of a monitor. When that thread is over, because an operator deleted the world,
/// so is the run.
struct Telling(Arc<Monitor>);

impl Drop for Telling {
    fn drop(&mut self) {
        self.0.ended.notify_one();
    }
}

fn hook(args: &RunArgs, plan: &Plan, monitor: Arc<Monitor>) -> anyhow::Result<(OnTick, Files)> {
    let mut files = Files::default();
    let robots = &plan.scenario.robots;
    let mut table = None;
    if let Some(path) = &args.csv {
        let is_stdout = path == Path::new(STDOUT);
        let name = if is_stdout { "the table to stdout".into() } else { path.display().to_string() };
        let out = output_files::open(path).with_context(|| format!("cannot write {name}"))?;
        let (made, outcome) = Table::new(out, robots);
        files.watch(name, outcome);
        table = Some(made);
    }
    let mut trace = None;
    if let Some(path) = &args.timeline {
        let out = output_files::open(path).with_context(|| format!("cannot write {}", path.display()))?;
        let (made, outcome) = Trace::new(out, &plan.world, robots.len());
        files.watch(path.display().to_string(), outcome);
        trace = Some(made);
    }
    let monitor = Telling(monitor);
    let on_tick = move |world: &World| {
        if let Some(table) = &mut table {
            table.write(world);
        }
        if let Some(trace) = &mut trace {
            trace.write(world);
        }
        monitor.0.tick.store(world.tick(), Ordering::Relaxed);
        if world.ending().is_some() {
            monitor.0.ended.notify_one();
        }
    };
    Ok((Box::new(on_tick), files))
}

struct Running<'a> {
    plan: &'a Plan,
    server: &'a Server,
    monitor: Arc<Monitor>,
    files: Files,
    interrupted: bool,
}

impl Running<'_> {
    /// Lets the brains drive until the run is over, and says how the world then is.
    async fn until_over(&mut self, stop: &mut Stop, quiet: bool) -> anyhow::Result<v1::WorldStatus> {
        let channel = self.server.channel().await?;
        let mut control = connect::control(channel.clone());
        let mut brains = JoinSet::new();
        for assignment in &self.plan.assignments {
            let client = record::publishing(Client::from_channel(channel.clone()), self.plan.frame);
            let mut attached =
                AttachedBrains::attach(client, &self.plan.world, assignment.clone(), self.plan.seed).await?;
            // They hold their robots until all is over.
            brains.spawn(async move { attached.run(|| ()).await.map(|_| attached) });
        }
        let world = self.plan.world.clone();
        control.start_world(v1::StartWorldRequest { world }).await.map_err(|status| from_server(&status))?;
        let bar = progress(self.plan.ticks(), quiet);
        // Who is done holds its robots, too, until the status is there: what it said goes with it.
        let mut done = Vec::new();
        let waited = self.wait(stop, &mut brains, &mut done, &bar).await;
        bar.finish_and_clear();
        waited?;
        let status = self.pause(control).await?;
        if status.recording.is_none() {
            return Ok(status);
        }
        // A tick that was under way may have ended since the pause: what is told is what the recording ends with.
        let closed = self.server.stop_recording(&self.plan.world).await;
        closed.map_err(|status| from_server(&status))
    }

    /// The world's last state; a run that has ended is not changed by a pause.
    async fn pause(&self, mut control: ControlServiceClient<Channel>) -> anyhow::Result<v1::WorldStatus> {
        let request = v1::PauseWorldRequest { world: self.plan.world.clone() };
        let answer = control.pause_world(request).await.map_err(|status| from_server(&status))?;
        answer.into_inner().status.ok_or_else(|| anyhow!("the server answered without a status"))
    }

    async fn wait(
        &mut self,
        stop: &mut Stop,
        brains: &mut JoinSet<anyhow::Result<AttachedBrains>>,
        done: &mut Vec<AttachedBrains>,
        bar: &ProgressBar,
    ) -> anyhow::Result<()> {
        let mut redraw = tokio::time::interval(REDRAW);
        loop {
            tokio::select! {
                () = self.monitor.ended.notified() => return Ok(()),
                () = stop.wait() => {
                    self.interrupted = true;
                    return Ok(());
                }
                error = self.files.failure() => return Err(error),
                Some(brain) = brains.join_next() => done.push(brain.context("a brain panicked")??),
                _ = redraw.tick() => bar.set_position(self.monitor.tick.load(Ordering::Relaxed)),
            }
        }
    }
}

/// A bar for so many ticks, for people who look; none otherwise.
pub(crate) fn progress(ticks: Option<u64>, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(ticks, ProgressDrawTarget::stderr());
    let template = match ticks {
        Some(_) => "{bar:40} {pos}/{len} ticks, {eta} to go",
        None => "{spinner} {pos} ticks in {elapsed}",
    };
    bar.with_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// How long a run is whose scenario does not say.
const DEFAULT_SECONDS: f64 = 60.0;

const REDRAW: Duration = Duration::from_millis(100);

/// How long connections have to close.
const PATIENCE: Duration = Duration::from_secs(3);

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[test]
    fn so_many_ticks_are_so_many_ticks_whatever_the_step() {
        for step in [10.0, 0.01, 0.07, 3.3, 1000.0] {
            for ticks in [1, 2, 3, 7, 1_000_003] {
                let step_ns = baudbot_scenario::parse(&format!("step_ms = {step:?}")).unwrap().step_ns;
                let toml = format!("step_ms = {step:?}\nend.after_s = {:?}", after_s(ticks, step_ns));
                let after = baudbot_scenario::parse(&toml).unwrap().end.after.unwrap();
                assert_eq!(after.as_ns().div_ceil(step_ns), ticks, "{ticks} of {step} ms");
            }
        }
    }

    #[test]
    fn a_table_and_a_trace_do_not_go_into_one_file() {
        let folder = std::env::temp_dir().join(format!("baudbot-run-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let folder = folder.display();
        let check = |csv: &str, timeline: &str| {
            #[derive(clap::Parser)]
            struct Parsed {
                #[command(flatten)]
                run: RunArgs,
            }
            let parsed = Parsed::try_parse_from(["run", "--csv", csv, "--timeline", timeline]).unwrap();
            check_outputs(&parsed.run).map_err(|error| error.to_string())
        };
        let file = format!("{folder}/out");
        for other in [file.clone(), format!("{folder}/./out"), format!("{folder}/../{}/out", name(&file))] {
            let error = check(&file, &other).unwrap_err();
            assert_eq!(
                error,
                format!(
                    "--csv {file} and --timeline {other} are the same file; write each to a file of its own"
                )
            );
        }
        assert_eq!(check(&file, &format!("{file}2")), Ok(()));
        // Also if one is only another name of the other.
        std::fs::write(&file, "").unwrap();
        let link = format!("{folder}/link");
        let _ = std::fs::remove_file(&link);
        std::os::unix::fs::symlink(&file, &link).unwrap();
        assert!(check(&file, &link).unwrap_err().contains("same file"));
    }

    /// The name of the folder that a file is in.
    fn name(file: &str) -> &str {
        Path::new(file).parent().and_then(Path::file_name).and_then(|name| name.to_str()).unwrap()
    }
}
