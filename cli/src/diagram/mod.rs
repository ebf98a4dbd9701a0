//! `baudbot diagram`: the events of a run and their times, as the timing diagram of the lecture notes (Fig. 3.2).
//!
//! From the command inwards:
//!
//! This file is the command. `source` is the scenario or the recording. `record` finds the part of a run that is wanted
//! (`begins` by default, of a run of a program of the user's own), and runs a world for it, whose `ticks` are done in
//! this thread or, if a brain is a program, on a server of its own; `cycle` finds a control cycle among the events;
//! `meaning` knows what was said in those on cables, `pins` what is on the pins of a chip, and `parts` what that makes
//! lamps, buzzers and servos do; `table` writes all that as text, and [`baudbot_plot::timing`] draws it.

mod begins;
mod cycle;
#[cfg(test)]
mod demo;
mod meaning;
mod parts;
mod pins;
mod record;
mod source;
mod table;
#[cfg(test)]
mod tests;
mod ticks;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use baudbot_plot::quantity::duration;
use baudbot_plot::timing::{self, Diagram, Group, Lane, Mark};
use baudbot_sim::chip::Net;
use baudbot_sim::model::RobotSpec;

use self::begins::Begins;
use self::record::{Kept, Place, Wanted, Window};
use self::source::Run;
use self::ticks::View;
use crate::args::DiagramArgs;
use crate::error::Refused;
use crate::signals::INTERRUPTED;
use crate::{text, work};

pub(crate) async fn diagram(args: DiagramArgs) -> anyhow::Result<ExitCode> {
    let (svg, csv) = (args.svg.as_deref(), args.csv.as_deref());
    let outputs = [("--svg", svg), ("--csv", csv)].into_iter();
    source::inputs(&args).check(outputs.filter_map(|(option, path)| Some((option, path?))))?;
    work::until_stopped(move |stop| show(&args, stop)).await
}

fn show(args: &DiagramArgs, stop: &AtomicBool) -> anyhow::Result<ExitCode> {
    let run = Run::find(args)?;
    let (scenario, step_ns) = (&run.scenario, run.scenario.step_ns);
    let place = place(args.robot.as_deref(), &scenario.robots)?;
    let robot = &scenario.robots[place];
    let chosen = pins::chosen(robot, &args.pins)?;
    let ticks = |view| run.ticks(place, view, stop);
    let (wanted, begins) = match &robot.chip {
        Some(chip) if args.at.is_none() && args.cycle.is_none() => {
            let begins = Begins::find(robot, chip, ticks(View::Edges)?)?;
            let span_ns = span_ns(args).unwrap_or_else(|| begins::span_ns(step_ns));
            let place = Place::At(begins.window_ns(span_ns));
            (Wanted { place, span_ns: Some(span_ns) }, Some(begins))
        }
        _ => (wanted(args, robot)?, None),
    };
    // A table for other programs has each edge.
    let finest_ns = if args.csv.is_some() { 0 } else { timing::finest_ns(wanted.span(step_ns)) };
    let kept = wanted.record(robot, step_ns, ticks(View::Signals(finest_ns))?);
    if stop.load(Ordering::Relaxed) {
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let kept = kept?;
    let window = wanted.window(robot, &kept, step_ns);
    let meanings = meaning::meanings(&kept.events, &kept.said);
    let write = |path: &Path, written: &str| text::write(path, written);
    let rows = || table::rows(robot, (&kept, chosen.as_deref()), &window, &meanings);
    let shown = match (&args.svg, &args.csv) {
        (Some(path), _) => {
            let shown = (&kept, chosen.as_deref(), &meanings);
            let mut picture = picture(&run.name, (step_ns, robot), shown, &window);
            picture.ran.extend(begins.as_ref().map(Begins::in_words));
            picture.ran.extend(run.facts(robot));
            write(path, &picture.draw())
        }
        (None, Some(path)) => write(path, &table::csv(&rows())?),
        (None, None) => text::print(&table::text(&rows())),
    };
    shown.map(|()| ExitCode::SUCCESS)
}

/// The place of the robot that is asked for.
fn place(name: Option<&str>, robots: &[RobotSpec]) -> anyhow::Result<usize> {
    let names = || robots.iter().map(|robot| robot.name.as_str()).collect::<Vec<_>>().join(", ");
    match name {
        Some(name) => robots.iter().position(|robot| robot.name == name).ok_or_else(|| {
            Refused::error(format!("--robot: there is no robot `{name}`; there are: {}", names()))
        }),
        None if robots.is_empty() => Err(Refused::error("there is no robot to make a diagram of")),
        None => Ok(0),
    }
}

fn wanted(args: &DiagramArgs, robot: &RobotSpec) -> anyhow::Result<Wanted> {
    let place = match (args.at, args.cycle) {
        (Some(at_s), _) => Place::At((at_s * 1e9).round() as u64),
        (None, Some(_)) if robot.chip.is_some() => {
            return Err(Refused::error(format!(
                "--cycle: `{}` runs a program of its own, whose control cycles are not known; --at S shows any part of \
                 the run",
                robot.name
            )));
        }
        (None, Some(number)) => Place::Cycle(number),
        (None, None) => Place::Usual,
    };
    Ok(Wanted { place, span_ns: span_ns(args) })
}

/// The length of the window that is asked for, in nanoseconds.
fn span_ns(args: &DiagramArgs) -> Option<u64> {
    args.span.map(|ms| (ms * 1e6).round().max(1.0) as u64)
}

/// The diagram of a part of a robot's run.
fn picture(
    world: &str,
    (step_ns, robot): (u64, &RobotSpec),
    (kept, chosen, meanings): (&Kept, Option<&[Net]>, &BTreeMap<usize, String>),
    window: &Window,
) -> Diagram {
    let Window { from_ns, until_ns, cycle } = window;
    let events = &kept.events[..];
    let of_cycle = cycle.as_ref().map(|cycle| &cycle.events);
    let late_from_ns = cycle.as_ref().map(|cycle| cycle.late_from_ns(robot));
    let late_from_ns =
        late_from_ns.filter(|late| cycle.as_ref().is_some_and(|it| it.end(events).as_ns() > *late));
    let span = (*from_ns, *until_ns);
    let lanes = timing::lanes(robot, events, span, of_cycle, meanings);
    let pins = timing::pin_lanes(&kept.pins.shots, span, chosen);
    let lanes = if robot.chip.is_some() { with_pins(lanes, pins) } else { lanes };
    let mut picture = Diagram::of_run(&robot.name, world, lanes, span, step_ns);
    match cycle {
        None if robot.chip.is_some() => {
            let step = duration(step_ns as f64);
            picture.subtitle = format!("Events on the pins of the chip and around it. Δt = {step}.");
        }
        None => {}
        Some(cycle) => {
            picture.title += &format!(": control cycle {}", cycle.number);
            (picture.subtitle, picture.marks) = about(cycle, late_from_ns, robot);
            picture.late_from_ns = late_from_ns;
        }
    }
    picture
}

/// The lanes of a robot with a chip: those on which something is, and those of its pins behind the sensors'.
fn with_pins(lanes: Vec<Lane>, pins: Vec<Lane>) -> Vec<Lane> {
    let there =
        lanes.into_iter().filter(|lane| !lane.bars.is_empty() && lane.group != Group::Microcontroller);
    let (mut all, rest): (Vec<_>, Vec<_>) = there.partition(|lane| lane.group == Group::Sensors);
    all.extend(pins);
    all.extend(rest);
    all
}

/// The description of a cycle, and its marks.
fn about(cycle: &cycle::Cycle, late_from_ns: Option<u64>, robot: &RobotSpec) -> (String, Vec<Mark>) {
    let mark = |at_ns, label: &str| Mark { at_ns, label: label.to_owned() };
    let within_ns = robot.deadline.within_ns;
    let deadline = if robot.deadline.on_late.is_some() { "deadline" } else { "Δt" };
    let mut marks = vec![mark(cycle.begun.as_ns(), "cycle begins")];
    marks.extend(late_from_ns.map(|at_ns| mark(at_ns, "late")));
    let told = match cycle.obeyed {
        None => "No command answered this cycle's message. Other cycles are pale.".to_owned(),
        Some(obeyed) => {
            let ns = obeyed.since(cycle.begun);
            marks.push(mark(obeyed.as_ns(), "obeyed"));
            let verdict = if ns > within_ns { "longer than" } else { "within" };
            format!(
                "Reading, transfer, thinking and obeying take {}: {verdict} the {deadline} of {}. Other cycles are pale.",
                duration(ns as f64),
                duration(within_ns as f64)
            )
        }
    };
    (told, marks)
}
