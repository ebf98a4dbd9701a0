//! Details of robots for observers.

use baudbot_proto::v1;
use baudbot_sim::timeline::{Event, What};

use super::pins;
use super::status::{cycle_status, line_status};
use crate::frame::{RayFan, RobotDetail, SensorDetail};

pub(super) fn detail(detail: RobotDetail) -> v1::RobotDetail {
    let [uplink_waiting_bytes, downlink_waiting_bytes] = detail.under_way;
    v1::RobotDetail {
        robot: detail.robot as u32,
        at_ns: detail.at.map(|at| at.as_ns()),
        sensors: detail.sensors.into_iter().map(sensor).collect(),
        uplink: Some(line_status(&detail.uplink)),
        downlink: Some(line_status(&detail.downlink)),
        uplink_waiting_bytes,
        downlink_waiting_bytes,
        cycles: Some(cycle_status(&detail.cycles, detail.deadline_ns)),
        events: detail.events.iter().map(event).collect(),
        missed_events: detail.missed_events,
        pin_events: detail.pin_events.iter().map(pins::event).collect(),
        missed_pin_events: detail.missed_pin_events,
        attached: detail.brain.is_some(),
        brain: detail.brain.unwrap_or_default(),
        cable_pulled: detail.cable_pulled,
        baud: detail.baud,
    }
}

fn sensor(sensor: SensorDetail) -> v1::SensorDetail {
    v1::SensorDetail {
        values: sensor.values,
        sampled_at_ns: sensor.sampled_at.map(|at| at.as_ns()),
        least_age_ns: sensor.ages_ns.map(|(least_ns, _)| least_ns),
        most_age_ns: sensor.ages_ns.map(|(_, most_ns)| most_ns),
        readable: sensor.readable,
        samples: sensor.samples,
        missed: sensor.missed,
        readable_steps: sensor.readable_steps,
        rays: sensor.rays.map(rays),
        port: sensor.port.as_ref().map(line_status),
    }
}

fn rays(rays: RayFan) -> v1::RayFan {
    let pose = rays.world_from_sensor;
    v1::RayFan {
        x_m: pose.position.x,
        y_m: pose.position.y,
        heading_rad: pose.heading,
        opening_rad: rays.opening_rad,
        lengths_m: rays.lengths_m,
    }
}

fn event(event: &Event) -> v1::TimelineEvent {
    let (kind, part, bytes) = kind(event.what);
    v1::TimelineEvent {
        start_ns: event.start.as_ns(),
        end_ns: event.end.as_ns(),
        kind: kind.into(),
        part,
        bytes,
    }
}

/// The kind of an event, with the sensor or the fault, and with bytes.
fn kind(what: What) -> (v1::TimelineKind, Option<u32>, u32) {
    use v1::TimelineKind as Kind;
    match what {
        What::Acquire { sensor } => (Kind::Acquire, Some(sensor.into()), 0),
        What::Measure { sensor } => (Kind::Measure, Some(sensor.into()), 0),
        What::Frame { bytes } => (Kind::Frame, None, bytes),
        What::Block => (Kind::Block, None, 0),
        What::Up { bytes } => (Kind::Up, None, bytes),
        What::Adapter => (Kind::Adapter, None, 0),
        What::Port { sensor, bytes } => (Kind::Port, Some(sensor.into()), bytes),
        What::PortDown { sensor, bytes } => (Kind::PortDown, Some(sensor.into()), bytes),
        What::Think { informed } => (Kind::Think, Some(informed.into()), 0),
        What::Down { bytes } => (Kind::Down, None, bytes),
        What::Obey => (Kind::Obey, None, 0),
        What::Act => (Kind::Act, None, 0),
        What::Late => (Kind::Late, None, 0),
        What::Missed { sensor } => (Kind::Missed, (sensor != u16::MAX).then_some(sensor.into()), 0),
        What::Lost { bytes } => (Kind::Lost, None, bytes),
        What::Fault { fault } => (Kind::Fault, Some(fault.into()), 0),
    }
}
