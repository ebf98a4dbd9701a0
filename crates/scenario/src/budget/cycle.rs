//! The rows of a cycle: the bounds of each part, and what is typical of it.

use alloc::string::ToString;
use alloc::vec::Vec;

use super::bounds::Bounds;
use super::pattern::gcd;
use super::plan::Plan;
use super::report::{Cycle, Part, Row, Span};
use super::timeline::Outcome;
use super::wire;
use baudbot_sim::firmware::Mode;
use baudbot_sim::time::SimTime;

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
    let in_place = by_pulse(plan, bounds, &rows);
    let worst_ns = total.worst_ns.map(|sum| in_place.map_or(sum, |in_place| sum.min(in_place)));
    let total = Span { typical_ns: typical.map(|(_, sum)| sum), worst_ns, ..total };
    let unbounded = if total.worst_ns.is_none() { bounds.reason } else { None };
    Cycle { rows, total, unbounded: unbounded.map(ToString::to_string) }
}

/// The longest cycle where servos take up commands: messages that are due at the same instants between two pulses do not all
/// wait for a whole one.
fn by_pulse(plan: &Plan<'_>, bounds: &Bounds, rows: &[Row]) -> Option<u64> {
    let Mode::Stream(frame) = plan.spec.firmware.mode else { return None };
    let (period, pulse) = (frame.period_ns(), plan.pulse_ns());
    let messages = pulse.checked_div(gcd(u128::from(period), u128::from(pulse)) as u64);
    let messages = messages.filter(|messages| *messages <= MOST_MESSAGES)?;
    let is_behind = |part| !matches!(part, Part::Acquisition | Part::Framing | Part::Actuation);
    let behind = rows.iter().filter(|row| is_behind(row.part));
    let framed = bounds.backlog?;
    let obeyed = behind.map(|row| row.span.worst_ns).try_fold(framed, |sum, ns| sum.checked_add(ns?))?;
    let wait = |k: u64| {
        let due = SimTime::from_ns(frame.phase_ns() + k * period);
        (due + obeyed).up_to(pulse).since(due)
    };
    let longest = (0..messages).map(wait).max()?;
    longest.checked_add(bounds.pattern.reads_ns.most)
}

/// The cycle that is longer than one half of all and shorter than the other.
fn median(outcome: &Outcome) -> Option<([u64; 9], u64)> {
    let mut cycles = outcome.cycles.clone();
    // By nearest rank, as runs count it: of two values that come equally often it is the lower one.
    let middle = cycles.len().checked_sub(1)? / 2;
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
            let worst = bounds.obeyed_late.map(|late| late + byte + obeying);
            Span::between(plan.least_obeying_ns(), worst)
        }
        Part::Actuation => Span::between(0, Some(plan.pulse_ns())),
    }
}

/// More messages than so many are not looked at one by one.
const MOST_MESSAGES: u64 = 2048;
