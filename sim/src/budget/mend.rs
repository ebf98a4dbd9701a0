//! What would mend a robot that does not keep its step: each change is made, and the budget computed again.

use alloc::string::String;
use alloc::vec::Vec;

use super::change::{Change, Robot};
use super::plan::Plan;
use super::report::{Cost, Mend, RobotBudget, Verdict};
use super::{BRIEF, FULL};
use crate::scenario::Scenario;

/// The changes that mend it alone; if there is none, as many of the cheapest as it takes together.
pub(super) fn mends(scenario: &Scenario, plan: &Plan<'_>, budget: &RobotBudget) -> Vec<Mend> {
    if budget.verdict != Verdict::Misses {
        return Vec::new();
    }
    let robot = Robot { spec: plan.spec.clone(), step_ns: plan.step_ns, substeps: scenario.substeps() };
    let single = |changes: Vec<Change>| {
        let change = changes.into_iter().find(|change| keeps(&tried(plan, &robot.with(*change))))?;
        Some(mend(plan, &robot, &[change])).filter(|mend| mend.verdict != Verdict::Misses)
    };
    let mut mends: Vec<_> = robot.changes().into_iter().filter_map(single).collect();
    if mends.iter().all(|mend| mend.cost >= Cost::LongerStep) {
        mends.extend(together(plan, &robot));
    }
    mends.sort_by_key(|mend| mend.cost);
    mends
}

fn keeps(budget: &RobotBudget) -> bool {
    budget.verdict != Verdict::Misses
}

fn tried(plan: &Plan<'_>, robot: &Robot) -> RobotBudget {
    RobotBudget::computed(&Plan { spec: &robot.spec, step_ns: robot.step_ns, noise: plan.noise }, BRIEF)
}

/// How bad a budget is: what is overloaded and by how much, and how long the cycle takes.
fn badness(budget: &RobotBudget) -> (Verdict, u64, u64) {
    let over = budget.loads.iter().map(|load| ((load.share - 1.0).max(0.0) * 1e6) as u64).sum();
    (budget.verdict, over, budget.cycle.total.typical_ns.unwrap_or(u64::MAX))
}

/// One change after the other, the cheapest first, each as far as it helps, until the step is kept. The step itself
/// stays, and so do the sensors.
fn together(plan: &Plan<'_>, robot: &Robot) -> Option<Mend> {
    let mut done = Vec::new();
    let mut now = robot.clone();
    let mut worst = badness(&tried(plan, robot));
    let mut kinds = robot.changes();
    kinds.sort_by_key(|changes| changes[0].cost());
    for changes in kinds {
        if matches!(changes[0], Change::Step(_) | Change::Drop(_)) {
            continue;
        }
        let better = changes.iter().map(|&change| (badness(&tried(plan, &now.with(change))), change));
        let better: Vec<_> = better.filter(|(badness, _)| *badness < worst).collect();
        let enough = better.iter().find(|(badness, _)| badness.0 != Verdict::Misses);
        let Some(&(badness, change)) = enough.or_else(|| better.iter().min_by_key(|(badness, _)| *badness))
        else {
            continue;
        };
        (worst, now) = (badness, now.with(change));
        done.push(change);
        if worst.0 != Verdict::Misses {
            return Some(mend(plan, robot, &done))
                .filter(|mend| done.len() > 1 && mend.verdict != Verdict::Misses);
        }
    }
    None
}

/// These changes, one after the other, and what the budget is then.
fn mend(plan: &Plan<'_>, robot: &Robot, changes: &[Change]) -> Mend {
    let mut now = robot.clone();
    let (mut phrases, mut overrides) = (Vec::new(), Some(Vec::new()));
    for &change in changes {
        phrases.push(now.phrase(change));
        overrides = overrides.zip(now.overrides(change)).map(|(mut all, more): (Vec<String>, _)| {
            all.extend(more);
            all
        });
        now = now.with(change);
    }
    let after = Plan { spec: &now.spec, step_ns: now.step_ns, noise: plan.noise };
    let budget = RobotBudget::computed(&after, FULL);
    Mend {
        what: phrases.join(" and "),
        cost: changes.iter().map(|change| change.cost()).max().unwrap_or(Cost::Setting),
        overrides: overrides.unwrap_or_default(),
        step_ns: now.step_ns,
        total: budget.cycle.total,
        verdict: budget.verdict,
    }
}
