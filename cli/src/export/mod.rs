//! `baudbot export`: what can be made of a recording.
//!
//! 1. This file sees what is wanted, and that no output goes into another one or into the recording.
//! 2. [`pass`] simulates the run once more, a [`window`] of it, and shows every tick to all outputs at once: those of
//!    `baudbot run` ([`watched`]), `rows` of Parquet, a bag of ROS ([`rosbag`]), [`events`], [`trails`] for a picture, the pins of chips ([`vcd`]) and what they sent ([`serial`]), and
//!    [`beliefs`], which are in the recording's frames.
//!    [`ran`] has the text of pictures about the run.
//! 3. [`film`] lets a [`browser`] film the viewer's page, which replays the recording.
//! 4. [`summary`] describes a recording if no output is requested.

mod beliefs;
mod browser;
mod events;
mod film;
mod pass;
mod ran;
mod rosbag;
#[cfg(feature = "parquet")]
mod rows;
mod summary;
mod trails;
mod watched;
mod window;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use baudbot_recording::{self as recording, RecordedRun, Replay};
use baudbot_sim::World;

use crate::args::ExportArgs;
use crate::chips::{self, SERIAL, VCD};
use crate::csv::Table;
use crate::error::Refused;
use crate::output_files::{self, Inputs, STDOUT};
use crate::replay::{recorded_run, refused};
use crate::serial::{self, Transcript};
use crate::signals::{INTERRUPTED, Stop};
use crate::text::tell;
use crate::trace::Trace;
use crate::vcd::Dump;
use pass::{Output, Sink};
pub(crate) use rosbag::ends_meet;
use watched::Watched;
use window::Window;

pub(crate) async fn export(args: &ExportArgs) -> anyhow::Result<ExitCode> {
    check(args)?;
    let recorded = Arc::new(recorded_run(&args.file).map_err(|error| refused(&args.file, &error))?);
    if args.outputs().next().is_none() {
        summary::show(&args.file, &recorded, args.json)?;
        return Ok(ExitCode::SUCCESS);
    }
    let window = Window::new(&recorded, &args.window)?;
    if args.rosbag2.is_some() {
        rosbag::check_names(&recorded.scenario().robots)?;
    }
    if !args.quiet {
        notes(args, &recorded);
    }
    let mut films = film::Films::new(args, &recorded, &window)?;
    let mut outputs = outputs(args, &recorded, &window)?;
    // A FIFO may have kept us waiting until here; there a single signal is to end the program.
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    let mut is_whole = true;
    if !outputs.is_empty() || args.rosbag2.is_some() {
        let robots = &recorded.scenario().robots;
        let (mut pins, cables) = (VCD.robots(&args.vcd, robots)?, SERIAL.robots(&args.serial, robots)?);
        if args.timeline.is_some() {
            pins.extend(chips::all(robots));
        }
        let replay = start(
            &args.file,
            &recorded,
            recording::Watched { pins, cables, bytes: serial::MOST_BYTES, starts: false },
        )?;
        outputs.extend(bag(args, &recorded, &replay.1)?);
        is_whole = pass::run(replay, &window, outputs, &stop, args.quiet)?;
    }
    if is_whole {
        is_whole = films.make(&recorded, &mut stop).await?;
    }
    Ok(if is_whole { ExitCode::SUCCESS } else { ExitCode::from(INTERRUPTED) })
}

/// The recording at its first tick.
fn start(
    path: &Path,
    recorded: &Arc<RecordedRun>,
    watched: recording::Watched,
) -> anyhow::Result<(Replay, World)> {
    Replay::start_watching(Arc::clone(recorded), watched).map_err(|error| refused(path, &error))
}

/// Refuses outputs that would be written into each other, or over the recording.
fn check(args: &ExportArgs) -> anyhow::Result<()> {
    if cfg!(not(feature = "parquet")) && args.parquet.is_some() {
        return Err(Refused::error(
            "--parquet: this program was built without it; cargo build --release --features parquet",
        ));
    }
    let mut to_stdout = args.outputs().filter(|(_, path)| *path == Path::new(STDOUT));
    if args.rosbag2.as_deref() == Some(Path::new(STDOUT)) {
        return Err(Refused::error(
            "--rosbag2 -: a bag is a folder with several files, and cannot go to stdout",
        ));
    }
    if let (Some((one, _)), Some((other, _))) = (to_stdout.next(), to_stdout.next()) {
        return Err(Refused::error(format!(
            "{one} - and {other} - both write to stdout; write one of them to a file"
        )));
    }
    Inputs::default().file("recording", &args.file).check(args.outputs())?;
    output_files::check_apart(args.outputs())
}

fn notes(args: &ExportArgs, recorded: &RecordedRun) {
    let file = args.file.display();
    if let Some(problem) = recorded.problem() {
        let ends = recorded.stretches().iter().map(|stretch| {
            let [from_s, to_s] =
                [stretch.first_tick, stretch.last_tick].map(|tick| window::seconds(recorded, tick));
            format!("{from_s} s to {to_s} s")
        });
        let left = ends.collect::<Vec<_>>().join(", ");
        tell!("note: {file}: {problem}; the part that is left is {left}");
    }
    if let Some(scratch) = recorded.scratch() {
        tell!("note: {file}: {scratch}; the inputs of the run are complete, but frames may be missing");
    }
    let first = recorded.first_tick();
    if first > 0 && args.timeline.is_some() {
        let start_s = window::seconds(recorded, first);
        tell!("note: {file} begins at {start_s} s: the trace does not cover the time before");
    }
}

/// All outputs that are written while the run is simulated.
fn outputs(args: &ExportArgs, recorded: &Arc<RecordedRun>, window: &Window) -> anyhow::Result<Vec<Output>> {
    let robots = &recorded.scenario().robots;
    let every = window::every(&args.rows, recorded.header().step_ns);
    // Before any file is opened: it may be that there is nothing to write.
    let with = beliefs::columns(&args.with, robots)?;
    let beliefs = beliefs::Beliefs::wanted(args, recorded, window)?;
    let (analysed, heard) = (VCD.robots(&args.vcd, robots)?, SERIAL.robots(&args.serial, robots)?);
    let mut outputs = Vec::new();
    let mut add = |path: Option<&PathBuf>, every, make: &dyn Fn(Out) -> Box<dyn Sink>| {
        let Some(path) = path else { return Ok(()) };
        let name = name(path);
        let out = output_files::open(path).with_context(|| format!("cannot write {name}"))?;
        outputs.push(Output { name, every, sink: make(out) });
        anyhow::Ok(())
    };
    add(args.csv.as_ref(), every, &|out| Box::new(Watched::new(Table::new(out, robots), Table::write)))?;
    #[cfg(feature = "parquet")]
    add(args.parquet.as_ref(), every, &|out| Box::new(rows::Rows::new(out, robots)))?;
    add(args.timeline.as_ref(), 1, &|out| {
        let (trace, outcome) = Trace::new(out, &recorded.header().world, robots.len());
        Box::new(Watched::new((trace.since(window.from), outcome), Trace::write))
    })?;
    add(args.events.as_ref(), 1, &|out| Box::new(events::Events::new(out, recorded, window.from)))?;
    add(args.svg.as_ref(), 1, &|out| Box::new(trails::Picture::new(out, recorded)))?;
    add(args.beliefs_csv.as_ref(), 1, &|out| Box::new(beliefs::Table::new(out, &beliefs)))?;
    add(args.utilities_svg.as_ref(), 1, &|out| {
        Box::new(beliefs::Picture::new(out, recorded, &beliefs, &with))
    })?;
    add(args.space_svg.as_ref(), 1, &|out| Box::new(beliefs::Space::new(out, recorded, &beliefs)))?;
    for (output, &robot) in args.vcd.iter().zip(&analysed) {
        add(Some(&output.file), 1, &|out| {
            Box::new(Watched::new(Dump::new(out, (robot, &robots[robot]), window.from), Dump::write))
        })?;
    }
    for (output, &robot) in args.serial.iter().zip(&heard) {
        let made = |out| Transcript::new(out, (robot, &robots[robot].name), window.from);
        add(Some(&output.file), 1, &|out| Box::new(Watched::new(made(out), Transcript::write)))?;
    }
    Ok(outputs)
}

/// The bag of ROS 2, if there is to be one.
fn bag(args: &ExportArgs, recorded: &RecordedRun, world: &World) -> anyhow::Result<Option<Output>> {
    let Some(folder) = &args.rosbag2 else { return Ok(None) };
    let every = window::every(&args.rows, recorded.header().step_ns);
    let sink = Box::new(rosbag::Bag::create(folder, world, every)?);
    Ok(Some(Output { name: folder.display().to_string(), every: 1, sink }))
}

type Out = Box<dyn std::io::Write + Send>;

/// The name of an output in errors.
fn name(path: &Path) -> String {
    if path == Path::new(STDOUT) { "to stdout".to_owned() } else { path.display().to_string() }
}
