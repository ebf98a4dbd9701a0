//! A robot's data sheet, in both directions, part by part.

use baudbot_brain::{
    Actuator, Body, Component, CreateVersion, Encoding, Firmware, Mount, Port, Protocol, Sensor, Sweep,
};

use super::breach::Breach;
use crate::v1;
use crate::v1::encoding::{Counter, Float64, Kind, Level, Signed};
use crate::v1::firmware::{Asercom, Bare, Create, Framed, Khepera, Protocol as Spoken};

impl From<&Body> for v1::RobotDescription {
    fn from(body: &Body) -> Self {
        Self {
            robot: body.name.clone(),
            radius_m: body.radius_m,
            half_track_m: body.half_track_m,
            wheel_radius_m: body.wheel_radius_m,
            signal_limit: body.signal_limit,
            motor_encoding: Some(body.motor_encoding.into()),
            sensors: body.sensors.iter().map(Into::into).collect(),
            firmware: Some(body.firmware.into()),
            baud: body.baud,
            bits_per_character: body.bits_per_character,
            actuators: body.actuators.iter().map(Into::into).collect(),
            motor_kind: v1::MotorKind::from(body.motor_kind).into(),
            onboard: body.onboard,
            operations_per_s: body.operations_per_s,
            ram_bytes: body.ram_bytes,
        }
    }
}

impl TryFrom<v1::RobotDescription> for Body {
    type Error = Breach;

    /// The body, if it is whole and its cable can have the encodings that it names.
    fn try_from(given: v1::RobotDescription) -> Result<Self, Breach> {
        let body = Self {
            motor_kind: given.motor_kind().into(),
            name: given.robot,
            radius_m: given.radius_m,
            half_track_m: given.half_track_m,
            wheel_radius_m: given.wheel_radius_m,
            signal_limit: given.signal_limit,
            motor_encoding: encoding(given.motor_encoding, "RobotDescription", "motor_encoding")?,
            actuators: given.actuators.into_iter().map(Into::into).collect(),
            sensors: given.sensors.into_iter().map(TryInto::try_into).collect::<Result<_, _>>()?,
            firmware: firmware(given.firmware)?,
            baud: given.baud,
            bits_per_character: given.bits_per_character,
            onboard: given.onboard,
            operations_per_s: given.operations_per_s,
            ram_bytes: given.ram_bytes,
        };
        match body.layout().agreement().check() {
            Ok(()) => Ok(body),
            Err(source) => Err(Breach::Layout { robot: body.name, source }),
        }
    }
}

impl From<&Actuator> for v1::ActuatorDescription {
    fn from(Actuator { name, kind, range_rad }: &Actuator) -> Self {
        let [min_rad, max_rad] = [0, 1].map(|end| range_rad.map(|range| range[end]));
        Self { actuator: name.clone(), kind: v1::ActuatorKind::from(*kind).into(), min_rad, max_rad }
    }
}

impl From<v1::ActuatorDescription> for Actuator {
    fn from(given: v1::ActuatorDescription) -> Self {
        let kind = given.kind().into();
        let v1::ActuatorDescription { actuator, min_rad, max_rad, .. } = given;
        let range_rad = min_rad.zip(max_rad).map(|(min, max)| [min, max]);
        Self { name: actuator, kind, range_rad }
    }
}

impl From<&Sensor> for v1::SensorDescription {
    fn from(sensor: &Sensor) -> Self {
        Self {
            sensor: sensor.name.clone(),
            kind: v1::SensorKind::from(sensor.kind).into(),
            components: sensor.components.iter().map(Into::into).collect(),
            period_ns: sensor.period_ns,
            phase_ns: sensor.phase_ns,
            mount: sensor.mount.map(Into::into),
            range_m: sensor.range_m,
            counts_per_turn: sensor.counts_per_turn,
            counts_per_m: sensor.counts_per_m,
            port: sensor.port.as_ref().map(Into::into),
            opening_rad: sensor.opening_rad,
            sweep: sensor.sweep.map(|Sweep { duration_ns, clockwise }| v1::Sweep { duration_ns, clockwise }),
            columns: sensor.columns,
        }
    }
}

impl TryFrom<v1::SensorDescription> for Sensor {
    type Error = Breach;

    fn try_from(given: v1::SensorDescription) -> Result<Self, Breach> {
        Ok(Self {
            kind: given.kind().into(),
            name: given.sensor,
            components: given.components.into_iter().map(TryInto::try_into).collect::<Result<_, _>>()?,
            period_ns: given.period_ns,
            phase_ns: given.phase_ns,
            mount: given.mount.map(Into::into),
            range_m: given.range_m,
            counts_per_turn: given.counts_per_turn,
            counts_per_m: given.counts_per_m,
            port: given.port.map(Into::into),
            opening_rad: given.opening_rad,
            sweep: given.sweep.map(|v1::Sweep { duration_ns, clockwise }| Sweep { duration_ns, clockwise }),
            columns: given.columns,
        })
    }
}

impl From<Mount> for v1::Mount {
    fn from(Mount { x_m, y_m, heading_rad, turret, elevation_rad }: Mount) -> Self {
        Self { x_m, y_m, heading_rad, turret: turret.map(|place| place as u32), elevation_rad }
    }
}

impl From<v1::Mount> for Mount {
    fn from(v1::Mount { x_m, y_m, heading_rad, turret, elevation_rad }: v1::Mount) -> Self {
        Self { x_m, y_m, heading_rad, turret: turret.map(|place| place as usize), elevation_rad }
    }
}

impl From<&Port> for v1::Port {
    fn from(Port { format, message_bytes, baud, bits_per_character }: &Port) -> Self {
        Self {
            format: v1::PortFormat::from(*format).into(),
            message_bytes: *message_bytes,
            baud: *baud,
            bits_per_character: *bits_per_character,
        }
    }
}

impl From<v1::Port> for Port {
    fn from(given: v1::Port) -> Self {
        let v1::Port { message_bytes, baud, bits_per_character, .. } = given;
        Self { format: given.format().into(), message_bytes, baud, bits_per_character }
    }
}

impl From<&Component> for v1::ComponentDescription {
    fn from(Component { name, unit, encoding, count }: &Component) -> Self {
        let count = u32::try_from(*count).unwrap_or(u32::MAX);
        Self { name: name.clone(), unit: unit.clone(), encoding: Some((*encoding).into()), count }
    }
}

impl TryFrom<v1::ComponentDescription> for Component {
    type Error = Breach;

    fn try_from(given: v1::ComponentDescription) -> Result<Self, Breach> {
        let encoding = encoding(given.encoding, "ComponentDescription", "encoding")?;
        let count = usize::try_from(given.count.max(1)).unwrap_or(usize::MAX);
        Ok(Self { name: given.name, unit: given.unit, encoding, count })
    }
}

impl From<Encoding> for v1::Encoding {
    fn from(encoding: Encoding) -> Self {
        let kind = match encoding {
            Encoding::Float64 => Kind::Float64(Float64 {}),
            Encoding::Level { bits, min, max } => Kind::Level(Level { bits: bits.into(), min, max }),
            Encoding::Counter { bits } => Kind::Counter(Counter { bits: bits.into() }),
            Encoding::Signed { bits, limit } => Kind::Signed(Signed { bits: bits.into(), limit }),
        };
        Self { kind: Some(kind) }
    }
}

fn encoding(
    given: Option<v1::Encoding>,
    message: &'static str,
    field: &'static str,
) -> Result<Encoding, Breach> {
    let bits = |found: u32| u8::try_from(found).map_err(|_| Breach::Bits { found });
    match given.and_then(|given| given.kind).ok_or(Breach::Missing { message, field })? {
        Kind::Float64(_) => Ok(Encoding::Float64),
        Kind::Level(level) => Ok(Encoding::Level { bits: bits(level.bits)?, min: level.min, max: level.max }),
        Kind::Counter(counter) => Ok(Encoding::Counter { bits: bits(counter.bits)? }),
        Kind::Signed(signed) => Ok(Encoding::Signed { bits: bits(signed.bits)?, limit: signed.limit }),
    }
}

impl From<Firmware> for v1::Firmware {
    fn from(Firmware { protocol, period_ns }: Firmware) -> Self {
        let protocol = match protocol {
            Protocol::Framed { ages } => Spoken::Framed(Framed { ages }),
            Protocol::Bare { gap_ns } => Spoken::Bare(Bare { gap_ns }),
            Protocol::Khepera => Spoken::Khepera(Khepera {}),
            Protocol::Create(version) => Spoken::Create(Create { version: version.number().into() }),
            Protocol::Asercom => Spoken::Asercom(Asercom {}),
        };
        Self { protocol: Some(protocol), period_ns }
    }
}

fn firmware(given: Option<v1::Firmware>) -> Result<Firmware, Breach> {
    let given = given.ok_or(Breach::Missing { message: "RobotDescription", field: "firmware" })?;
    let protocol = match given.protocol.ok_or(Breach::Missing { message: "Firmware", field: "protocol" })? {
        Spoken::Framed(framed) => Protocol::Framed { ages: framed.ages },
        Spoken::Bare(bare) => Protocol::Bare { gap_ns: bare.gap_ns },
        Spoken::Khepera(_) => Protocol::Khepera,
        Spoken::Create(create) => {
            let found = create.version;
            Protocol::Create(CreateVersion::of(found).ok_or(Breach::Version { found })?)
        }
        Spoken::Asercom(_) => Protocol::Asercom,
    };
    Ok(Firmware { protocol, period_ns: given.period_ns })
}
