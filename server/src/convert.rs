//! Between the contract's types and the domain's: the only file that names both.

use std::time::Duration;

use baudbot_proto::v1;
use baudbot_sim::drive::Wheels;
use baudbot_sim::firmware::{Mode, Protocol};
use baudbot_sim::link::{LineCounters, Link};
use baudbot_sim::robot::RobotSpec;
use baudbot_sim::sensor::{Device, Sensor};
use baudbot_sim::{Freshness, RobotView, Scenario, SensorView};
use baudbot_wire::Encoding;
use tonic::Status;

use crate::columns::sensor_columns;
use crate::endpoint::{Output, Write};
use crate::letter::{Activity, Attached, Delivery, Frame, Report, RobotDelivery, SeatReport, Truth};
use crate::pace::{Pace, Pacing, Watchdog, WatchdogPolicy};

/// A pace from the contract; `None` if it is absent.
pub(crate) fn pace_from(pace: Option<v1::Pace>) -> Result<Option<Pace>, Status> {
    let Some(pace) = pace else { return Ok(None) };
    let kind = pace.kind.ok_or_else(|| Status::invalid_argument("pace.kind: must be set"))?;
    Ok(Some(match kind {
        v1::pace::Kind::RealTime(_) => Pace::REAL_TIME,
        v1::pace::Kind::Scaled(v1::Scaled { factor }) if factor.is_finite() && factor > 0.0 => {
            Pace::Timed { factor }
        }
        v1::pace::Kind::Scaled(v1::Scaled { factor }) => {
            return Err(Status::invalid_argument(format!(
                "pace.scaled.factor: must be positive, is {factor}"
            )));
        }
        v1::pace::Kind::Lockstep(lockstep) => Pace::Lockstep(watchdog_from(lockstep.watchdog)?),
        v1::pace::Kind::Stepped(stepped) => Pace::Stepped(watchdog_from(stepped.watchdog)?),
        v1::pace::Kind::Free(_) => Pace::Free,
    }))
}

fn watchdog_from(watchdog: Option<v1::Watchdog>) -> Result<Watchdog, Status> {
    let Some(watchdog) = watchdog else { return Ok(Watchdog::default()) };
    let timeout = match watchdog.timeout_ms {
        0 => Watchdog::default().timeout,
        ms => Duration::from_millis(ms.into()),
    };
    let unknown = |_| Status::invalid_argument(format!("watchdog.policy: there is no {}", watchdog.policy));
    let policy = match v1::WatchdogPolicy::try_from(watchdog.policy).map_err(unknown)? {
        v1::WatchdogPolicy::Unspecified | v1::WatchdogPolicy::Wait => WatchdogPolicy::Wait,
        v1::WatchdogPolicy::GoOn => WatchdogPolicy::GoOn,
        v1::WatchdogPolicy::Detach => WatchdogPolicy::Detach,
    };
    Ok(Watchdog { timeout, policy })
}

fn pace_to(pace: Pace) -> v1::Pace {
    use v1::pace::Kind;
    let kind = match pace {
        Pace::Timed { factor: 1.0 } => Kind::RealTime(v1::RealTime {}),
        Pace::Timed { factor } => Kind::Scaled(v1::Scaled { factor }),
        Pace::Lockstep(watchdog) => Kind::Lockstep(v1::Lockstep { watchdog: Some(watchdog_to(watchdog)) }),
        Pace::Stepped(watchdog) => Kind::Stepped(v1::Stepped { watchdog: Some(watchdog_to(watchdog)) }),
        Pace::Free => Kind::Free(v1::Free {}),
    };
    v1::Pace { kind: Some(kind) }
}

fn watchdog_to(watchdog: Watchdog) -> v1::Watchdog {
    let policy = match watchdog.policy {
        WatchdogPolicy::Wait => v1::WatchdogPolicy::Wait,
        WatchdogPolicy::GoOn => v1::WatchdogPolicy::GoOn,
        WatchdogPolicy::Detach => v1::WatchdogPolicy::Detach,
    };
    let timeout_ms = u32::try_from(watchdog.timeout.as_millis()).unwrap_or(u32::MAX);
    v1::Watchdog { timeout_ms, policy: policy.into() }
}

/// A world as it stands.
pub(crate) fn status(report: &Report) -> v1::WorldStatus {
    let world = &report.world;
    let state = match report.activity {
        Activity::WaitingForBrains => v1::WorldState::WaitingForBrains,
        Activity::Running => v1::WorldState::Running,
        Activity::Paused => v1::WorldState::Paused,
        Activity::Ended => v1::WorldState::Ended,
    };
    v1::WorldStatus {
        world: report.name.to_string(),
        scenario: world.scenario().name().to_owned(),
        state: state.into(),
        pace: Some(pace_to(report.pace)),
        tick: world.tick(),
        time_ns: world.time().as_ns(),
        step_ns: world.scenario().step_ns(),
        running_wall_ns: nanos(report.running),
        state_hash: world.hash(),
        ending: world.ending().map(ToString::to_string).unwrap_or_default(),
        robots: world.robots().zip(&report.seats).map(|(robot, seat)| robot_status(&robot, seat)).collect(),
        pacing: Some(pace_status(&report.pacing)),
    }
}

fn pace_status(pacing: &Pacing) -> v1::PaceStatus {
    let used = pacing.lateness_us_log2.iter().rposition(|&n| n > 0).map_or(0, |i| i + 1);
    v1::PaceStatus {
        late_ticks: pacing.overruns,
        lateness_us_log2: pacing.lateness_us_log2[..used].to_vec(),
        lateness_max_wall_ns: nanos(pacing.lateness_max),
        watchdog_timeouts: pacing.watchdog_timeouts,
        waiting_wall_ns: nanos(pacing.waiting),
    }
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

fn robot_status(robot: &RobotView<'_>, seat: &SeatReport) -> v1::RobotStatus {
    let counters = robot.counters();
    v1::RobotStatus {
        robot: robot.spec().name.clone(),
        brain: seat.brain.clone().unwrap_or_default(),
        attached: seat.brain.is_some(),
        turns: counters.turns,
        commands: robot.commands(),
        collisions: counters.collisions,
        distance_m: counters.distance_m,
        uplink: Some(line_status(robot.uplink())),
        downlink: Some(line_status(robot.downlink())),
        sensors: robot
            .sensors()
            .zip(&robot.spec().sensors)
            .map(|(view, spec)| sensor_status(&view, spec))
            .collect(),
        frames_missed: robot.frames_missed(),
        lost_deliveries: seat.lost_deliveries,
    }
}

fn line_status(line: &LineCounters) -> v1::LineStatus {
    v1::LineStatus {
        bytes: line.bytes,
        corrupted_bytes: line.corrupted_bytes,
        overrun_bytes: line.overrun_bytes,
        refused_bytes: line.refused_bytes,
        messages: line.messages,
        bad_frames: line.bad_frames,
        bad_messages: line.bad_messages,
        lost_bytes: line.lost_bytes,
    }
}

fn sensor_status(sensor: &SensorView<'_>, spec: &Sensor) -> v1::SensorStatus {
    let Freshness { readable, aged, age_sum_ns, age_max_ns } = sensor.freshness;
    v1::SensorStatus {
        sensor: spec.name.clone(),
        samples: sensor.samples,
        missed: sensor.missed,
        readable,
        age_mean_ns: age_sum_ns.checked_div(aged),
        age_max_ns: (aged > 0).then_some(age_max_ns),
    }
}

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

fn description(spec: &RobotSpec) -> v1::RobotDescription {
    let (baud, bits_per_character) = match &spec.link {
        Link::Ideal | Link::Onboard | Link::Usb(_) => (None, None),
        Link::Uart(uart) => (Some(uart.baud), Some(uart.bits_per_character.into())),
    };
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
    }
}

fn firmware(spec: &RobotSpec) -> v1::Firmware {
    use v1::firmware::{Bare, Framed, Protocol as P};
    let protocol = match spec.firmware.protocol {
        Protocol::Framed { ages } => P::Framed(Framed { ages }),
        Protocol::Bare { gap_ns } => P::Bare(Bare { gap_ns }),
    };
    let period_ns = match spec.firmware.mode {
        Mode::Stream(schedule) => Some(schedule.period_ns()),
        Mode::Poll => None,
    };
    v1::Firmware { protocol: Some(protocol), period_ns }
}

fn sensor(spec: &Sensor) -> v1::SensorDescription {
    let components = spec.device.components();
    let components = components.iter().zip(&spec.encodings);
    let components = components.map(|(component, &wire)| v1::ComponentDescription {
        name: component.name.to_owned(),
        unit: component.unit.to_owned(),
        encoding: Some(encoding(wire)),
    });
    v1::SensorDescription {
        sensor: spec.name.clone(),
        kind: spec.device.kind().to_owned(),
        components: components.collect(),
        period_ns: spec.schedule.period_ns(),
        phase_ns: spec.schedule.phase_ns(),
        mount: spec.device.mount().map(|mount| v1::Mount {
            x_m: mount.pose.position.x,
            y_m: mount.pose.position.y,
            heading_rad: mount.pose.heading,
        }),
        range_m: spec.device.range_m(),
        counts_per_turn: match &spec.device {
            Device::Encoders(encoders) => Some(encoders.counts_per_turn),
            _ => None,
        },
    }
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
        v1::robot_step::Output::Command(v1::Command { left_signal, right_signal }) => {
            Output::Command(Wheels { left: left_signal, right: right_signal })
        }
        v1::robot_step::Output::Poll(_) => Output::Poll,
    };
    let write = |step: v1::RobotStep| Write {
        slot: step.robot as usize,
        thinking_ns: step.thinking_ns,
        output: step.output.map(output),
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
    v1::RobotTurn {
        robot: delivery.slot as u32,
        at_ns: delivery.at.as_ns(),
        raw: delivery.raw,
        readings: readings.collect(),
    }
}

/// What stands still in a world, and what its robots are, for an observer.
pub(crate) fn world_description(scenario: &Scenario) -> v1::DescribeWorldResponse {
    let point = |x_m, y_m| v1::Point { x_m, y_m };
    let polygons = scenario.arena().polygons().iter().map(|polygon| v1::Polygon {
        name: polygon.name.clone(),
        points: polygon.points.iter().map(|p| point(p.x, p.y)).collect(),
        solid: polygon.solid,
    });
    let circles = scenario.arena().pillars().iter().map(|pillar| v1::Disc {
        name: pillar.name.clone(),
        center: Some(point(pillar.circle.center.x, pillar.circle.center.y)),
        radius_m: pillar.circle.radius,
    });
    let robots = scenario.robots().iter().map(|spec| v1::ObservedRobot {
        robot: spec.name.clone(),
        radius_m: spec.drive.radius_m,
        sensor_columns: sensor_columns(spec),
    });
    v1::DescribeWorldResponse {
        scenario: scenario.name().to_owned(),
        description: scenario.description().to_owned(),
        step_ns: scenario.step_ns(),
        polygons: polygons.collect(),
        circles: circles.collect(),
        robots: robots.collect(),
    }
}

/// The truth for an observer.
pub(crate) fn frame(frame: Frame) -> v1::WatchResponse {
    let collisions = frame.collisions.into_iter();
    v1::WatchResponse {
        tick: frame.tick,
        time_ns: frame.time.as_ns(),
        robots: frame.robots.into_iter().map(truth).collect(),
        collisions: collisions.map(|c| v1::Collision { robot: c.robot, with: c.with }).collect(),
        missed_frames: frame.missed_frames,
        ending: frame.ending.unwrap_or_default(),
    }
}

fn truth(truth: Truth) -> v1::RobotTruth {
    v1::RobotTruth {
        x_m: truth.motion.pose.position.x,
        y_m: truth.motion.pose.position.y,
        heading_rad: truth.motion.pose.heading,
        speed_m_s: truth.motion.speed_m_s,
        turn_rate_rad_s: truth.motion.turn_rate_rad_s,
        left_signal: truth.signals.left,
        right_signal: truth.signals.right,
        collided: truth.collided,
        samples: truth.samples,
    }
}
