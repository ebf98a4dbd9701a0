//! What a brain is told, and what it says.

use baudbot_proto::v1;
use baudbot_sim::SimTime;
use baudbot_sim::actuator::{Actuator, ActuatorKind};
use baudbot_sim::drive::Wheels;
use baudbot_sim::firmware::{Mode, Protocol};
use baudbot_sim::link::Link;
use baudbot_sim::port::{Format, Port};
use baudbot_sim::robot::RobotSpec;
use baudbot_sim::sensor::{Component, Device, Sensor};
use baudbot_wire::Encoding;
use tonic::Status;

use crate::endpoint::{Output, Signals, Thinking, Until, Write};
use crate::message::{Attached, Delivery, RobotDelivery};

/// What a brain may know of its robots.
pub(crate) fn welcome(attached: &Attached) -> v1::AttachResponse {
    let scenario = &attached.scenario;
    let robots = attached.robots.iter().map(|&i| description(&scenario.robots()[i])).collect();
    let welcome = v1::Welcome { step_ns: scenario.step_ns(), lockstep: attached.lockstep, robots };
    response(v1::attach_response::Response::Welcome(welcome))
}

fn response(response: v1::attach_response::Response) -> v1::AttachResponse {
    v1::AttachResponse { response: Some(response) }
}

pub(super) fn description(spec: &RobotSpec) -> v1::RobotDescription {
    let (baud, bits_per_character) = characters(&spec.link);
    v1::RobotDescription {
        robot: spec.name.clone(),
        radius_m: spec.drive.radius_m,
        half_track_m: spec.drive.half_track_m,
        wheel_radius_m: spec.drive.wheel_radius_m,
        signal_limit: spec.signal_limit,
        motor_encoding: Some(encoding(spec.firmware.motor_encoding())),
        sensors: spec.sensors.iter().map(sensor).collect(),
        firmware: Some(firmware(spec)),
        baud,
        bits_per_character,
        actuators: spec.actuators.iter().map(actuator).collect(),
        motor_kind: spec.drive.motor.kind().to_owned(),
        onboard: matches!(spec.link, Link::Onboard),
        operations_per_s: spec.processor.operations_per_s,
        ram_bytes: spec.processor.ram_bytes,
    }
}

/// Baud rate and bits a character, if it is a serial cable.
fn characters(link: &Link) -> (Option<u32>, Option<u32>) {
    match link {
        Link::Ideal | Link::Onboard | Link::Usb(_) => (None, None),
        Link::Uart(uart) => (Some(uart.baud), Some(uart.bits_per_character.into())),
    }
}

fn actuator(spec: &Actuator) -> v1::ActuatorDescription {
    let range = match &spec.kind {
        ActuatorKind::Turret(servo) => Some(servo.range_rad),
        ActuatorKind::Lamp { .. } | ActuatorKind::Speaker { .. } => None,
    };
    v1::ActuatorDescription {
        actuator: spec.name.clone(),
        kind: spec.kind().to_owned(),
        min_rad: range.map(|[min, _]| min),
        max_rad: range.map(|[_, max]| max),
    }
}

fn firmware(spec: &RobotSpec) -> v1::Firmware {
    use v1::firmware::{Bare, Framed, Khepera, Protocol as P};
    let protocol = match spec.firmware.protocol {
        Protocol::Framed { ages } => P::Framed(Framed { ages }),
        Protocol::Bare { gap_ns } => P::Bare(Bare { gap_ns }),
        Protocol::Khepera => P::Khepera(Khepera {}),
    };
    let period_ns = match spec.firmware.mode {
        Mode::Stream(schedule) => Some(schedule.period_ns()),
        Mode::Poll => None,
    };
    v1::Firmware { protocol: Some(protocol), period_ns }
}

fn sensor(spec: &Sensor) -> v1::SensorDescription {
    let (period_ns, phase_ns) = match spec.own_clock {
        Some(clock) if spec.port.is_some() => (clock.period_ns, clock.phase_ns.unwrap_or(0)),
        _ => (spec.schedule.period_ns(), spec.schedule.phase_ns()),
    };
    v1::SensorDescription {
        sensor: spec.name.clone(),
        kind: spec.device.kind().to_owned(),
        components: components(spec),
        period_ns,
        phase_ns,
        mount: spec.device.mount().map(|mount| v1::Mount {
            x_m: mount.pose.position.x,
            y_m: mount.pose.position.y,
            heading_rad: mount.pose.heading,
            turret: mount.turret.map(|actuator| actuator as u32),
        }),
        range_m: spec.device.range_m(),
        counts_per_turn: match &spec.device {
            Device::Encoders(encoders) => Some(encoders.counts_per_turn),
            _ => None,
        },
        port: spec.port.as_ref().map(|own| port(own, &spec.device)),
        opening_rad: spec.device.fan().map(|fan| fan.opening_rad()),
        sweep: match &spec.device {
            Device::Laser(laser) => {
                Some(v1::Sweep { duration_ns: laser.sweep_ns, clockwise: laser.clockwise })
            }
            _ => None,
        },
    }
}

/// All values of a component cross the wire in the same way.
fn components(spec: &Sensor) -> Vec<v1::ComponentDescription> {
    let mut encodings = spec.encodings.iter();
    let component = |component: &Component| {
        let first = encodings.next().copied();
        // The others of this component are the same as the first.
        encodings.by_ref().take(component.count.saturating_sub(1)).for_each(drop);
        v1::ComponentDescription {
            name: component.name.to_owned(),
            unit: component.unit.to_owned(),
            encoding: first.map(encoding),
            count: component.count as u32,
        }
    };
    spec.device.components().iter().map(component).collect()
}

fn port(port: &Port, device: &Device) -> v1::Port {
    let (baud, bits_per_character) = characters(&port.link);
    let format = match port.format {
        Format::Scip(_) => "scip2",
        Format::LineImage => "line-image",
        Format::Nmea { .. } => "nmea",
    };
    let message_bytes = port.format.message_len(device) as u64;
    v1::Port { format: format.to_owned(), message_bytes, baud, bits_per_character }
}

fn encoding(encoding: Encoding) -> v1::Encoding {
    use v1::encoding::{Counter, Float64, Kind, Level, Signed};
    let kind = match encoding {
        Encoding::Float64 => Kind::Float64(Float64 {}),
        Encoding::Level { bits, min, max } => Kind::Level(Level { bits: bits.into(), min, max }),
        Encoding::Counter { bits } => Kind::Counter(Counter { bits: bits.into() }),
        Encoding::Signed { bits, limit } => Kind::Signed(Signed { bits: bits.into(), limit }),
    };
    v1::Encoding { kind: Some(kind) }
}

/// What a brain's Step wants written.
pub(crate) fn writes(steps: Vec<v1::RobotStep>) -> Vec<Write> {
    let output = |output| match output {
        v1::robot_step::Output::Raw(bytes) => Output::Raw(bytes),
        v1::robot_step::Output::Command(v1::Command { left_signal, right_signal, other_signals }) => {
            let wheels = Wheels { left: left_signal, right: right_signal };
            Output::Command(Signals { wheels, others: other_signals })
        }
        v1::robot_step::Output::Poll(_) => Output::Poll,
    };
    let write = |step: v1::RobotStep| Write {
        slot: step.robot as usize,
        thinking: Thinking { ns: step.thinking_ns, operations: step.operations },
        output: step.output.map(output),
        until: step.until_message.map(|until| Until { at_latest: until.at_latest_ns.map(SimTime::from_ns) }),
    };
    steps.into_iter().map(write).collect()
}

/// A delivery for a brain's stream, or the stream's end.
pub(crate) fn delivery(delivery: Delivery) -> Result<v1::AttachResponse, Status> {
    use v1::attach_response::Response;
    match delivery {
        Delivery::Close(status) => Err(status),
        Delivery::Ended { tick } => Ok(response(Response::Ended(v1::Ended { tick }))),
        Delivery::Turn { number, tick, robots } => {
            let robots = robots.into_iter().map(robot_turn).collect();
            Ok(response(Response::Turn(v1::Turn { tick, robots, turn: number })))
        }
    }
}

fn robot_turn(delivery: RobotDelivery) -> v1::RobotTurn {
    let readings = delivery.readings.into_iter().map(|(sensor, reading)| v1::Reading {
        sensor: sensor as u32,
        values: reading.values,
        sampled_at_ns: reading.sampled_at.map(|at| at.as_ns()),
        sequence: reading.sequence.into(),
        readable: reading.readable,
    });
    let ports = delivery.ports.into_iter();
    v1::RobotTurn {
        robot: delivery.slot as u32,
        at_ns: delivery.at.as_ns(),
        raw: delivery.raw,
        readings: readings.collect(),
        ports: ports.map(|(sensor, data)| v1::PortBytes { sensor: sensor as u32, data }).collect(),
    }
}
