//! Between the contract's messages and this crate's types: the only file that names both.

use std::sync::Arc;
use std::time::Duration;

use baudbot_brain::{
    Action, Actuator, Belief, Body, Component, Encoding, Firmware, GridMap, Mount, Port, Protocol, Reading,
    Sensor, Signals, Sweep, Until,
};
use baudbot_proto::v1;
use baudbot_proto::v1::attach_request::Request;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::encoding::Kind;
use baudbot_proto::v1::robot_step::Output;

use crate::error::Breach;
use crate::session::{Answer, Event, Hello, Part, Welcome};

/// The first request.
pub(crate) fn hello(hello: &Hello) -> v1::AttachRequest {
    let mode = if hello.raw { v1::PortMode::Raw } else { v1::PortMode::Messages };
    request(Request::Hello(v1::Hello {
        world: hello.world.clone(),
        robots: hello.robots.clone(),
        mode: mode.into(),
        brain: hello.brain.clone(),
        memory_bytes: hello.memory_bytes,
        thinks_as_scenario: hello.thinks_as_scenario,
        stop_when_gone: false,
    }))
}

/// The answer to a turn.
pub(crate) fn step<'a>(turn: u64, answers: impl Iterator<Item = (usize, Answer<'a>)>) -> v1::AttachRequest {
    let robots = answers.map(|(robot, answer)| robot_step(robot, &answer)).collect();
    request(Request::Step(v1::Step { turn, robots }))
}

/// What is shown to people.
pub(crate) fn annotate(robot: usize, shown: Belief) -> v1::AttachRequest {
    request(Request::Annotate(v1::Annotate { robot: robot as u32, belief: Some(belief(shown)) }))
}

fn belief(belief: Belief) -> v1::Belief {
    let Belief { state, utilities, pose, particles, path, map } = belief;
    v1::Belief {
        state,
        utilities: utilities
            .into_iter()
            .map(|u| v1::Utility { name: u.name, value: u.value, active: u.active })
            .collect(),
        pose: pose.map(|p| v1::BelievedPose {
            x_m: p.x_m,
            y_m: p.y_m,
            heading_rad: p.heading_rad,
            covariance_m2: p.covariance_m2.map_or_else(Vec::new, Vec::from),
        }),
        particles: particles
            .into_iter()
            .map(|p| v1::Particle { x_m: p.x_m, y_m: p.y_m, heading_rad: p.heading_rad, weight: p.weight })
            .collect(),
        path: path.into_iter().map(|p| v1::Point { x_m: p.x_m, y_m: p.y_m }).collect(),
        map: map.map(|GridMap { x_m, y_m, cell_m, columns, cells }| v1::GridMap {
            x_m,
            y_m,
            cell_m,
            columns,
            cells,
        }),
    }
}

/// What came in answer to the Hello for `robots`.
pub(crate) fn welcome(response: Option<v1::AttachResponse>, robots: &[String]) -> Result<Welcome, Breach> {
    let found = match response {
        None => "the end of the stream",
        Some(response) => match response.response {
            Some(Response::Welcome(welcome)) => return accept(welcome, robots),
            other => name(other.as_ref()),
        },
    };
    Err(Breach::Expected { expected: "a Welcome", found })
}

/// What came after the Welcome with these `bodies`.
pub(crate) fn event(response: v1::AttachResponse, bodies: &[Arc<Body>]) -> Result<Event, Breach> {
    match response.response {
        Some(Response::Ended(_)) => Ok(Event::Ended),
        Some(Response::Turn(turn)) => {
            let parts = turn.robots.into_iter().map(|turn| part(turn, bodies));
            Ok(Event::Turn { number: turn.turn, tick: turn.tick, parts: parts.collect::<Result<_, _>>()? })
        }
        other => Err(Breach::Expected { expected: "a Turn or Ended", found: name(other.as_ref()) }),
    }
}

fn request(request: Request) -> v1::AttachRequest {
    v1::AttachRequest { request: Some(request) }
}

fn robot_step(robot: usize, answer: &Answer<'_>) -> v1::RobotStep {
    let (thinking, operations, output) = match *answer {
        Answer::Write { bytes, thinking, operations, .. } => {
            (thinking, operations, Some(Output::Raw(bytes.to_vec())))
        }
        Answer::Act(action) => (action.thinking, action.operations, output(action)),
        Answer::Sleep(_) | Answer::Nothing => (None, None, None),
    };
    let thinking_ns = thinking.map(nanoseconds);
    let until_message = answer.until().map(|Until { at_latest_ns }| v1::UntilMessage { at_latest_ns });
    let robot = u32::try_from(robot).unwrap_or(u32::MAX);
    v1::RobotStep { robot, thinking_ns, output, operations, until_message }
}

fn output(action: &Action) -> Option<Output> {
    match action.signals {
        Some(Signals { left, right }) => Some(Output::Command(v1::Command {
            left_signal: left,
            right_signal: right,
            other_signals: action.others.clone(),
        })),
        None => action.poll.then_some(Output::Poll(v1::Poll {})),
    }
}

pub(crate) fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

fn name(response: Option<&Response>) -> &'static str {
    match response {
        Some(Response::Welcome(_)) => "a Welcome",
        Some(Response::Turn(_)) => "a Turn",
        Some(Response::Ended(_)) => "Ended",
        None => "an empty response",
    }
}

fn accept(welcome: v1::Welcome, robots: &[String]) -> Result<Welcome, Breach> {
    let v1::Welcome { step_ns, lockstep, robots: described } = welcome;
    if !described.iter().map(|body| &body.robot).eq(robots) {
        let described = described.into_iter().map(|body| body.robot).collect();
        return Err(Breach::Robots { asked: robots.to_vec(), described });
    }
    let bodies = described.into_iter().map(|described| body(described).map(Arc::new));
    Ok(Welcome { step_ns, lockstep, bodies: bodies.collect::<Result<_, _>>()? })
}

fn body(described: v1::RobotDescription) -> Result<Body, Breach> {
    let body = Body {
        name: described.robot,
        radius_m: described.radius_m,
        half_track_m: described.half_track_m,
        wheel_radius_m: described.wheel_radius_m,
        signal_limit: described.signal_limit,
        motor_encoding: encoding(described.motor_encoding, "RobotDescription", "motor_encoding")?,
        sensors: described.sensors.into_iter().map(sensor).collect::<Result<_, _>>()?,
        firmware: firmware(described.firmware)?,
        baud: described.baud,
        bits_per_character: described.bits_per_character,
        motor_kind: described.motor_kind,
        actuators: described.actuators.into_iter().map(actuator).collect(),
        onboard: described.onboard,
        operations_per_s: described.operations_per_s,
        ram_bytes: described.ram_bytes,
    };
    match body.layout().check(body.firmware.protocol) {
        Ok(()) => Ok(body),
        Err(source) => Err(Breach::Layout { robot: body.name, source }),
    }
}

fn actuator(described: v1::ActuatorDescription) -> Actuator {
    let v1::ActuatorDescription { actuator, kind, min_rad, max_rad } = described;
    Actuator { name: actuator, kind, range_rad: min_rad.zip(max_rad).map(|(min, max)| [min, max]) }
}

fn sensor(described: v1::SensorDescription) -> Result<Sensor, Breach> {
    Ok(Sensor {
        name: described.sensor,
        kind: described.kind,
        components: described.components.into_iter().map(component).collect::<Result<_, _>>()?,
        period_ns: described.period_ns,
        phase_ns: described.phase_ns,
        mount: described.mount.map(mount),
        range_m: described.range_m,
        counts_per_turn: described.counts_per_turn,
        port: described.port.map(port),
        opening_rad: described.opening_rad,
        sweep: described.sweep.map(|v1::Sweep { duration_ns, clockwise }| Sweep { duration_ns, clockwise }),
    })
}

fn mount(described: v1::Mount) -> Mount {
    let v1::Mount { x_m, y_m, heading_rad, turret } = described;
    Mount { x_m, y_m, heading_rad, turret: turret.map(|place| place as usize) }
}

fn port(described: v1::Port) -> Port {
    let v1::Port { format, message_bytes, baud, bits_per_character } = described;
    Port { format, message_bytes, baud, bits_per_character }
}

fn component(described: v1::ComponentDescription) -> Result<Component, Breach> {
    let encoding = encoding(described.encoding, "ComponentDescription", "encoding")?;
    let count = usize::try_from(described.count.max(1)).unwrap_or(usize::MAX);
    Ok(Component { name: described.name, unit: described.unit, encoding, count })
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

fn firmware(given: Option<v1::Firmware>) -> Result<Firmware, Breach> {
    use v1::firmware::Protocol as Given;
    let given = given.ok_or(Breach::Missing { message: "RobotDescription", field: "firmware" })?;
    let protocol = match given.protocol.ok_or(Breach::Missing { message: "Firmware", field: "protocol" })? {
        Given::Framed(framed) => Protocol::Framed { ages: framed.ages },
        Given::Bare(bare) => Protocol::Bare { gap_ns: bare.gap_ns },
        Given::Khepera(_) => Protocol::Khepera,
    };
    Ok(Firmware { protocol, period_ns: given.period_ns })
}

fn part(turn: v1::RobotTurn, bodies: &[Arc<Body>]) -> Result<Part, Breach> {
    let (robot, body) = at(bodies, turn.robot, "robot")?;
    let mut readings = vec![None; body.sensors.len()];
    for given in turn.readings {
        let (index, sensor) = at(&body.sensors, given.sensor, "sensor")?;
        readings[index] = Some(reading(given, sensor)?);
    }
    let mut ports = Vec::new();
    for v1::PortBytes { sensor, data } in turn.ports {
        let (index, _) = at(&body.sensors, sensor, "sensor")?;
        ports.push((index, data));
    }
    Ok(Part { robot, at_ns: turn.at_ns, bytes: turn.raw, ports, readings })
}

fn reading(given: v1::Reading, sensor: &Sensor) -> Result<Reading, Breach> {
    let v1::Reading { sensor: _, values, sampled_at_ns, sequence, readable } = given;
    let (expected, found) = (sensor.values(), values.len());
    if expected != found {
        return Err(Breach::Values { sensor: sensor.name.clone(), expected, found });
    }
    Ok(Reading { values, sampled_at_ns, sequence, readable })
}

fn at<'a, T>(list: &'a [T], index: u32, what: &'static str) -> Result<(usize, &'a T), Breach> {
    let place = usize::try_from(index).unwrap_or(usize::MAX);
    list.get(place).map(|item| (place, item)).ok_or(Breach::Index { what, index, count: list.len() })
}
