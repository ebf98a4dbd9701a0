//! `baudbot diagram`: what happened when, as the timing diagram of the lecture notes (Fig. 3.2).
//!
//! From the command inwards:
//!
//! This file is the command. `record` says which part of a run is wanted, and runs a world for it, whose `ticks` are done in
//! this thread or, if a brain is a program, on a server of its own; `cycle` finds a control
//! cycle among the events; `meaning` knows what was said in those on cables; `table` writes events as text, and [`baudbot_plot::timing`] draws them.

mod cycle;
#[cfg(test)]
mod demo;
mod meaning;
mod record;
mod table;
#[cfg(test)]
mod tests;
mod ticks;

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::Event;

use baudbot_plot::caption;
use baudbot_plot::quantity::duration;
use baudbot_plot::timing::{self, Diagram, Mark};

use self::record::{Place, Recorded, Wanted, Window};
use self::ticks::ticks;
use crate::args::DiagramArgs;
use crate::assignment::{self, Assigned};
use crate::error::Refused;
use crate::run::overrides;
use crate::scenarios::{self, Source};
use crate::signals::INTERRUPTED;
use crate::{text, work};

pub(crate) async fn diagram(args: DiagramArgs) -> anyhow::Result<ExitCode> {
    work::until_stopped(move |stop| show(&args, stop)).await
}

fn show(args: &DiagramArgs, stop: &AtomicBool) -> anyhow::Result<ExitCode> {
    let source = Source::find(&args.scenario)?;
    let scenario = source.parse(&overrides(&args.changes)?)?;
    scenarios::warn(&scenario);
    let mut assigned = assignment::assign(&args.brains, &scenario.robots)?;
    assignment::set_parameters(&mut assigned, &args.parameters)?;
    let place = place(args.robot.as_deref(), &scenario.robots)?;
    let robot = &scenario.robots[place];
    let wanted = wanted(args);
    let events = wanted.record(scenario.step_ns, ticks(scenario.clone(), &assigned, place, stop)?);
    if stop.load(Ordering::Relaxed) {
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let Recorded { events, said } = events?;
    let window = wanted.window(robot, &events, scenario.step_ns);
    let meanings = meaning::meanings(&events, &said);
    let shown = match &args.svg {
        None => text::print(&table::table(robot, &events, &window, &meanings)),
        Some(path) => {
            let name = source.world_name(&scenario);
            let mut picture = picture(&name, (scenario.step_ns, robot), (&events, &meanings), &window);
            picture.ran = ran(&scenario, robot, &assigned);
            text::write(path, &picture.draw())
        }
    };
    shown.map(|()| ExitCode::SUCCESS)
}

/// The title: the robot's brain, its link and the seed, and the changes of the scenario.
fn ran(scenario: &Scenario, robot: &RobotSpec, assigned: &Assigned) -> Vec<String> {
    let brains: Vec<_> = assigned.brain_of(&robot.name).into_iter().collect();
    let facts = caption::facts(&brains, &[caption::link(&robot.link)], scenario.seed);
    let about = caption::about(scenario, false);
    let changed = (about != scenario.description).then_some(about);
    [Some(facts), changed].into_iter().flatten().collect()
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

fn wanted(args: &DiagramArgs) -> Wanted {
    let place = match (args.at, args.cycle) {
        (Some(at_s), _) => Place::At((at_s * 1e9).round() as u64),
        (None, Some(number)) => Place::Cycle(number),
        (None, None) => Place::Usual,
    };
    Wanted { place, span_ns: args.span.map(|ms| (ms * 1e6).round().max(1.0) as u64) }
}

/// The diagram of a part of a robot's run.
fn picture(
    world: &str,
    (step_ns, robot): (u64, &RobotSpec),
    (events, meanings): (&[Event], &BTreeMap<usize, String>),
    window: &Window,
) -> Diagram {
    let Window { from_ns, until_ns, cycle } = window;
    let of_cycle = cycle.as_ref().map(|cycle| &cycle.events);
    let late_from_ns = cycle.as_ref().map(|cycle| cycle.late_from_ns(robot));
    let late_from_ns =
        late_from_ns.filter(|late| cycle.as_ref().is_some_and(|it| it.end(events).as_ns() > *late));
    let (subtitle, marks) = match cycle {
        None => {
            let step = duration(step_ns as f64);
            let told = format!("What happened when, from the sensors to the brain and back. Δt = {step}.");
            (told, Vec::new())
        }
        Some(cycle) => about(cycle, late_from_ns, robot),
    };
    Diagram {
        title: match cycle {
            None => format!("{} in {world}", robot.name),
            Some(cycle) => format!("{} in {world}: control cycle {}", robot.name, cycle.number),
        },
        subtitle,
        ran: Vec::new(),
        lanes: timing::lanes(robot, events, (*from_ns, *until_ns), of_cycle, meanings),
        from_ns: *from_ns,
        until_ns: *until_ns,
        step_ns,
        marks,
        late_from_ns,
    }
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
