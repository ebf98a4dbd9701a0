//! The age of readings at the brain's step in which they are readable.

use alloc::string::ToString;
use alloc::vec::Vec;

use super::bounds::Bounds;
use super::plan::{Plan, Range, adapter, settling_ns};
use super::report::{Age, Span};
use super::timeline::Outcome;
use super::wire;
use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::sensor::{OwnClock, Sensor};

pub(super) fn ages(plan: &Plan<'_>, bounds: &Bounds, outcome: &Outcome) -> Vec<Age> {
    let on_wire = (0..plan.on_wire().len()).map(|i| (i, of_wire(plan, bounds, i), bounds.reason));
    let of_ports = plan.ports().map(|(i, sensor, clock, link)| {
        let (span, reason) = of_port(plan, bounds, (sensor, clock, link));
        (i, span, reason)
    });
    let all = on_wire.chain(of_ports).map(|(i, span, reason)| Age {
        sensor: plan.spec.sensors[i].name.clone(),
        span: Span { typical_ns: median(&outcome.ages[i]), ..span },
        unbounded: reason.filter(|_| span.worst_ns.is_none()).map(ToString::to_string),
    });
    all.collect()
}

fn median(ages: &[u64]) -> Option<u64> {
    let mut ages = ages.to_vec();
    // The median by nearest rank, as runs count it.
    let middle = ages.len().checked_sub(1)? / 2;
    Some(*ages.select_nth_unstable(middle).1)
}

fn of_wire(plan: &Plan<'_>, bounds: &Bounds, i: usize) -> Span {
    let link = &plan.spec.link;
    let held = plan.held_ns(&plan.on_wire()[i]);
    let (least, most) = bounds.wait_for_frame(plan, i);
    let bytes = bounds.pattern.slots[i].bytes;
    let framing = |bytes| plan.framing_ns(Range { least: bytes, most: bytes });
    let until_frame = Span::between(held.least + least, most.map(|most| held.most + most));
    let frame = Span::between(framing(bytes.least), Some(framing(bytes.most)));
    let wire = Span::between(wire::least_ns(link, bytes.least), Some(link.burst_ns(bytes.most)));
    let wait = Span::between(wire::hold_up_ns(link).least, bounds.wait_up);
    until_frame.then(frame).then(wire).then(wait).then(Span::between(0, bounds.step))
}

fn of_port(
    plan: &Plan<'_>,
    bounds: &Bounds,
    (sensor, clock, link): (&Sensor, &OwnClock, &Link),
) -> (Span, Option<&'static str>) {
    let bytes = wire::port_bytes(sensor);
    let settling = Span::exactly(settling_ns(sensor, clock));
    let most = link.burst_ns(bytes.most) + 1 + wire::frame_ns(link);
    let wire = Span::between(wire::least_ns(link, bytes.least), Some(most));
    let hold = wire::hold_up_ns(link);
    let keeps_up = match adapter(link) {
        Adapter::None | Adapter::Cdc(_) | Adapter::Ftdi(_) => true,
        Adapter::Bluetooth(radio) => {
            let packet = wire::packet_ns(&radio).most;
            let at_once =
                (packet / link.burst_ns(1).max(1) + 1).min(bytes.most * messages(plan, clock, packet));
            at_once <= u64::from(radio.packet_bytes) && 3 * at_once <= link.laptop_buffer() as u64
        }
    };
    let hold = Span::between(hold.least, keeps_up.then_some(hold.most));
    let span = settling.then(wire).then(hold).then(Span::between(0, bounds.step));
    (span, (!keeps_up).then_some("the radio cannot guarantee the rate of messages"))
}

/// Messages of a device that can land within a time.
fn messages(plan: &Plan<'_>, clock: &OwnClock, within_ns: u64) -> u64 {
    let spread = if plan.noise { clock.spread_ns } else { 0 };
    (within_ns + clock.jitter_ns) / clock.period_ns.saturating_sub(spread).max(1) + 2
}
