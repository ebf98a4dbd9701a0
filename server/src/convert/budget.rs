//! Budgets: the cost of a robot's control cycle.

use baudbot_proto::v1;
use baudbot_scenario::budget::{Age, Chip, Cost, Load, Part, Rate, Remedy, RobotBudget, Row, Span, Verdict};

/// A robot's budget.
pub(crate) fn robot_budget(robot: RobotBudget) -> v1::RobotBudget {
    let RobotBudget {
        robot,
        step_ns,
        writes,
        deadline_ns,
        starts_after_ns,
        dead_time_ns,
        cycle,
        rates,
        ages,
        loads,
        chip,
        verdict,
        bottleneck,
        remedies,
        left_out,
    } = robot;
    v1::RobotBudget {
        robot,
        step_ns,
        deadline_ns,
        dead_time_ns,
        starts_after_ns,
        rows: cycle.rows.into_iter().map(row).collect(),
        total: Some(span(cycle.total)),
        unbounded: cycle.unbounded.unwrap_or_default(),
        rates: rates.into_iter().map(rate).collect(),
        ages: ages.into_iter().map(age).collect(),
        loads: loads.into_iter().map(|Load { what, share }| v1::BudgetLoad { what, share }).collect(),
        chip: Some(chip_of(chip)),
        verdict: verdict_of(verdict).into(),
        bottleneck,
        remedies: remedies.into_iter().map(remedy).collect(),
        left_out: left_out.unwrap_or_default(),
        writes: writes.to_string(),
    }
}

fn span(Span { best_ns, typical_ns, worst_ns }: Span) -> v1::BudgetSpan {
    v1::BudgetSpan { best_ns, typical_ns, worst_ns }
}

fn row(row: Row) -> v1::BudgetRow {
    let part = match row.part {
        Part::Acquisition => "acquisition",
        Part::Framing => "framing",
        Part::WireUp => "wire-up",
        Part::WaitUp => "wait-up",
        Part::Step => "step",
        Part::Thinking => "thinking",
        Part::Down => "down",
        Part::Obeying => "obeying",
        Part::Actuation => "actuation",
    };
    v1::BudgetRow { part: part.to_owned(), span: Some(span(row.span)) }
}

fn rate(Rate { what, most_per_s, typical_per_s, limits }: Rate) -> v1::BudgetRate {
    v1::BudgetRate { what, most_per_s, typical_per_s, limits }
}

fn age(age: Age) -> v1::BudgetAge {
    let unbounded = age.unbounded.unwrap_or_default();
    v1::BudgetAge { sensor: age.sensor, span: Some(span(age.span)), unbounded }
}

fn chip_of(chip: Chip) -> v1::BudgetChip {
    let Chip { ram_bytes, brain_memory_bytes, operations_per_step, brain_operations } = chip;
    v1::BudgetChip { ram_bytes, brain_memory_bytes, operations_per_step, brain_operations }
}

fn verdict_of(verdict: Verdict) -> v1::BudgetVerdict {
    match verdict {
        Verdict::Keeps => v1::BudgetVerdict::Keeps,
        Verdict::Sometimes => v1::BudgetVerdict::Sometimes,
        Verdict::Misses => v1::BudgetVerdict::Misses,
    }
}

fn remedy(remedy: Remedy) -> v1::BudgetRemedy {
    let cost = match remedy.cost {
        Cost::Setting => v1::BudgetCost::Setting,
        Cost::BothEnds => v1::BudgetCost::BothEnds,
        Cost::Firmware => v1::BudgetCost::Firmware,
        Cost::LongerStep => v1::BudgetCost::LongerStep,
        Cost::Cable => v1::BudgetCost::Cable,
        Cost::Processor => v1::BudgetCost::Processor,
        Cost::Layout => v1::BudgetCost::Layout,
        Cost::Loss => v1::BudgetCost::Loss,
    };
    v1::BudgetRemedy {
        what: remedy.what,
        cost: cost.into(),
        overrides: remedy.overrides,
        step_ns: remedy.step_ns,
        total: Some(span(remedy.total)),
        verdict: verdict_of(remedy.verdict).into(),
    }
}
