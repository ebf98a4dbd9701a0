//! The rows of a cycle: the bounds of each part, and what is typical of it.

use alloc::string::ToString;
use alloc::vec::Vec;

use super::bounds::Bounds;
use super::plan::Plan;
use super::report::{Cycle, Part, Row, Span};
use super::timeline::Outcome;
use super::wire;

pub(super) fn cycle(plan: &Plan<'_>, bounds: &Bounds, outcome: &Outcome) -> Cycle {
    let typical = median(outcome);
    let rows: Vec<Row> = Part::ALL
        .into_iter()
        .enumerate()
        .map(|(i, part)| {
            let span = bounds_of(plan, bounds, part);
            Row { part, span: Span { typical_ns: typical.map(|(parts, _)| parts[i]), ..span } }
        })
        .collect();
    let total = rows.iter().fold(Span::exactly(0), |sum, row| sum.then(row.span));
    let total = Span { typical_ns: typical.map(|(_, sum)| sum), ..total };
    let unbounded = if total.worst_ns.is_none() { bounds.reason } else { None };
    Cycle { rows, total, unbounded: unbounded.map(ToString::to_string) }
}

/// The cycle that is longer than one half of all and shorter than the other.
fn median(outcome: &Outcome) -> Option<([u64; 9], u64)> {
    let mut cycles = outcome.cycles.clone();
    let middle = cycles.len() / 2;
    if cycles.is_empty() {
        return None;
    }
    Some(*cycles.select_nth_unstable_by_key(middle, |(parts, sum)| (*sum, *parts)).1)
}

fn bounds_of(plan: &Plan<'_>, bounds: &Bounds, part: Part) -> Span {
    let link = &plan.spec.link;
    match part {
        Part::Acquisition => Span::between(bounds.pattern.reads_ns.least, Some(bounds.pattern.reads_ns.most)),
        Part::Framing => Span::between(bounds.framing.least, Some(bounds.framing.most)),
        Part::WireUp => Span::between(bounds.wire_up.least, Some(bounds.wire_up.most)),
        Part::WaitUp => Span::between(wire::hold_up_ns(link).least, bounds.wait_up),
        Part::Step => Span::between(0, bounds.step),
        Part::Thinking => Span::between(plan.thinking().least_ns, bounds.thinking),
        Part::Down => {
            let wire = wire::least_ns(link, plan.command_bytes().least);
            Span::between(wire::hold_down_ns(link).least + wire, bounds.down)
        }
        Part::Obeying => {
            let (byte, obeying) = (plan.receiving_ns(), plan.spec.processor.obeying_ns);
            let worst = bounds.late_ns(byte + obeying).map(|late| late + byte + obeying);
            Span::between(plan.least_obeying_ns(), worst)
        }
        Part::Actuation => Span::between(0, Some(plan.pulse_ns())),
    }
}
