//! `baudbot budget`: what one control cycle of each robot costs, and whether it fits into Δt.

mod lanes;
mod measured;
mod table;

use std::path::Path;
use std::process::ExitCode;

use baudbot_budget::{Budget, Verdict};
use baudbot_sim::model::RobotSpec;

use self::measured::Measured;
use crate::args::BudgetArgs;
use crate::error::Refused;
use crate::robot_groups;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text;
use crate::together;

pub(crate) fn budget(args: &BudgetArgs) -> anyhow::Result<ExitCode> {
    let source = Source::find(&args.scenario)?;
    let scenario = source.parse(&overrides(&args.changes)?)?;
    let named = |name: &String| scenario.robots.iter().position(|robot| robot.name == *name);
    if let Some(name) = args.robots.iter().find(|name| named(name).is_none()) {
        let names: Vec<_> = scenario.robots.iter().map(|robot| format!("`{}`", robot.name)).collect();
        let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        return Err(Refused::error(format!("--robot: there is no robot `{name}`; there are: {there}")));
    }
    let wanted = |name: &String| args.robots.is_empty() || args.robots.contains(name);
    let wanted: Vec<_> = scenario.robots.iter().filter(|robot| wanted(&robot.name)).collect();
    if let Some(robot) = wanted.iter().find(|robot| robot.chip.is_some()) {
        return Err(Refused::error(format!(
            "robot `{0}`: its microcontroller runs a program of its own, and what that costs is found by running it (`baudbot run`); \
             name other robots with --robot, or leave microcontroller.program out for the model",
            robot.name
        )));
    }
    let measured = args.measured.as_deref().map(Measured::of_recording).transpose()?.unwrap_or_default();
    measured.check(args.measured.as_deref(), wanted.iter().copied())?;
    let budget = Budget::of_measured(&scenario, wanted.iter().copied(), |robot| measured.of(robot));
    if let Some(path) = &args.svg {
        return draw(&source.world_name(&scenario), &budget, path).map(|()| code(args, &budget));
    }
    if args.json {
        text::print_json(&budget)?;
    } else {
        text::print(&told(&source, &wanted, &budget, &measured))?;
    }
    Ok(code(args, &budget))
}

fn code(args: &BudgetArgs, budget: &Budget) -> ExitCode {
    let kept = budget.robots.iter().all(|robot| robot.verdict != Verdict::Misses);
    if args.check && !kept { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn draw(world: &str, budget: &Budget, path: &Path) -> anyhow::Result<()> {
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

fn told(source: &Source, specs: &[&RobotSpec], budget: &Budget, measured: &Measured) -> String {
    if budget.robots.is_empty() {
        return format!("{}: no robots\n", source.label());
    }
    let told = |(spec, count): (&RobotSpec, usize)| {
        let robot = budget.robots.iter().find(|robot| robot.robot == spec.name);
        robot.map(|robot| {
            let warnings = together::warnings(spec, robot);
            let warnings: String = warnings.iter().map(|warning| format!("  warning: {warning}\n")).collect();
            let thinking = measured.told(spec).unwrap_or_default();
            table::robot(robot, &thinking) + &warnings + &robot_groups::others(spec, count)
        })
    };
    let robots: Vec<_> =
        robot_groups::first_of_each(specs.iter().copied()).into_iter().filter_map(told).collect();
    robots.join("\n")
}
