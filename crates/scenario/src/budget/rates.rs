//! The highest rates of things, and the limit of the exchanges.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_wire::codec::Pace;
use baudbot_wire::scip::{self, device::ANSWER_NS};

use super::bounds::Bounds;
use super::plan::{Plan, adapter, turnaround_ns};
use super::report::Rate;
use super::timeline::Outcome;
use super::wire;
use baudbot_sim::firmware::Mode;
use baudbot_sim::link::{Adapter, Link};
use baudbot_sim::sensor::port::Format;

/// The exchanges first: one message up and the command that answers it.
pub(super) fn rates(plan: &Plan<'_>, bounds: &Bounds, outcome: &Outcome) -> Vec<Rate> {
    let mut limits = limits(plan, bounds);
    let least = limits.iter().filter_map(|(_, most)| *most).fold(f64::INFINITY, f64::min);
    let exchanges = per_s(outcome.commands.min(outcome.messages), outcome.ran_ns);
    let mut rates = alloc::vec![Rate {
        what: "exchanges".to_string(),
        most_per_s: Some(least).filter(|least| least.is_finite()),
        typical_per_s: exchanges,
        limits: false,
    }];
    rates.extend(limits.drain(..).map(|(what, most_per_s)| Rate {
        limits: most_per_s == Some(least),
        what,
        most_per_s,
        typical_per_s: None,
    }));
    rates.extend(polls(plan));
    rates.extend(queries(plan));
    rates.extend(scans(plan));
    rates.extend(sensors(plan));
    rates
}

/// The highest rate of polls of a Khepera by a program that sends nothing else. It depends on how many digits the
/// numbers have.
fn polls(plan: &Plan<'_>) -> Vec<Rate> {
    let agreement = plan.spec.firmware.agreement();
    if agreement.protocol.pace() != Pace::Asked {
        return Vec::new();
    }
    let alone = |what: &str, bytes: u64| Rate {
        what: what.to_string(),
        most_per_s: most_messages(&plan.spec.link, bytes),
        typical_per_s: None,
        limits: false,
    };
    let (readings, command, preface) = (plan.all_bytes(), plan.command_bytes(), agreement.preface());
    let acknowledged = preface.acknowledgement as u64;
    let mut rates = alloc::vec![
        alone("polls alone, shortest answer", POLL_BYTES + readings.least),
        alone("polls alone, longest answer", POLL_BYTES + readings.most),
        alone("commands alone, shortest", command.least + acknowledged),
        alone("commands alone, longest", command.most + acknowledged),
    ];
    let [least, most] = preface.positions;
    if least > 0 {
        rates.push(alone("positions alone, shortest answer", POLL_BYTES + least as u64));
        rates.push(alone("positions alone, longest answer", POLL_BYTES + most as u64));
    }
    rates
}

/// The highest rate of scans of a laser for a program that asks again when it has the answer, and that thinks as long
/// as the scenario states.
fn scans<'a>(plan: &'a Plan<'_>) -> impl Iterator<Item = Rate> + 'a {
    plan.spec.sensors.iter().filter_map(move |sensor| {
        let port = sensor.port.as_ref()?;
        let (Format::Scip(format), Some(_)) = (&port.format, &port.dialogue) else { return None };
        let (asked, answered) = (scip::Format::QUESTION_LEN as u64, format.answer_len() as u64);
        Some(Rate {
            what: format!("port {}, asked for scans of {answered} bytes", sensor.name),
            most_per_s: per_s(
                1,
                plan.thinking().least_ns + ANSWER_NS + asking_ns(&port.link, asked, answered),
            ),
            typical_per_s: None,
            limits: false,
        })
    })
}

/// The least time that a question and its answer of so many bytes are on their way.
fn asking_ns(link: &Link, asked: u64, answered: u64) -> u64 {
    let holds = wire::hold_down_ns(link).least + wire::hold_up_ns(link).least;
    let turns = 2 * turnaround_ns(link).unwrap_or(0);
    holds + turns + wire::least_ns(link, asked) + wire::least_ns(link, answered)
}

/// The highest rate of answers of a robot whose packets can be asked for, a Create, to a program that asks for the
/// largest group of them again when it has the answer, and that thinks as long as the scenario states. It sends no
/// commands.
fn queries(plan: &Plan<'_>) -> Option<Rate> {
    let (group, bytes) = plan.spec.firmware.protocol.largest_query()?;
    let bytes = bytes as u64;
    let link = &plan.spec.link;
    let robot = QUERY_BYTES * plan.receiving_ns()
        + plan.spec.processor.obeying_ns
        + if plan.spec.is_onboard() { 0 } else { bytes * plan.spec.processor.framing_ns_per_byte };
    Some(Rate {
        what: format!("queries of group {group}, {bytes} bytes"),
        most_per_s: per_s(1, robot + asking_ns(link, QUERY_BYTES, bytes) + plan.thinking().least_ns),
        typical_per_s: None,
        limits: false,
    })
}

/// A letter and the end of its line, which ask for readings or positions.
const POLL_BYTES: u64 = 2;

/// 142 and the number of a packet or a group.
const QUERY_BYTES: u64 = 2;

fn per_s(count: u64, within_ns: u64) -> Option<f64> {
    (within_ns > 0).then(|| count as f64 / within_ns as f64 * 1e9)
}

/// Each resource that an exchange needs, and how many exchanges a second it allows.
fn limits(plan: &Plan<'_>, bounds: &Bounds) -> Vec<(String, Option<f64>)> {
    let link = &plan.spec.link;
    let often = |what: &str, ns: u64| (what.to_string(), (ns > 0).then(|| 1e9 / ns as f64));
    let mut limits = alloc::vec![often("steps of the brain", plan.brain_ns())];
    if let Mode::Stream(frame) = plan.spec.firmware.mode {
        limits.push(often("frames", frame.period_ns()));
    } else if bounds.takes_turns {
        limits.push(often("round trips", round_trip_ns(plan, bounds)));
    }
    limits.push(("messages up".to_string(), most_messages(link, bounds.pattern.bytes.least)));
    limits.push(("commands down".to_string(), most_messages(link, plan.command_bytes().least)));
    limits.push(("processor".to_string(), processor(plan, bounds)));
    limits
}

/// Messages of so many bytes that a line can carry in a second.
fn most_messages(link: &Link, bytes: u64) -> Option<f64> {
    let bytes = bytes as f64;
    match link {
        Link::Ideal | Link::Onboard => None,
        Link::Uart(uart) => Some(f64::from(uart.baud) / f64::from(uart.bits_per_character) / bytes),
        Link::Usb(usb) => Some(f64::from(usb.bytes_per_frame) / bytes * 1e9 / usb.frame_ns as f64),
    }
    .filter(|per_s| per_s.is_finite())
}

/// The part of the processor that reading the sensors leaves for framing and obeying. If reads are left out, their
/// number is unknown.
fn processor(plan: &Plan<'_>, bounds: &Bounds) -> Option<f64> {
    let reads = plan
        .on_wire()
        .iter()
        .map(|sensor| plan.read_ns(sensor).least as f64 / sensor.schedule.period_ns() as f64);
    let exchange_ns = bounds.framing.least + plan.command_ns() + on_board_ns(plan);
    let left = if bounds.reads_all { (1.0 - reads.sum::<f64>()).max(0.0) } else { 1.0 };
    (exchange_ns > 0).then(|| left / exchange_ns as f64 * 1e9)
}

fn on_board_ns(plan: &Plan<'_>) -> u64 {
    if plan.spec.is_onboard() { plan.spec.thinking_ns } else { 0 }
}

/// A polled robot does one thing after the other: the least time from a message to the next.
fn round_trip_ns(plan: &Plan<'_>, bounds: &Bounds) -> u64 {
    let link = &plan.spec.link;
    let turn = turnaround_ns(link).unwrap_or(0);
    let (up, down) = (wire::hold_up_ns(link).least, wire::hold_down_ns(link).least);
    let robot = (plan.least_obeying_ns() + bounds.framing.least).max(turn);
    let laptop = (up + plan.thinking().least_ns + down).max(turn);
    let bytes = bounds.pattern.bytes.least;
    let wires = wire::least_ns(link, bytes + plan.acknowledgement_bytes())
        + wire::least_ns(link, plan.command_bytes().least);
    let least = robot + laptop + wires;
    match adapter(link) {
        // A message that does not end with a full packet ends with the timer, which the one before restarted.
        Adapter::Ftdi(ftdi) if has_rest(bounds, ftdi.packet_bytes) => least.max(ftdi.latency_ns),
        Adapter::Ftdi(_) | Adapter::None | Adapter::Cdc(_) | Adapter::Bluetooth(_) => least,
    }
}

fn has_rest(bounds: &Bounds, packet_bytes: u32) -> bool {
    let bytes = bounds.pattern.bytes;
    (bytes.least..=bytes.most).all(|bytes| bytes % u64::from(packet_bytes.max(1)) != 0)
}

/// The rate of new readings of each sensor.
fn sensors(plan: &Plan<'_>) -> impl Iterator<Item = Rate> {
    let spread = plan.noise;
    plan.spec.sensors.iter().map(move |sensor| {
        let clock_ns = |clock: &baudbot_sim::sensor::OwnClock| {
            clock.period_ns - if spread { clock.spread_ns } else { 0 }
        };
        let own_ns = sensor.own_clock.as_ref().map(clock_ns);
        let (what, most) = match &sensor.port {
            None => ("sensor", per_s(1, sensor.schedule.period_ns())),
            Some(port) => {
                let by_cable = most_messages(&port.link, wire::port_bytes(sensor).least);
                let by_clock = own_ns.and_then(|ns| per_s(1, ns));
                ("port", [by_cable, by_clock].into_iter().flatten().reduce(f64::min))
            }
        };
        let usual = sensor.port.as_ref().and_then(|port| {
            let bytes = port.format.message_len(&sensor.device) as u64;
            let clock_ns = sensor.own_clock?.period_ns;
            // The device sends the first measurement that finds the cable idle.
            per_s(1, port.link.burst_ns(bytes).div_ceil(clock_ns).max(1) * clock_ns)
        });
        Rate {
            what: format!("{what} {}", sensor.name),
            most_per_s: most,
            typical_per_s: usual,
            limits: false,
        }
    })
}
