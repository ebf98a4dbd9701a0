//! A robot's data sheet: everything that its brain knows of its body. The quality of a sensor, its noise and the response of
//! the motors are not in it.

use alloc::borrow::ToOwned;
use alloc::vec::Vec;

use baudbot_brain::{
    Actuator, ActuatorKind, Body, Component, Firmware, MotorKind, Mount, Port, PortFormat, Sensor, Sweep,
};

use crate::link::Link;
use crate::model::RobotSpec;
use crate::motor::Motors;
use crate::sensor::Device;
use crate::sensor::{self, port};
use crate::{actuator, firmware};

impl From<&RobotSpec> for Body {
    fn from(spec: &RobotSpec) -> Self {
        let (baud, bits_per_character) = characters(&spec.link);
        Self {
            name: spec.name.clone(),
            radius_m: spec.drive.radius_m,
            half_track_m: spec.drive.half_track_m,
            wheel_radius_m: spec.drive.wheel_radius_m,
            signal_limit: spec.signal_limit,
            motor_encoding: spec.firmware.motor_encoding(),
            motor_kind: motor_kind(&spec.drive.motor),
            actuators: spec.actuators.iter().map(actuator).collect(),
            sensors: spec.sensors.iter().map(sensor).collect(),
            firmware: firmware(&spec.firmware),
            baud,
            bits_per_character,
            onboard: matches!(spec.link, Link::Onboard),
            operations_per_s: spec.processor.operations_per_s,
            ram_bytes: spec.processor.ram_bytes,
        }
    }
}

/// Baud rate and bits a character, of a serial cable.
fn characters(link: &Link) -> (Option<u32>, Option<u32>) {
    match link {
        Link::Ideal | Link::Onboard | Link::Usb(_) => (None, None),
        Link::Uart(uart) => (Some(uart.baud), Some(uart.bits_per_character.into())),
    }
}

fn motor_kind(motors: &Motors) -> MotorKind {
    match motors {
        Motors::Dc(_) => MotorKind::Dc,
        Motors::Velocity(_) => MotorKind::Velocity,
        Motors::Servo(_) => MotorKind::Servo,
        Motors::Stepper(_) => MotorKind::Stepper,
    }
}

fn actuator(spec: &actuator::Actuator) -> Actuator {
    let (kind, range_rad) = match &spec.kind {
        actuator::ActuatorKind::Turret(servo) => (ActuatorKind::Turret, Some([servo.min_rad, servo.max_rad])),
        actuator::ActuatorKind::Lamp { .. } => (ActuatorKind::Lamp, None),
        actuator::ActuatorKind::Speaker { .. } => (ActuatorKind::Speaker, None),
        actuator::ActuatorKind::Dispenser(_) => (ActuatorKind::Dispenser, None),
    };
    Actuator { name: spec.name.clone(), kind, range_rad }
}

fn firmware(spec: &firmware::Firmware) -> Firmware {
    let period_ns = match spec.mode {
        firmware::Mode::Stream(schedule) => Some(schedule.period_ns()),
        firmware::Mode::Poll => None,
    };
    Firmware { protocol: spec.protocol, period_ns }
}

fn sensor(spec: &sensor::Sensor) -> Sensor {
    // A device that the microcontroller does not read has its own pace.
    let (period_ns, phase_ns) = match (&spec.port, spec.own_clock) {
        (Some(_), Some(clock)) => (clock.period_ns, clock.phase_ns.unwrap_or(0)),
        (Some(_), None) | (None, _) => (spec.schedule.period_ns(), spec.schedule.phase_ns()),
    };
    Sensor {
        name: spec.name.clone(),
        kind: spec.device.sensor_kind().for_brains(),
        components: components(spec),
        period_ns,
        phase_ns,
        mount: spec.device.mount().map(mount),
        range_m: spec.device.range_m(),
        counts_per_turn: if let Device::Encoders(encoders) = &spec.device {
            Some(encoders.counts_per_turn)
        } else {
            None
        },
        counts_per_m: if let Device::OpticalFlow(flow) = &spec.device {
            Some(flow.counts_per_m)
        } else {
            None
        },
        port: spec.port.as_ref().map(|own| port(own, &spec.device)),
        opening_rad: spec.device.fan().map(|fan| fan.opening_rad()),
        columns: if let Device::Camera(camera) = &spec.device { Some(camera.columns.into()) } else { None },
        sweep: if let Device::Laser(laser) = &spec.device {
            Some(Sweep { duration_ns: laser.sweep_ns, clockwise: laser.clockwise })
        } else {
            None
        },
    }
}

/// All values of a component cross the wire in the same way.
fn components(spec: &sensor::Sensor) -> Vec<Component> {
    let mut first = 0;
    let component = |component: &sensor::Component| {
        let encoding = spec.encodings[first];
        first += component.count;
        let (name, unit) = (component.name.to_owned(), component.unit.to_owned());
        Component { name, unit, encoding, count: component.count }
    };
    spec.device.components().iter().map(component).collect()
}

fn mount(spec: &sensor::Mount) -> Mount {
    let (x_m, y_m) = (spec.pose.position.x, spec.pose.position.y);
    Mount { x_m, y_m, heading_rad: spec.pose.heading, turret: spec.turret, elevation_rad: spec.elevation_rad }
}

fn port(spec: &port::Port, device: &Device) -> Port {
    let (baud, bits_per_character) = characters(&spec.link);
    let format = match spec.format {
        port::Format::Scip(_) => PortFormat::Scip2,
        port::Format::LineImage => PortFormat::LineImage,
        port::Format::Nmea { .. } => PortFormat::Nmea,
    };
    let message_bytes = spec.format.message_len(device) as u64;
    Port { format, message_bytes, baud, bits_per_character }
}
