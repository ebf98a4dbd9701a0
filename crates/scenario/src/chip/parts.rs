//! The parts of a board on its pins, and the devices of the robot that they belong to.

mod wheels;

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_board::{
    Compass, HcSr04, Kind, Led, LitBy, Net, Piezo, Ping, Pull, RangeFinder, Reflectance, ServoKind, Switch,
    Voltage, Wiring,
};
use baudbot_fields::number::Number;
use baudbot_fields::{FieldError, Path};
use baudbot_sim::actuator::ActuatorKind;
use baudbot_sim::chip::{Attached, Comparator, LowWhen, Side, Source};
use baudbot_sim::sensor::{Component, Device, Sensor};
use baudbot_wire::Encoding;

use super::{Parts, Result, options};
use crate::pins::Options;

/// The connections of the pins.
pub(super) struct Wires {
    pub(super) wiring: Wiring,
    pub(super) attached: Vec<Attached>,
    /// The names of what a person operates.
    pub(super) controls: Vec<String>,
}

/// A part, as far as it is known.
struct Part<'a> {
    name: String,
    /// The place at which the part was named first.
    path: &'a Path,
    belongs: Belongs<'a>,
    /// The terminals that are used.
    terminals: Vec<Used<'a>>,
}

/// A terminal that is used.
struct Used<'a> {
    path: &'a Path,
    pin: &'a str,
    terminal: &'a str,
    options: &'a Options,
}

#[derive(Clone, Copy)]
enum Belongs<'a> {
    Sensor(usize, &'a Sensor),
    Value(usize, &'a Sensor, usize),
    Wheel(Side, &'a Sensor),
    Motor(Side),
    Actuator(usize),
    Led,
    Buzzer,
    /// A button or a switch, by its place among the controls.
    Contact(usize),
    Potentiometer(usize),
}

/// The parts that these connections are of.
pub(super) fn wires(path: &Path, connections: &[(Path, &str, Options)], robot: &Parts<'_>) -> Result<Wires> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    let mut controls = Vec::new();
    for (at, pin, options) in connections {
        let (name, belongs, terminal) = match control(&options.to, &mut controls) {
            Some(belongs) => (options.to.clone(), belongs, ""),
            None => target(at, &options.to, robot)?,
        };
        let place = parts.iter().position(|part| part.name == name);
        let place = place.unwrap_or_else(|| {
            parts.push(Part { name, path: at, belongs, terminals: Vec::new() });
            parts.len() - 1
        });
        parts[place].terminals.push(Used { path: at, pin, terminal, options });
    }
    let mut builder = Wiring::builder();
    let mut attached = Vec::new();
    for part in &parts {
        let (kind, belongs) = part.kind(robot)?;
        builder = builder.part(&*part.name, kind);
        for Used { path, pin, terminal, options } in &part.terminals {
            options::check(path, options, (&kind, &belongs), part.is_floor())?;
            let full =
                if terminal.is_empty() { part.name.clone() } else { format!("{}.{terminal}", part.name) };
            builder = builder.connect(*pin, full);
        }
        attached.push(belongs);
    }
    let wiring = builder.build().map_err(|error| path.error(error.to_string()))?;
    Ok(Wires { wiring, attached, controls })
}

/// The control that `text` names, if it names one, which is among the others then.
fn control<'a>(text: &str, controls: &mut Vec<String>) -> Option<Belongs<'a>> {
    let (group, _) = text.split_once('.').filter(|(_, name)| !name.is_empty() && !name.contains('.'))?;
    let belongs = match group {
        "buttons" | "switches" => Belongs::Contact,
        "potentiometers" => Belongs::Potentiometer,
        _ => return None,
    };
    let place = controls.iter().position(|known| known == text).unwrap_or_else(|| {
        controls.push(text.into());
        controls.len() - 1
    });
    Some(belongs(place))
}

/// The target of `text`: the part's name, its device, and the terminal.
fn target<'a>(path: &Path, text: &'a str, robot: &Parts<'a>) -> Result<(String, Belongs<'a>, &'a str)> {
    let (group, rest) = text.split_once('.').unwrap_or((text, ""));
    let (name, terminal) = rest.split_once('.').unwrap_or((rest, ""));
    match group {
        "sensors" => sensor(path, name, terminal, robot),
        "encoders" => {
            let sensor = robot.sensors.iter().find(|sensor| matches!(sensor.device, Device::Encoders(_)));
            let sensor = sensor.ok_or_else(|| path.error("the robot has no sensor of kind \"encoders\""))?;
            wheel_of(path, sensor, name, terminal)
        }
        "motors" => {
            let side = side(path, name)?;
            Ok((format!("motors.{name}"), Belongs::Motor(side), terminal))
        }
        "actuators" => {
            let place = robot.actuators.iter().position(|actuator| actuator.name == name);
            let known = || robot.actuators.iter().map(|actuator| &*actuator.name).collect::<Vec<_>>();
            let place = place.ok_or_else(|| unknown(path, "actuator", name, &known()))?;
            Ok((format!("actuators.{name}"), Belongs::Actuator(place), terminal))
        }
        "leds" if !name.is_empty() => Ok((format!("leds.{name}"), Belongs::Led, terminal)),
        "buzzers" if !name.is_empty() => Ok((format!("buzzers.{name}"), Belongs::Buzzer, terminal)),
        _ => Err(path.error(format!(
            "`{text}` is not something that a pin can be connected to; there are sensors.NAME, encoders.left, motors.left, \
             actuators.NAME, leds.NAME, buzzers.NAME, buttons.NAME, switches.NAME and potentiometers.NAME, each with a terminal behind a \
             dot where it has several"
        ))),
    }
}

fn side(path: &Path, name: &str) -> Result<Side> {
    match name {
        "left" => Ok(Side::Left),
        "right" => Ok(Side::Right),
        _ => Err(path.error(format!("`{name}` is not a wheel; there are left and right"))),
    }
}

fn unknown(path: &Path, what: &str, name: &str, known: &[&str]) -> FieldError {
    if known.is_empty() {
        return path.error(format!("the robot has no {what} `{name}`, and no others"));
    }
    path.error(format!("the robot has no {what} `{name}`; there are {}", known.join(", ")))
}

fn sensor<'a>(
    path: &Path,
    name: &str,
    terminal: &'a str,
    robot: &Parts<'a>,
) -> Result<(String, Belongs<'a>, &'a str)> {
    let place = robot.sensors.iter().position(|sensor| sensor.name == name);
    let known = || robot.sensors.iter().map(|sensor| &*sensor.name).collect::<Vec<_>>();
    let place = place.ok_or_else(|| unknown(path, "sensor", name, &known()))?;
    let sensor = &robot.sensors[place];
    if !sensor.is_on_wire() {
        let problem = format!("sensor `{name}` has a port of its own to the laptop, and is on no pin");
        return Err(path.error(problem));
    }
    if let Device::Encoders(_) = sensor.device {
        let (wheel, terminal) = terminal.split_once('.').unwrap_or((terminal, ""));
        return wheel_of(path, sensor, wheel, terminal);
    }
    // By its name, or by that without its unit: `left_m_s2`, `left`.
    let components = sensor.device.components();
    let is_meant = |component: &Component| {
        let quantity = component.name.split('_').next().unwrap_or_default();
        !terminal.is_empty() && (component.name == terminal || quantity == terminal)
    };
    if let Some(value) = components.iter().position(is_meant) {
        return Ok((format!("sensors.{name}.{terminal}"), Belongs::Value(place, sensor, value), ""));
    }
    if components.len() > 1 {
        let names: Vec<_> = components.iter().map(|component| component.name).collect();
        let problem = format!(
            "sensor `{name}` has several values: name one of {}, as in sensors.{name}.{}",
            names.join(", "),
            names[0]
        );
        return Err(path.error(problem));
    }
    Ok((format!("sensors.{name}"), Belongs::Sensor(place, sensor), terminal))
}

fn wheel_of<'a>(
    path: &Path,
    sensor: &'a Sensor,
    wheel: &str,
    terminal: &'a str,
) -> Result<(String, Belongs<'a>, &'a str)> {
    if wheel.is_empty() {
        return Err(path.error("encoders have a part for each wheel: encoders.left.a, encoders.right.a"));
    }
    Ok((format!("encoders.{wheel}"), Belongs::Wheel(side(path, wheel)?, sensor), terminal))
}

impl Part<'_> {
    fn uses(&self, terminal: &str) -> bool {
        self.terminals.iter().any(|used| used.terminal == terminal)
    }

    /// An option that any of its connections has.
    fn option<T: Copy>(&self, get: impl Fn(&Options) -> Option<T>) -> Option<T> {
        self.terminals.iter().find_map(|used| get(used.options))
    }

    fn is_floor(&self) -> bool {
        matches!(self.belongs, Belongs::Sensor(_, Sensor { device: Device::Floor(_), .. }))
    }

    /// The kind of the part, and its device.
    fn kind(&self, robot: &Parts<'_>) -> Result<(Kind, Attached)> {
        match self.belongs {
            Belongs::Sensor(place, sensor) => self.sensor(place, sensor),
            Belongs::Value(place, sensor, value) => self.voltage(place, sensor, value),
            Belongs::Wheel(side, sensor) => Ok((self.encoder(sensor)?, Attached::Wheel(side))),
            Belongs::Motor(side) => self.motor(side, robot.motors),
            Belongs::Actuator(place) => {
                let kind = match &robot.actuators[place].kind {
                    ActuatorKind::Turret(_) => Kind::Servo(ServoKind::Standard),
                    ActuatorKind::Lamp(_) | ActuatorKind::Dispenser(_) => Kind::Led(self.led()),
                    ActuatorKind::Speaker { .. } => Kind::Piezo(Piezo),
                };
                Ok((kind, Attached::Actuator(place)))
            }
            Belongs::Led => Ok((Kind::Led(self.led()), Attached::Board)),
            Belongs::Buzzer => Ok((Kind::Piezo(Piezo), Attached::Board)),
            Belongs::Contact(place) => {
                let bounce_ms = self.option(|options| options.bounce_ms).map_or(BOUNCE_MS, Number::get);
                let switch = self.switch(&self.name, (bounce_ms * 1e3) as u32);
                Ok((Kind::Switch(switch), Attached::Control(place)))
            }
            Belongs::Potentiometer(place) => Ok((Kind::Voltage(Voltage::DIRECT), Attached::Control(place))),
        }
    }

    fn led(&self) -> Led {
        Led { lit_by: self.option(|options| options.lit_by).unwrap_or(LitBy::High) }
    }

    /// The kind of a sonar, by its terminals.
    fn sonar(&self) -> Kind {
        if self.uses("sda") || self.uses("scl") {
            Kind::RangeFinder(RangeFinder::SRF02)
        } else if self.uses("trigger") || self.uses("echo") {
            Kind::HcSr04(HcSr04)
        } else {
            Kind::Ping(Ping)
        }
    }

    fn sensor(&self, place: usize, sensor: &Sensor) -> Result<(Kind, Attached)> {
        match &sensor.device {
            Device::Sonar(_) => Ok((self.sonar(), Attached::Sonar { sensor: place })),
            Device::Compass(_) => Ok((Kind::Compass(Compass), Attached::Compass { sensor: place })),
            Device::Whisker(baudbot_sim::sensor::Whisker { switch, .. })
            | Device::Bumper(baudbot_sim::sensor::Bumper { switch, .. }) => {
                let bounce_us = u32::try_from(switch.bounce_ns / 1000).unwrap_or(u32::MAX);
                Ok((Kind::Switch(self.switch(&sensor.name, bounce_us)), Attached::Contact { sensor: place }))
            }
            Device::Floor(_) if self.threshold_v().is_none() && self.is_timed() => {
                Ok((Kind::Reflectance(Reflectance), Attached::Reflectance { sensor: place, value: 0 }))
            }
            Device::Floor(_)
            | Device::Infrared(_)
            | Device::VoltageRanger(_)
            | Device::Light(_)
            | Device::Field(_)
            | Device::Microphone(_)
            | Device::Battery(_)
            | Device::Accelerometer(_)
            | Device::Gyroscope(_)
            | Device::StrainGauge(_) => self.voltage(place, sensor, 0),
            Device::Encoders(_)
            | Device::Photoresistor(_)
            | Device::Laser(_)
            | Device::LineCamera(_)
            | Device::Camera(_)
            | Device::StepCounter(_)
            | Device::Odometer(_)
            | Device::OpticalFlow(_)
            | Device::Gps(_)
            | Device::IrBeacons(_) => {
                let problem = format!("a sensor of kind \"{}\" has no pins here", sensor.device.kind());
                Err(self.path.error(problem))
            }
        }
    }

    /// Whether it is a reflectance sensor that discharges a capacitor: on a pin without an ADC it can be nothing else.
    fn is_timed(&self) -> bool {
        let on_adc = |used: &Used<'_>| Net::by_name(used.pin).and_then(Net::adc_channel).is_some();
        self.option(|options| options.rc).unwrap_or_else(|| !self.terminals.iter().all(on_adc))
    }

    /// The threshold of the comparator that it is before, in volts.
    fn threshold_v(&self) -> Option<f64> {
        self.option(|options| options.threshold_v).map(Number::get)
    }

    /// A switch, which bounces as its sensor does.
    fn switch(&self, name: &str, bounce_us: u32) -> Switch {
        let pull = self.option(|options| options.pull).unwrap_or(Pull::Internal);
        let seed = name.bytes().fold(1, |seed: u64, byte| seed.wrapping_mul(31).wrapping_add(byte.into()));
        Switch { pull, bounce_us, seed }
    }

    /// A value as a voltage: as it is, if it is one; else the range of its code is that of the supply.
    fn voltage(&self, place: usize, sensor: &Sensor, component: usize) -> Result<(Kind, Attached)> {
        let components = sensor.device.components();
        let value = components.iter().take(component).map(|component| component.count).sum();
        let in_volts = components.get(component).is_some_and(|component| component.unit == "V");
        let usual = match (in_volts, sensor.encodings.get(value)) {
            (true, _) => Some((0.0, 1.0)),
            // Light that comes back pulls the output of a reflectance sensor down.
            (false, _) if matches!(sensor.device, Device::Floor(_)) => Some((SUPPLY_V, -SUPPLY_V)),
            (false, Some(&Encoding::Level { min, max, .. })) if min < max => {
                Some((-min * SUPPLY_V / (max - min), SUPPLY_V / (max - min)))
            }
            (false, _) => None,
        };
        let given = self.option(|options| options.volts_per_unit.map(Number::get));
        let Some(volts_per_unit) = given.or_else(|| usual.map(|usual| usual.1)) else {
            let problem = format!(
                "needs volts_per_unit, {{ to = \"…\", volts_per_unit = 0.01 }}: sensor `{}` has no `bits` that would say which \
                 voltage stands for which value",
                sensor.name
            );
            return Err(self.path.error(problem));
        };
        let volts_at_0 = self.option(|options| options.volts_at_0.map(Number::get));
        let volts_at_0 = volts_at_0
            .unwrap_or_else(|| if given.is_some() { 0.0 } else { usual.map_or(0.0, |usual| usual.0) });
        let source = Source { sensor: place, value, volts_at_0, volts_per_unit };
        if let Some(threshold_v) = self.threshold_v() {
            let hysteresis_v = self.option(|options| options.hysteresis_v).map_or(HYSTERESIS_V, Number::get);
            let low_when = self.option(|options| options.low_when).unwrap_or(LowWhen::Below);
            // An open collector with a resistor to the supply is to the chip what a switch to ground is that does not bounce.
            let output = Switch { pull: Pull::External, bounce_us: 0, seed: 0 };
            let comparator = Comparator { source, threshold_v, hysteresis_v, low_when };
            return Ok((Kind::Switch(output), Attached::Comparator(comparator)));
        }
        let ratio = self.option(|options| options.divider).map_or(1.0, Number::get);
        Ok((Kind::Voltage(Voltage { ratio }), Attached::Voltage(source)))
    }
}

/// The chip's supply, in volts.
const SUPPLY_V: f64 = 5.0;

/// The longest bounce of a push-button in milliseconds: 1 to 10 are usual.
const BOUNCE_MS: f64 = 5.0;

/// The band of a comparator's module, in volts: the resistor from its output back to its input makes some tens of millivolts.
const HYSTERESIS_V: f64 = 0.02;
