//! The cost of one control cycle, from the scenario alone: Fig. 3.2 (§3.2.1) as arithmetic.
//!
//! A real robot must need less than one step for everything in that step. For each robot this computes how long it
//! takes, how often it can be done, how old readings are by then, what is the bottleneck, and what would fix it.
//!
//! From the scenario to the answer:
//!
//! 1. `plan` says what each task costs and how long each message is; `pattern` which sensors are new in which.
//! 2. `bounds` says what each part takes at least and at most: the microcontroller by `late`, the cable by `transfer` and
//!    `wire`, queues by `curve`. They hold whatever happens.
//! 3. `timeline` carries the plan out, without a world, with devices by `device`. What comes of it is typical.
//! 4. `cycle`, `rates`, `ages`, `loads` put that together; `judge` gives the verdict.
//! 5. `remedy` changes the robot and computes it again, as far as the `allowance` goes; `change` has what can be changed,
//!    `ports` what of sensors' own cables, `apply` does it.
//!
//! When a brain writes is part of the question (`RobotModel::writes`): unless that is stated, it is taken to answer each message
//! once, and to write nothing else. Byte errors and outages are left out: what
//! arrives is as old as the bounds say, what is lost has no age.
//!
//! *Deviations.* The notes add up the events of one Δt. Here a message may take longer than Δt, and the next be under
//! way meanwhile; the cycle is then longer than Δt, and the verdict is that the robot does not keep its step.

mod ages;
mod allowance;
mod apply;
mod bounds;
mod change;
mod curve;
mod cycle;
mod device;
mod judge;
mod late;
mod loads;
mod pattern;
mod plan;
mod ports;
mod rates;
mod remedy;
mod report;
mod timeline;
mod transfer;
mod wire;

use alloc::collections::BTreeMap;
use alloc::string::ToString;
use alloc::vec::Vec;

pub use allowance::Allowance;
pub use report::{
    Age, Budget, Chip, Cost, Cycle, Load, Part, Rate, Remedy, RobotBudget, Row, Span, Thinking, Verdict,
};

use baudbot_sim::Scenario;
use baudbot_sim::model::{RobotSpec, Writes};
use bounds::Bounds;
use plan::Plan;
use timeline::{Outcome, Timeline};

/// The thoroughness of the search for typical values.
#[derive(Clone, Copy, Debug)]
struct Effort {
    cycles: usize,
    events: usize,
}

/// The effort for the budgets that are asked for.
const FULL: Effort = Effort { cycles: 1000, events: 200_000 };

/// The effort for remedies that are tried.
const BRIEF: Effort = Effort { cycles: 300, events: 60_000 };

/// The effort after the allowance is used up.
const LEAST: Effort = Effort { cycles: 100, events: 5_000 };

const TOO_MANY: &str =
    "no fixes were searched for, and typical values are from a short dry run: ask for fewer robots at once";

impl Budget {
    /// A `Budget` of all robots of a scenario, with remedies for those that do not keep their step.
    pub fn of(scenario: &Scenario) -> Self {
        Self::of_some(scenario, &scenario.robots)
    }

    /// The budget of some robots of a scenario, as [`of`](Self::of). Those of one table are alike and computed once.
    pub fn of_some<'a>(scenario: &Scenario, robots: impl IntoIterator<Item = &'a RobotSpec>) -> Self {
        Self::of_measured(scenario, robots, |_| None)
    }

    /// The same, with the thinking times that were measured, if they were.
    pub fn of_measured<'a>(
        scenario: &Scenario,
        robots: impl IntoIterator<Item = &'a RobotSpec>,
        measured: impl Fn(&RobotSpec) -> Option<Thinking>,
    ) -> Self {
        let mut alike: BTreeMap<(&str, Option<Writes>, Option<Thinking>), usize> = BTreeMap::new();
        let mut budgets: Vec<RobotBudget> = Vec::new();
        for spec in robots {
            let thinking = measured(spec);
            let first = *alike.entry((spec.table_name(), spec.writes, thinking)).or_insert(budgets.len());
            let budget = match (budgets.get(first), thinking) {
                (Some(first), _) => RobotBudget { robot: spec.name.clone(), ..first.clone() },
                (None, None) => RobotBudget::of(scenario, spec),
                (None, Some(thinking)) => RobotBudget::of_measured(scenario, spec, thinking),
            };
            budgets.push(budget);
        }
        Self { robots: budgets }
    }
}

impl RobotBudget {
    /// A `RobotBudget` of one robot of a scenario.
    pub fn of(scenario: &Scenario, spec: &RobotSpec) -> Self {
        Self::within(scenario, spec, &mut Allowance::default())
    }

    /// The budget of one of several robots that share an allowance. Once it is used up, budgets have no remedies, and a
    /// mark of that.
    pub fn within(scenario: &Scenario, spec: &RobotSpec, allowance: &mut Allowance) -> Self {
        Self::planned(scenario, Plan::of(scenario, spec), allowance)
    }

    /// The budget of one robot of a scenario whose brain was measured to think so long.
    pub fn of_measured(scenario: &Scenario, spec: &RobotSpec, thinking: Thinking) -> Self {
        let plan = Plan { measured: Some(thinking), ..Plan::of(scenario, spec) };
        Self::planned(scenario, plan, &mut Allowance::default())
    }

    fn planned(scenario: &Scenario, plan: Plan<'_>, allowance: &mut Allowance) -> Self {
        if allowance.is_used_up() {
            let budget = Self::computed(&plan, LEAST, allowance);
            return Self { left_out: Some(TOO_MANY.to_string()), ..budget };
        }
        let mut own = allowance.of_a_robot();
        let mut budget = Self::computed(&plan, FULL, &mut own);
        remedy::add(scenario, &plan, &mut budget, &mut own);
        allowance.settle(&own);
        budget
    }

    /// The same without looking for remedies, which takes by far the most time.
    pub fn without_remedies(scenario: &Scenario, spec: &RobotSpec) -> Self {
        let plan = Plan::of(scenario, spec);
        Self::computed(&plan, FULL, &mut Allowance::default())
    }

    /// Whether a robot keeps its step, at least mostly. What is overloaded anyway is not carried out.
    fn keeps(plan: &Plan<'_>, effort: Effort, allowance: &mut Allowance) -> bool {
        let bounds = Bounds::of(plan);
        if judge::is_overloaded(&loads::loads(plan, &bounds, &Outcome::default())) {
            allowance.charge(plan, 0);
            return false;
        }
        let outcome = Timeline::run(*plan, effort.cycles, effort.events);
        allowance.charge(plan, outcome.events);
        let cycle = cycle::cycle(plan, &bounds, &outcome);
        let loads = loads::loads(plan, &bounds, &outcome);
        judge::judge(plan.deadline_ns(), &cycle, &loads).0 != Verdict::Misses
    }

    fn computed(plan: &Plan<'_>, effort: Effort, allowance: &mut Allowance) -> Self {
        let bounds = Bounds::of(plan);
        let outcome = Timeline::run(*plan, effort.cycles, effort.events);
        allowance.charge(plan, outcome.events);
        let cycle = cycle::cycle(plan, &bounds, &outcome);
        let loads = loads::loads(plan, &bounds, &outcome);
        let (verdict, bottleneck) = judge::judge(plan.deadline_ns(), &cycle, &loads);
        Self {
            robot: plan.spec.name.clone(),
            step_ns: plan.step_ns,
            writes: plan.writes(),
            deadline_ns: plan.deadline_ns(),
            starts_after_ns: plan.spec.processor.bootloader_ns,
            dead_time_ns: plan.spec.dead_time_ns,
            rates: rates::rates(plan, &bounds, &outcome),
            ages: ages::ages(plan, &bounds, &outcome),
            chip: loads::chip(plan),
            remedies: Vec::new(),
            left_out: None,
            cycle,
            loads,
            verdict,
            bottleneck,
        }
    }
}
