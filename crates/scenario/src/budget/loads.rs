//! The typical use of each resource.

use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

use super::bounds::Bounds;
use super::plan::{Plan, Range, turnaround_ns};
use super::report::{Chip, Load};
use super::timeline::Outcome;
use super::wire;
use baudbot_sim::firmware::Mode;
use baudbot_sim::link::Link;
use baudbot_sim::model::Writes;
use baudbot_sim::sensor::{OwnClock, Sensor};
use baudbot_sim::time::SECOND_NS;

/// The amounts that come in a nanosecond.
struct Rates {
    messages: f64,
    bytes_up: f64,
    commands: f64,
}

pub(super) fn loads(plan: &Plan<'_>, bounds: &Bounds, outcome: &Outcome) -> Vec<Load> {
    let rates = rates(plan, bounds, outcome);
    let link = &plan.spec.link;
    let command_bytes = plan.command_bytes().most as f64;
    let [up, down] = [rates.bytes_up, rates.commands * command_bytes].map(|bytes| bytes * byte_ns(link));
    let mut loads = Vec::new();
    let mut load = |what: &str, share: f64| loads.push(Load { what: what.to_string(), share });
    if let Some(turn) = turnaround_ns(link) {
        load("wire", up + down + (rates.messages + rates.commands) * turn as f64);
    } else if !matches!(link, Link::Ideal | Link::Onboard) {
        load("uplink", up);
        load("downlink", down);
    }
    if let Some(radio) = wire::radio(link) {
        let packets = radio.latency_ns as f64 + radio.burst_probability * radio.burst_ns as f64;
        let each = packets / f64::from(radio.packet_bytes.max(1));
        load("radio up", rates.bytes_up * each);
        load("radio down", rates.commands * command_bytes * each);
    }
    load("processor", processor(plan, &rates));
    for (_, sensor, clock, link) in plan.ports() {
        load(&format!("port {}", sensor.name), port_share(sensor, clock, link));
    }
    loads
}

/// The load of a sensor's own cable that carries each measurement.
pub(super) fn port_share(sensor: &Sensor, clock: &OwnClock, link: &Link) -> f64 {
    let bytes = sensor.port.as_ref().map_or(0, |port| port.format.message_len(&sensor.device));
    byte_ns(link) * bytes as f64 / clock.period_ns as f64
}

/// A stream comes as it is due, whether or not it is carried; answers come with it, or with a step of the brain. A
/// polled robot does what it can.
fn rates(plan: &Plan<'_>, bounds: &Bounds, outcome: &Outcome) -> Rates {
    let ports: f64 = plan.ports().map(|(_, _, clock, _)| 1.0 / clock.period_ns as f64).sum();
    let steps = 1.0 / plan.brain_ns() as f64;
    let ran = outcome.ran_ns.max(1) as f64;
    let obeyed = outcome.commands as f64 / ran;
    let unasked = match plan.writes() {
        Writes::OnMessage => None,
        Writes::WhenFree => Some(obeyed),
        Writes::EveryTick => Some(steps),
        Writes::AtMost(_) if plan.pause_ns() > 0 => Some(steps.min(1.0 / plan.pause_ns() as f64)),
        Writes::AtMost(_) => Some(steps * plan.commands_in_a_turn() as f64),
    };
    match plan.spec.firmware.mode {
        Mode::Stream(frame) => {
            let messages = 1.0 / frame.period_ns() as f64;
            let bytes_up = messages * bounds.pattern.mean_bytes;
            Rates { messages, bytes_up, commands: unasked.unwrap_or_else(|| steps.min(messages + ports)) }
        }
        Mode::Poll => Rates {
            messages: outcome.messages as f64 / ran,
            bytes_up: outcome.bytes_up as f64 / ran,
            commands: unasked.unwrap_or(obeyed),
        },
    }
}

fn byte_ns(link: &Link) -> f64 {
    match link {
        Link::Ideal | Link::Onboard => 0.0,
        Link::Uart(uart) => f64::from(uart.bits_per_character) / f64::from(uart.baud) * SECOND_NS as f64,
        Link::Usb(usb) => usb.frame_ns as f64 / f64::from(usb.bytes_per_frame),
    }
}

fn processor(plan: &Plan<'_>, rates: &Rates) -> f64 {
    let reads = plan
        .on_wire()
        .iter()
        .map(|sensor| plan.read_ns(sensor).middle() as f64 / sensor.schedule.period_ns() as f64);
    let framing_ns = plan.framing_ns(Range { least: 1, most: 1 }) as f64;
    let thinking =
        if plan.spec.is_onboard() { plan.spec.thinking_ns as f64 / plan.step_ns as f64 } else { 0.0 };
    reads.sum::<f64>() + rates.bytes_up * framing_ns + rates.commands * plan.command_ns() as f64 + thinking
}

/// The chip's share for the brain's program.
pub(super) fn chip(plan: &Plan<'_>) -> Chip {
    let Plan { spec, step_ns, .. } = *plan;
    let operations = |ns: u64| Some(spec.processor.operations_per_s? * ns as f64 / SECOND_NS as f64);
    Chip {
        ram_bytes: spec.processor.ram_bytes,
        brain_memory_bytes: spec.brain_memory_bytes,
        operations_per_step: operations(step_ns),
        brain_operations: operations(spec.thinking_ns).filter(|_| spec.is_onboard()),
    }
}
