//! `baudbot run`: a world and its brains in one process, until the run ends.
//!
//! `direct` has both on one thread; `served` lets the brains attach to a server, as brains in other processes do. Both give the
//! same run.

mod direct;
mod required;
mod served;

use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use anyhow::{Context, anyhow};
use baudbot_experiment::requirement::Judge;
use baudbot_run::programs::{Output, PROGRAM};
use baudbot_run::simulation::Progress;
use baudbot_scenario::Override;
use baudbot_server::{OnTick, Pace, WorldConfig};
use baudbot_sim::{Scenario, SimTime, World};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::args::{ChangeArgs, ChipOutput, Over, RunArgs};
use crate::assignment::{self, Assigned};
use crate::chips::{self, SERIAL, VCD};
use crate::csv::Table;
use crate::error::Refused;
use crate::gdb::Debuggers;
use crate::output_files::{self, Files, Inputs, STDOUT};
use crate::scenarios::{self, Source};
use crate::serial::tails::Tails;
use crate::serial::{self, Transcript};
use crate::signals::{INTERRUPTED, Stop};
use crate::summary::Summary;
use crate::text::tell;
use crate::trace::Trace;
use crate::vcd::Dump;
use crate::{ports, record, report, text};

/// The plan of a run.
struct Plan {
    world: String,
    scenario: Arc<Scenario>,
    assigned: Assigned,
    pace: Pace,
    over: Over,
    /// Seed of the brains.
    seed: u64,
    /// The length of a frame of the recording, if brains are to publish as often.
    frame: Option<Duration>,
    note: Option<String>,
    /// The robots of `--vcd`.
    analysed: Vec<usize>,
    /// Those of `--serial`.
    heard: Vec<usize>,
    /// The last bytes of the chips.
    tails: Tails,
}

/// The files that a run writes, and the signals that it hears.
struct Outside<'a> {
    args: &'a RunArgs,
    files: Files,
    debuggers: Debuggers,
    stop: Stop,
    interrupted: bool,
    /// Lines that the programs of brains have printed, and nobody has seen.
    unseen_lines: u64,
    /// The programs in simulated time at the end.
    programs: Vec<Progress>,
}

pub(crate) async fn run(args: &RunArgs) -> anyhow::Result<ExitCode> {
    let plan = Plan::new(args)?;
    if let Some(note) = plan.note.as_ref().filter(|_| !args.quiet) {
        tell!("{note}");
    }
    let judge = Arc::new(Mutex::new(Judge::new(args.requirements.clone())));
    let (on_tick, files) = hook(args, &plan)?;
    let on_tick = required::judged(args, on_tick, &judge);
    // A FIFO may have kept us waiting until here; there a single signal is to end the program.
    let stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    let debuggers =
        Debuggers::listen(&args.chips.gdb, &plan.scenario, ports::reach(args.listen.access.open), &stop)?;
    if !args.quiet {
        debuggers.tell(&plan.scenario);
    }
    let mut outside =
        Outside { args, files, debuggers, stop, interrupted: false, unseen_lines: 0, programs: Vec::new() };
    let status = match plan.over {
        Over::Direct => direct::run(&plan, on_tick, &mut outside).await,
        Over::Grpc => served::run(&plan, on_tick, &mut outside).await,
    };
    // The world has closed the files, or its thread will at once.
    let status = outside.files.finish().await.and(status)?;
    let mut summary = Summary::new(&plan.scenario, &status, outside.interrupted, &plan.assigned, plan.over);
    summary.add_last_lines(|robot| plan.tails.last_line(robot));
    summary.unseen_lines = outside.unseen_lines;
    summary.add_programs(&outside.programs, &plan.assigned);
    required::add(&mut summary, &judge)?;
    show(args, &summary)?;
    let unwritten = summary.recording.as_ref().and_then(|recording| recording.problem.as_ref());
    if let Some(problem) = unwritten {
        let file = args.record.record.clone().unwrap_or_default();
        return Err(anyhow!("the recording {} ended before the run: {problem}", file.display()));
    }
    Ok(match summary.interrupted {
        true => ExitCode::from(INTERRUPTED),
        false if summary.requirements.iter().any(|required| !required.holds) => ExitCode::FAILURE,
        false => ExitCode::SUCCESS,
    })
}

fn show(args: &RunArgs, summary: &Summary) -> anyhow::Result<()> {
    if args.json {
        return text::print_json(summary);
    }
    if args.quiet {
        return Ok(());
    }
    let files = [&args.csv, &args.timeline].into_iter().flatten();
    let of_chips = args.chips.vcd.iter().chain(&args.chips.serial).map(|output| &output.file);
    if files.chain(of_chips).any(|path| path == Path::new(STDOUT)) {
        tell!("{}", report::text(summary).trim_end());
        return Ok(());
    }
    text::print(&report::text(summary))
}

impl Plan {
    fn new(args: &RunArgs) -> anyhow::Result<Self> {
        check_outputs(args)?;
        let pace = args.watchdog.apply(args.pace.pace())?;
        let over = args.over()?;
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
        scenarios::warn(&source, &scenario);
        let mut assigned = assigned(args, &scenario, &source.shown_brains())?;
        assignment::set_parameters(&mut assigned, &args.parameters)?;
        suit_programs(args, over, &mut assigned)?;
        assignment::state_writes(&assigned, &mut scenario)?;
        let (world, seed) = (source.world_name(&scenario), scenario.seed);
        let frame = record::short_frame(&args.record, scenario.step_ns);
        let analysed = VCD.robots(&args.chips.vcd, &scenario.robots)?;
        let heard = SERIAL.robots(&args.chips.serial, &scenario.robots)?;
        let tails = Tails::new(&scenario.robots);
        let scenario = Arc::new(scenario);
        Ok(Self { world, scenario, assigned, pace, over, seed, frame, note, analysed, heard, tails })
    }

    /// The world, which stands until its brains are there.
    fn world(&self, outside: &Outside<'_>, on_tick: Option<OnTick>) -> WorldConfig {
        let args = outside.args;
        let mut world = World::new(Arc::clone(&self.scenario));
        outside.debuggers.put_on(&mut world);
        if self.over == Over::Direct && args.timeline.is_none() {
            // Nobody looks at it.
            world.keep_timeline(0);
        }
        for robot in 0..self.scenario.robots.len() {
            world.keep_rounds(robot, true);
        }
        for &robot in &self.analysed {
            world.keep_edges(robot, true);
        }
        for robot in chips::all(&self.scenario.robots) {
            world.keep_tape(robot, serial::MOST_BYTES);
            if args.timeline.is_some() {
                world.keep_edges(robot, true);
            }
        }
        let world = WorldConfig::from_state(self.world.clone(), world);
        let world = record::add(world.pace(self.pace).paused(true), &args.record);
        match on_tick {
            Some(on_tick) => world.on_tick(on_tick),
            None => world,
        }
    }

    /// The number of ticks of the run, if its time is limited.
    fn ticks(&self) -> Option<u64> {
        let after = self.scenario.end.after?;
        Some(after.as_ns().div_ceil(self.scenario.step_ns).max(1))
    }
}

/// Whether programs can be on this path, and where their output goes.
fn suit_programs(args: &RunArgs, over: Over, assigned: &mut Assigned) -> anyhow::Result<()> {
    if over == Over::Grpc
        && let Some(task) = assigned.at_ports.first()
    {
        return Err(Refused::error(format!(
            "{PROGRAM}{}: a program in simulated time is on the thread of its world, and what needs a server is not: other \
             programs (exec:), viewers, real time; leave out one of the two",
            task.program
        )));
    }
    if args.show_output {
        if assigned.programs.is_empty() && assigned.at_ports.is_empty() {
            return Err(Refused::error("--show-output: no brain is a program (--brain 'exec:…')"));
        }
        assigned.programs.iter_mut().for_each(|task| task.output = Output::Shown);
        assigned.at_ports.iter_mut().for_each(|task| task.output = Output::Shown);
    }
    Ok(())
}

/// The assignment of the robots; with `--external` those that no brain is named for are left to others.
fn assigned(args: &RunArgs, scenario: &Scenario, shown: &[&str]) -> anyhow::Result<Assigned> {
    let Some(external) = args.external else {
        return assignment::assign(&args.brains, &scenario.robots, shown);
    };
    let mut brains = args.brains.clone();
    if !brains.iter().any(|brain| assignment::is_for_all(brain)) {
        brains.push(assignment::NONE.to_owned());
    }
    let assigned = assignment::assign(&brains, &scenario.robots, shown)?;
    let free = scenario.robots.iter().filter(|spec| assigned.brain_of(&spec.name).is_none()).count();
    if free < external.into() {
        return Err(Refused::error(format!(
            "--external {external}: {} without a --brain; name fewer robots with --brain, or ask for fewer",
            if free == 1 { "1 robot is".to_owned() } else { format!("{free} robots are") }
        )));
    }
    Ok(assigned)
}

/// Refuses outputs that would be written into each other, or over what is read.
fn check_outputs(args: &RunArgs) -> anyhow::Result<()> {
    let stdout = Some(Path::new(STDOUT));
    let (csv, timeline) = (args.csv.as_deref(), args.timeline.as_deref());
    if !args.chips.gdb.is_empty() && args.record.record.is_some() {
        return Err(Refused::error(
            "--gdb and --record exclude each other: a run in which a debugger writes into a chip cannot be replayed; leave \
             out one of the two",
        ));
    }
    if args.json && csv == stdout {
        return Err(Refused::error("--json and --csv - both write to stdout; write the table to a file"));
    }
    if timeline == stdout && (args.json || csv == timeline) {
        return Err(Refused::error("--timeline - needs stdout for itself; write the trace to a file"));
    }
    let vcd = args.chips.vcd.iter().map(|output| ("--vcd", "the pins", output.file.as_path()));
    let serial = args.chips.serial.iter().map(|output| ("--serial", "the bytes", output.file.as_path()));
    let of_chips: Vec<_> = vcd.chain(serial).collect();
    let mut to_stdout = of_chips.iter().filter(|(.., path)| Some(*path) == stdout);
    let is_wanted = args.json || [csv, timeline].contains(&stdout);
    if let Some((option, what, _)) = to_stdout.next()
        && (is_wanted || to_stdout.next().is_some())
    {
        return Err(Refused::error(format!(
            "{option} ROBOT=- needs stdout for itself; write {what} to a file"
        )));
    }
    let (record, audit) = (args.record.record.as_deref(), args.listen.access.audit.as_deref());
    let files = [("--csv", csv), ("--timeline", timeline), ("--record", record), ("--audit", audit)];
    let files = files.into_iter().filter_map(|(option, path)| Some((option, path?)));
    let files: Vec<_> = files.chain(of_chips.iter().map(|&(option, _, path)| (option, path))).collect();
    output_files::check_apart(files.iter().copied())?;
    let inputs = Inputs::of(args.scenario.as_deref().unwrap_or(scenarios::DEFAULT), &args.changes);
    inputs.brains(&args.brains).check(files.into_iter())
}

/// The overrides that the arguments ask for.
pub(crate) fn overrides(changes: &ChangeArgs) -> anyhow::Result<Vec<Override>> {
    let mut overrides = scenarios::parse_sets(&changes.sets)?;
    for firmware in &changes.firmware {
        overrides.push(scenarios::firmware(firmware)?);
    }
    overrides.extend(changes.seed.map(|seed| scenarios::set("seed", seed)));
    overrides.extend(changes.no_noise.then(|| scenarios::set("noise", false)));
    Ok(overrides)
}

/// A run ends at the first tick that is not before `end.after_s`. Half a tick early is after exactly `ticks`
/// of them, however the number is rounded on its way.
fn after_s(ticks: u64, step_ns: u64) -> f64 {
    (ticks as f64 - 0.5) * step_ns as f64 * 1e-9
}

/// The hook that writes the files at each tick, if any are asked for, and its progress.
fn hook(args: &RunArgs, plan: &Plan) -> anyhow::Result<(Option<OnTick>, Files)> {
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
    let mut dumps = dumps(args, plan, &mut files)?;
    let mut transcripts = transcripts(args, plan, &mut files)?;
    let tails = plan.tails.clone();
    if table.is_none() && trace.is_none() && tails.is_empty() {
        // Only chips have pins, and send.
        return Ok((None, files));
    }
    let on_tick = move |world: &World| {
        if let Some(table) = &mut table {
            table.write(world);
        }
        if let Some(trace) = &mut trace {
            trace.write(world);
        }
        dumps.iter_mut().for_each(|dump| dump.write(world));
        transcripts.iter_mut().for_each(|transcript| transcript.write(world));
        tails.look(world);
    };
    Ok((Some(Box::new(on_tick)), files))
}

/// The dumps of the pins of chips.
fn dumps(args: &RunArgs, plan: &Plan, files: &mut Files) -> anyhow::Result<Vec<Dump>> {
    let mut dumps = Vec::new();
    for (ChipOutput { file: path, .. }, &robot) in args.chips.vcd.iter().zip(&plan.analysed) {
        let out = output_files::open(path).with_context(|| format!("cannot write {}", path.display()))?;
        let (made, outcome) = Dump::new(out, (robot, &plan.scenario.robots[robot]), SimTime::ZERO);
        files.watch(path.display().to_string(), outcome);
        dumps.push(made);
    }
    Ok(dumps)
}

/// The transcripts of chips' bytes.
fn transcripts(args: &RunArgs, plan: &Plan, files: &mut Files) -> anyhow::Result<Vec<Transcript>> {
    let mut transcripts = Vec::new();
    for (ChipOutput { file: path, .. }, &robot) in args.chips.serial.iter().zip(&plan.heard) {
        let out = output_files::open(path).with_context(|| format!("cannot write {}", path.display()))?;
        let name = &plan.scenario.robots[robot].name;
        let (made, outcome) = Transcript::new(out, (robot, name), SimTime::ZERO);
        files.watch(path.display().to_string(), outcome);
        transcripts.push(made);
    }
    Ok(transcripts)
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

/// The length of a run whose scenario does not say.
const DEFAULT_SECONDS: f64 = 60.0;

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
