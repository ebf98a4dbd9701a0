//! `baudbot budget`: what one control cycle of each robot costs, and whether it fits into Δt.

mod lanes;
mod measured;
mod program;
mod table;

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use baudbot_run::programs::PROGRAM;
use baudbot_scenario::budget::{Budget, RobotBudget, Verdict};
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use serde::Serialize;

use self::measured::Measured;
use self::program::ProgramBudget;
use crate::args::BudgetArgs;
use crate::assignment::{self, Assigned, Assignment};
use crate::error::Refused;
use crate::output_files::Inputs;
use crate::robot_groups;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text;
use crate::together;

pub(crate) fn budget(args: &BudgetArgs) -> anyhow::Result<ExitCode> {
    let inputs = Inputs::of(&args.scenario, &args.changes);
    let inputs = args.measured.iter().fold(inputs, |all, recording| all.file("recording", recording));
    inputs.check(args.svg.iter().map(|path| ("--svg", path.as_path())))?;
    let source = Source::find(&args.scenario)?;
    let mut scenario = source.parse(&overrides(&args.changes)?)?;
    let assigned = assigned(args, &source, &mut scenario)?;
    let named = |name: &String| scenario.robots.iter().position(|robot| robot.name == *name);
    if let Some(name) = args.robots.iter().find(|name| named(name).is_none()) {
        let names: Vec<_> = scenario.robots.iter().map(|robot| format!("`{}`", robot.name)).collect();
        let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        return Err(Refused::error(format!("--robot: there is no robot `{name}`; there are: {there}")));
    }
    let wanted = |name: &String| args.robots.is_empty() || args.robots.contains(name);
    let wanted: Vec<_> = scenario.robots.iter().filter(|robot| wanted(&robot.name)).collect();
    let measured = args.measured.as_deref().map(Measured::of_recording).transpose()?.unwrap_or_default();
    measured.check(args.measured.as_deref(), wanted.iter().copied())?;
    let models = || wanted.iter().copied().filter(|robot| robot.chip.is_none());
    let computed = Budget::of_measured(&scenario, models(), |robot| measured.of(robot));
    if let Some(path) = &args.svg {
        return draw(&source.world_name(&scenario), (&wanted, &computed), path)
            .map(|()| code(args, &computed, &[]));
    }
    let programs = programs(&scenario, &wanted, args.seconds);
    if args.json {
        text::print_json(&Budgets { computed: &computed, programs: &programs })?;
    } else {
        text::print(&told(&source, &wanted, (&computed, &programs), (&measured, &assigned)))?;
    }
    Ok(code(args, &computed, &programs))
}

/// The assignment of the robots, as far as that is known; `scenario` has afterwards the rules by which they write.
fn assigned(args: &BudgetArgs, source: &Source, scenario: &mut Scenario) -> anyhow::Result<Assigned> {
    let mut brains = args.brains.clone();
    let is_open = !brains.iter().any(|brain| assignment::is_for_all(brain));
    brains.extend(is_open.then(|| assignment::NONE.to_owned()));
    let mut assigned = assignment::assign(&brains, &scenario.robots, &source.shown_brains())?;
    if let Some(task) = assigned.at_ports.first() {
        return Err(Refused::error(format!(
            "--brain {PROGRAM}{}: nobody knows when a program of somebody else's writes before it runs, so it has no budget; a run \
             measures it (baudbot run), or say how it writes with --writes and name no brain",
            task.program
        )));
    }
    let is_free = |spec: &&RobotSpec| {
        assignment::sees(spec) && !args.brains.iter().any(|brain| assignment::is_for(brain, spec))
    };
    let free = scenario.robots.iter().filter(|spec| is_open && is_free(spec)).map(|spec| spec.name.clone());
    assigned.brains.push(Assignment { brain: assignment::DEFAULT.to_owned(), robots: free.collect() });
    if let Some(writes) = args.writes {
        for spec in &mut scenario.robots {
            Arc::make_mut(&mut spec.model).writes = Some(writes);
        }
    }
    assignment::state_writes(&assigned, scenario)?;
    Ok(assigned)
}

/// The brain for which the verdict holds.
fn brain(robot: &RobotBudget, brain: Option<&str>) -> String {
    let writes = robot.writes.phrase();
    match brain {
        Some(brain) => format!("  holds if its brain, `{brain}`, {writes}\n"),
        None => format!("  holds for a brain that {writes}\n"),
    }
}

/// The budgets of all robots: those that were computed, and those of programs, which were measured.
#[derive(Serialize)]
struct Budgets<'a> {
    #[serde(flatten)]
    computed: &'a Budget,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    programs: &'a [ProgramBudget],
}

/// The budgets of robots with programs of their own, one of each table.
fn programs(scenario: &Scenario, wanted: &[&RobotSpec], seconds: f64) -> Vec<ProgramBudget> {
    let firsts = robot_groups::first_of_each(wanted.iter().copied()).into_iter();
    let firsts = firsts
        .filter(|(spec, _)| spec.chip.is_some())
        .filter_map(|(spec, _)| scenario.robots.iter().position(|robot| robot.name == spec.name));
    program::of(&Arc::new(scenario.clone()), &firsts.collect::<Vec<_>>(), seconds)
}

fn code(args: &BudgetArgs, computed: &Budget, programs: &[ProgramBudget]) -> ExitCode {
    let mut verdicts =
        computed.robots.iter().map(|robot| robot.verdict).chain(programs.iter().map(|it| it.verdict));
    let missed = verdicts.any(|verdict| verdict == Verdict::Misses);
    if args.check && missed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn draw(world: &str, (wanted, budget): (&[&RobotSpec], &Budget), path: &Path) -> anyhow::Result<()> {
    if let [robot] = wanted
        && robot.chip.is_some()
    {
        return Err(Refused::error(format!(
            "--svg draws the cycle of a robot without a program of its own, and `{0}` has one; draw its pins and its main loop in \
             a run: baudbot run … --vcd {0}=FILE",
            robot.name
        )));
    }
    let [robot] = &budget.robots[..] else {
        let names: Vec<_> = budget.robots.iter().map(|robot| robot.robot.as_str()).collect();
        return Err(Refused::error(format!(
            "--svg draws one robot; choose it with --robot: {}",
            names.join(", ")
        )));
    };
    let never = || {
        Refused::error(format!("no cycle of `{}` is ever completed, so there is none to draw", robot.robot))
    };
    let picture = lanes::diagram(world, robot).ok_or_else(never)?.draw();
    text::write(path, &picture)
}

fn told(
    source: &Source,
    specs: &[&RobotSpec],
    (budget, programs): (&Budget, &[ProgramBudget]),
    (measured, assigned): (&Measured, &Assigned),
) -> String {
    if specs.is_empty() {
        return format!("{}: no robots\n", source.label());
    }
    let told = |(spec, count): (&RobotSpec, usize)| {
        if let Some(program) = programs.iter().find(|program| program.robot == spec.name) {
            return Some(program::told(program) + &robot_groups::others(spec, count));
        }
        let robot = budget.robots.iter().find(|robot| robot.robot == spec.name);
        robot.map(|robot| {
            let warnings = together::warnings(spec, robot);
            let warnings: String = warnings.iter().map(|warning| format!("  warning: {warning}\n")).collect();
            let brain = brain(robot, assigned.brain_of(&spec.name).as_deref());
            let thinking = measured.told(spec).unwrap_or_default();
            table::robot(robot, &(brain + &thinking)) + &warnings + &robot_groups::others(spec, count)
        })
    };
    let robots: Vec<_> =
        robot_groups::first_of_each(specs.iter().copied()).into_iter().filter_map(told).collect();
    robots.join("\n")
}
