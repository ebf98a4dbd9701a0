//! `baudbot budget`: what one control cycle of each robot costs, and whether it fits into Δt.

#[cfg_attr(not(test), expect(dead_code, reason = "it waits for somebody who draws it"))]
mod lanes;
mod table;

use std::process::ExitCode;

use baudbot_sim::budget::{Budget, RobotBudget, Verdict};

use crate::args::BudgetArgs;
use crate::error::Refused;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text;

pub(crate) fn budget(args: &BudgetArgs) -> anyhow::Result<ExitCode> {
    let source = Source::find(&args.scenario)?;
    let scenario = source.parse(&overrides(&args.changes)?)?;
    let named = |name: &String| scenario.robots().iter().position(|robot| robot.name == *name);
    if let Some(name) = args.robots.iter().find(|name| named(name).is_none()) {
        let names: Vec<_> = scenario.robots().iter().map(|robot| format!("`{}`", robot.name)).collect();
        let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        return Err(Refused::error(format!("--robot: there is no robot `{name}`; there are: {there}")));
    }
    let wanted = |name: &String| args.robots.is_empty() || args.robots.contains(name);
    let wanted = scenario.robots().iter().filter(|robot| wanted(&robot.name));
    let robots = wanted.map(|robot| RobotBudget::of(&scenario, robot)).collect();
    let budget = Budget { robots };
    if args.json {
        text::print(&(serde_json::to_string_pretty(&budget)? + "\n"))?;
    } else {
        text::print(&told(&source, &budget))?;
    }
    let kept = budget.robots.iter().all(|robot| robot.verdict != Verdict::Misses);
    Ok(if args.check && !kept { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn told(source: &Source, budget: &Budget) -> String {
    if budget.robots.is_empty() {
        return format!("{}: no robots\n", source.label());
    }
    let robots: Vec<_> = budget.robots.iter().map(table::robot).collect();
    robots.join("\n")
}
