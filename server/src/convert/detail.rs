//! The parts of robots' details for observers.

use baudbot_proto::v1;
use baudbot_sim::Pose;
use baudbot_sim::timeline::{Event, What};

/// The rays of a sensor as they run now, from its place in the world.
pub(crate) fn ray_fan(sensor: Pose, opening_rad: f64, lengths_m: Vec<f32>) -> v1::RayFan {
    let Pose { position, heading: heading_rad } = sensor;
    v1::RayFan { x_m: position.x, y_m: position.y, heading_rad, opening_rad, lengths_m }
}

/// An event of a robot's timeline.
pub(crate) fn timeline_event(event: &Event) -> v1::TimelineEvent {
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
