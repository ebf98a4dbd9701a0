//! What one control cycle costs, from the scenario alone: Fig. 3.2 (§3.2.1) as arithmetic.
//!
//! What takes place in one step must take the real robot less than that step. For each robot this says how long it takes,
//! how often it can be done, how old readings are by then, what is the bottleneck, and what would mend it.
//!
//! From the scenario to the answer:
//!
//! 1. `plan` says what each task costs and how long each message is; `pattern` which sensors are new in which.
//! 2. `bounds` says what each part takes at least and at most: the microcontroller by `late`, the cable by `transfer` and
//!    `wire`, queues by `curve`. They hold whatever happens.
//! 3. `timeline` carries the plan out, without a world, with devices by `device`. What comes of it is typical.
//! 4. `cycle`, `rates`, `ages`, `loads` put that together; `judge` gives the verdict.
//! 5. `mend` changes the robot and computes it again; `change` has what can be changed, `apply` does it.
//!
//! A brain is taken to answer each message once, and to write nothing else. Byte errors and outages are left out: what
//! arrives is as old as the bounds say, what is lost has no age.
//!
//! *Deviations.* The notes add up the events of one Δt. Here a message may take longer than Δt, and the next be under
//! way meanwhile; the cycle is then longer than Δt, and the verdict is that the robot does not keep its step.

mod ages;
mod apply;
mod bounds;
mod change;
mod curve;
mod cycle;
mod device;
mod judge;
mod late;
mod loads;
mod mend;
mod pattern;
mod plan;
mod rates;
mod report;
mod timeline;
mod transfer;
mod wire;

use alloc::vec::Vec;

pub use report::{Age, Budget, Chip, Cost, Cycle, Load, Mend, Part, Rate, RobotBudget, Row, Span, Verdict};

use crate::robot::RobotSpec;
use crate::scenario::Scenario;
use bounds::Bounds;
use plan::Plan;
use timeline::Timeline;

/// How thoroughly what is typical is looked for.
#[derive(Clone, Copy, Debug)]
struct Effort {
    cycles: usize,
    events: usize,
}

/// For what is asked.
const FULL: Effort = Effort { cycles: 1000, events: 200_000 };

/// For what is tried.
const BRIEF: Effort = Effort { cycles: 300, events: 60_000 };

impl Budget {
    /// Of all robots of a scenario, with mends for those that do not keep their step.
    pub fn of(scenario: &Scenario) -> Self {
        let robots = scenario.robots().iter();
        Self { robots: robots.map(|spec| RobotBudget::of(scenario, spec)).collect() }
    }
}

impl RobotBudget {
    /// Of one robot of a scenario.
    pub fn of(scenario: &Scenario, spec: &RobotSpec) -> Self {
        let plan = Plan { spec, step_ns: scenario.step_ns(), noise: scenario.noise() };
        let mut budget = Self::computed(&plan, FULL);
        budget.mends = mend::mends(scenario, &plan, &budget);
        budget
    }

    /// The same without looking for mends, which takes by far the most time.
    pub fn without_mends(scenario: &Scenario, spec: &RobotSpec) -> Self {
        let plan = Plan { spec, step_ns: scenario.step_ns(), noise: scenario.noise() };
        Self::computed(&plan, FULL)
    }

    fn computed(plan: &Plan<'_>, effort: Effort) -> Self {
        let bounds = Bounds::of(plan);
        let outcome = Timeline::run(*plan, effort.cycles, effort.events);
        let cycle = cycle::cycle(plan, &bounds, &outcome);
        let loads = loads::loads(plan, &bounds, &outcome);
        let (verdict, bottleneck) = judge::judge(plan.deadline_ns(), &cycle, &loads);
        Self {
            robot: plan.spec.name.clone(),
            step_ns: plan.step_ns,
            deadline_ns: plan.deadline_ns(),
            rates: rates::rates(plan, &bounds, &outcome),
            ages: ages::ages(plan, &bounds, &outcome),
            chip: loads::chip(plan),
            mends: Vec::new(),
            cycle,
            loads,
            verdict,
            bottleneck,
        }
    }
}
