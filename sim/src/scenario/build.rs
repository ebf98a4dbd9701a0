//! From the raw file to a [`Scenario`]: every number is checked, then nothing can be wrong.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Pose, angle, polygon::is_simple};
use baudbot_wire::{Encoding, frame};

use super::check::{Names, Path};
use super::{End, Scenario, ScenarioError, raw, sensors};
use crate::arena::{Arena, Pillar, Polygon};
use crate::collision::CollisionPolicy;
use crate::drive::{Drive, Wheel, forward_gain, turn_gain};
use crate::firmware::{Firmware, Mode, Protocol};
use crate::link::{Link, Uart};
use crate::microcontroller::Processor;
use crate::motor::Motor;
use crate::robot::{RobotSpec, Start};
use crate::schedule::Schedule;
use crate::sensor::Sensor;
use crate::time::{SECOND_NS, SimTime};

/// Shortest period of anything that repeats: below it a run would do nothing else.
pub(super) const MIN_PERIOD_MS: f64 = 0.01;

/// Most corners of one polygon: whether it crosses itself is found by comparing all pairs of sides.
const MAX_POINTS: usize = 4096;

type Result<T> = core::result::Result<T, ScenarioError>;

pub(super) fn scenario(raw: raw::Scenario) -> Result<Scenario> {
    let path = Path::root();
    let step_ns = path.ms("step_ms", raw.step_ms, MIN_PERIOD_MS, 1000.0)?;
    let substeps = path.whole_within("substeps", u64::from(raw.substeps), 1, 10_000)?;
    if step_ns % substeps != 0 {
        let problem = format!("{substeps} substeps do not divide {step_ns} ns into whole nanoseconds");
        return Err(path.field("substeps").error(problem));
    }
    let arena = arena(&path.field("arena"), raw.arena)?;
    let robots = robots(&path.field("robots"), raw.robots, raw.step_ms, &arena)?;
    Ok(Scenario {
        name: raw.name,
        description: raw.description,
        seed: raw.seed,
        step_ns,
        substeps: substeps as u32,
        noise: raw.noise,
        collision: match raw.collision {
            raw::Collision::StopRun => CollisionPolicy::StopRun,
            raw::Collision::StopRobot => CollisionPolicy::StopRobot,
        },
        end: end(&path.field("end"), raw.end)?,
        arena,
        robots,
    })
}

fn end(path: &Path, raw: raw::End) -> Result<End> {
    let after = raw.after_s.map(|s| path.within("after_s", s, 0.0, 1e8)).transpose()?;
    let goal =
        raw.goal.map(|goal| disc(&path.field("goal"), goal.x_m, goal.y_m, goal.radius_m)).transpose()?;
    Ok(End { after: after.map(|s| SimTime::from_ns((s * SECOND_NS as f64 + 0.5) as u64)), goal })
}

fn disc(path: &Path, x_m: f64, y_m: f64, radius_m: f64) -> Result<Circle> {
    let center = Point::new(path.finite("x_m", x_m)?, path.finite("y_m", y_m)?);
    Ok(Circle { center, radius: path.positive("radius_m", radius_m)? })
}

fn arena(path: &Path, raw: raw::Arena) -> Result<Arena> {
    let mut names = Names::default();
    let mut polygons = Vec::new();
    for (i, raw) in raw.polygons.into_iter().enumerate() {
        polygons.push(polygon(&path.field("polygons").index(i), raw, &mut names)?);
    }
    let mut pillars = Vec::new();
    for (i, circle) in raw.circles.into_iter().enumerate() {
        let path = path.field("circles").index(i);
        let name = names.take(&path.field("name"), &circle.name)?;
        pillars.push(Pillar { name, circle: disc(&path, circle.x_m, circle.y_m, circle.radius_m)? });
    }
    Ok(Arena::new(polygons, pillars))
}

fn polygon(path: &Path, raw: raw::Polygon, names: &mut Names) -> Result<Polygon> {
    let name = names.take(&path.field("name"), &raw.name)?;
    let at = path.field("points_m");
    let mut points = Vec::new();
    for (i, [x, y]) in raw.points_m.iter().copied().enumerate() {
        let at = at.index(i);
        points.push(Point::new(at.finite("x", x)?, at.finite("y", y)?));
    }
    if points.len() > MAX_POINTS {
        return Err(at.error(format!("a polygon has at most {MAX_POINTS} points, this one {}", points.len())));
    }
    if points.len() < 2 || (raw.solid && points.len() < 3) {
        return Err(at.error(format!(
            "a solid polygon has at least 3 points, a hollow one 2; here are {}",
            points.len()
        )));
    }
    if raw.solid && !is_simple(&points) {
        return Err(at.error("the outline crosses itself, so a solid polygon's inside is not defined"));
    }
    Ok(Polygon { name, points, solid: raw.solid })
}

fn robots(path: &Path, raw: Vec<raw::Robot>, step_ms: f64, arena: &Arena) -> Result<Vec<RobotSpec>> {
    let mut names = Names::default();
    let mut robots: Vec<(usize, RobotSpec)> = Vec::new();
    for (i, robot) in raw.into_iter().enumerate() {
        let path = path.index(i);
        let name = names.take(&path.field("name"), &robot.name)?;
        let spec = robot_spec(&path, name, robot, step_ms)?;
        stands_free(&path, &spec, arena, &robots)?;
        robots.push((i, spec));
    }
    robots.sort_by(|(_, a), (_, b)| a.name.cmp(&b.name));
    Ok(robots.into_iter().map(|(_, spec)| spec).collect())
}

fn stands_free(path: &Path, spec: &RobotSpec, arena: &Arena, others: &[(usize, RobotSpec)]) -> Result<()> {
    let disc = |spec: &RobotSpec| Circle { center: spec.start.pose.position, radius: spec.drive.radius_m };
    if let Some(name) = arena.obstacle_at(&disc(spec)) {
        let Circle { center, radius } = disc(spec);
        let problem =
            format!("at ({}, {}) a robot of radius {radius} m stands in `{name}`", center.x, center.y);
        return Err(path.field("start").error(problem));
    }
    let meets = |(_, other): &&(usize, RobotSpec)| disc(spec).overlaps_circle(&disc(other));
    match others.iter().find(meets) {
        Some((i, other)) => {
            Err(path.field("start").error(format!("stands in robots[{i}] (`{}`)", other.name)))
        }
        None => Ok(()),
    }
}

fn robot_spec(path: &Path, name: String, raw: raw::Robot, step_ms: f64) -> Result<RobotSpec> {
    let start = start(&path.field("start"), &raw.start)?;
    let drive = drive(path, &raw.body, &raw.motors)?;
    let sensors = sensors(&path.field("sensors"), raw.sensors, step_ms, drive.radius_m)?;
    let motor = motor_encoding(&path.field("motors"), &raw.motors)?;
    let firmware = firmware(&path.field("firmware"), &raw.firmware, &sensors, motor, step_ms)?;
    if firmware.layout().readings_len_max() > frame::MAX_PAYLOAD {
        let problem = format!(
            "a frame of all readings has {} bytes, the limit is {}",
            firmware.layout().readings_len_max(),
            frame::MAX_PAYLOAD
        );
        return Err(path.field("sensors").error(problem));
    }
    Ok(RobotSpec {
        name,
        start,
        drive,
        signal_limit: (!raw.motors.unlimited_signals).then_some(1.0),
        sensors,
        processor: processor(&path.field("microcontroller"), &raw.microcontroller)?,
        firmware,
        link: link(&path.field("link"), &raw.link)?,
        thinking_ns: path.field("brain").us("thinking_us", raw.brain.thinking_us, 1e9)?,
    })
}

fn start(path: &Path, raw: &raw::Start) -> Result<Start> {
    let (x, y) = (path.finite("x_m", raw.x_m)?, path.finite("y_m", raw.y_m)?);
    let heading = angle::wrap(path.within("heading_rad", raw.heading_rad, -1e3, 1e3)?);
    Ok(Start {
        pose: Pose::new(x, y, heading),
        speed_m_s: path.finite("speed_m_s", raw.speed_m_s)?,
        turn_rate_rad_s: path.finite("turn_rate_rad_s", raw.turn_rate_rad_s)?,
        wheels_at_rest: raw.wheels_at_rest,
    })
}

fn drive(path: &Path, body: &raw::Body, motors: &raw::Motors) -> Result<Drive> {
    let motor = motor(&path.field("motors"), motors)?;
    let track_factor = path.field("motors").within("track_factor", motors.track_factor, 0.0, 1.0)?;
    let path = path.field("body");
    let radius_m = path.positive("radius_m", body.radius_m)?;
    let half_track_m = path.positive("half_track_m", body.half_track_m.unwrap_or(radius_m))?;
    let wheel_radius_m = path.positive("wheel_radius_m", body.wheel_radius_m)?;
    let mass_kg = path.positive("mass_kg", body.mass_kg)?;
    let inertia_kg_m2 = path.positive("inertia_kg_m2", body.inertia_kg_m2)?;
    let wheel = Wheel {
        mass_kg: path.not_negative("wheel_mass_kg", body.wheel_mass_kg)?,
        inertia_kg_m2: path.not_negative("wheel_inertia_kg_m2", body.wheel_inertia_kg_m2)?,
    };
    Ok(Drive {
        radius_m,
        half_track_m,
        wheel_radius_m,
        mass_kg,
        inertia_kg_m2,
        damping_n_s_m: path.not_negative("damping_n_s_m", body.damping_n_s_m)?,
        turn_damping_nm_s: path.not_negative("turn_damping_nm_s", body.turn_damping_nm_s)?,
        forward_gain: forward_gain(mass_kg, wheel_radius_m, wheel),
        turn_gain: turn_gain(inertia_kg_m2, half_track_m, wheel_radius_m, wheel),
        motor,
        motor_track_factor: track_factor,
    })
}

fn motor(path: &Path, raw: &raw::Motors) -> Result<Motor> {
    Ok(Motor {
        voltage_v: path.positive("voltage_v", raw.voltage_v)?,
        torque_constant_nm_a: path.positive("torque_constant_nm_a", raw.torque_constant_nm_a)?,
        emf_constant_v_s: path.not_negative("emf_constant_v_s", raw.emf_constant_v_s)?,
        resistance_ohm: path.positive("resistance_ohm", raw.resistance_ohm)?,
        coulomb_friction_nm: path.not_negative("coulomb_friction_nm", raw.coulomb_friction_nm)?,
        viscous_friction_nm_s: path.not_negative("viscous_friction_nm_s", raw.viscous_friction_nm_s)?,
        gear_ratio: path.positive("gear_ratio", raw.gear_ratio)?,
        gear_efficiency: path.within("gear_efficiency", raw.gear_efficiency, f64::MIN_POSITIVE, 1.0)?,
        max_torque_nm: path.positive("max_torque_nm", raw.max_torque_nm)?,
    })
}

fn motor_encoding(path: &Path, raw: &raw::Motors) -> Result<Encoding> {
    let Some(bits) = raw.signal_bits else { return Ok(Encoding::Float64) };
    if raw.unlimited_signals {
        return Err(path.field("unlimited_signals").error("needs signals without `signal_bits`"));
    }
    let bits = path.whole_within("signal_bits", bits, 2, 32)? as u8;
    Ok(Encoding::Signed { bits, limit: 1.0 })
}

fn sensors(path: &Path, raw: raw::Sensors, step_ms: f64, radius_m: f64) -> Result<Vec<Sensor>> {
    let mut names = Names::default();
    let mut sensors = Vec::new();
    for (name, table) in raw.0 {
        let path = path.field(&name);
        let name = names.take(&path, &name)?;
        sensors.push(sensors::sensor(&path, name, table, step_ms, radius_m)?);
    }
    if sensors.len() > usize::from(u8::MAX) {
        return Err(path.error(format!("there are {} sensors, the limit is {}", sensors.len(), u8::MAX)));
    }
    Ok(sensors)
}

fn processor(path: &Path, raw: &raw::Microcontroller) -> Result<Processor> {
    Ok(Processor {
        framing_ns_per_byte: path.us("framing_us_per_byte", raw.framing_us_per_byte, 1e6)?,
        receiving_ns_per_byte: path.us("receiving_us_per_byte", raw.receiving_us_per_byte, 1e6)?,
        obeying_ns: path.us("obeying_us", raw.obeying_us, 1e6)?,
    })
}

fn firmware(
    path: &Path,
    raw: &raw::Firmware,
    sensors: &[Sensor],
    motor: Encoding,
    step_ms: f64,
) -> Result<Firmware> {
    let protocol = match raw.protocol {
        raw::Protocol::Framed => {
            refuse(path, "gap_ms", raw.gap_ms.is_some(), "only the bare protocol tells messages by silence")?;
            Protocol::Framed { ages: raw.ages.unwrap_or(true) }
        }
        raw::Protocol::Bare => {
            refuse(path, "ages", raw.ages.is_some(), "the bare protocol carries no ages")?;
            Protocol::Bare { gap_ns: path.ms("gap_ms", raw.gap_ms.unwrap_or(20.0), MIN_PERIOD_MS, 1e6)? }
        }
    };
    let mode = match raw.mode {
        raw::Mode::Stream => {
            let period_ns = path.ms("period_ms", raw.period_ms.unwrap_or(step_ms), MIN_PERIOD_MS, 1e7)?;
            Mode::Stream(Schedule::new(
                period_ns,
                path.ms("phase_ms", raw.phase_ms.unwrap_or(0.0), 0.0, 1e7)?,
            ))
        }
        raw::Mode::Poll => {
            refuse(path, "period_ms", raw.period_ms.is_some(), "a polled firmware has no period")?;
            refuse(path, "phase_ms", raw.phase_ms.is_some(), "a polled firmware has no phase")?;
            Mode::Poll
        }
    };
    let encodings: Vec<&[Encoding]> = sensors.iter().map(|sensor| sensor.encodings.as_slice()).collect();
    Ok(Firmware::new(protocol, mode, &encodings, motor))
}

fn link(path: &Path, raw: &raw::Link) -> Result<Link> {
    if raw.kind == raw::LinkKind::Ideal {
        let given = [
            ("baud", raw.baud.is_some()),
            ("bits_per_character", raw.bits_per_character.is_some()),
            ("receive_depth", raw.receive_depth.is_some()),
            ("transmit_depth", raw.transmit_depth.is_some()),
            ("laptop_buffer_bytes", raw.laptop_buffer_bytes.is_some()),
            ("byte_error_rate", raw.byte_error_rate.is_some()),
        ];
        for (field, given) in given {
            refuse(path, field, given, "an ideal link has none; did you mean kind = \"uart\"?")?;
        }
        return Ok(Link::Ideal);
    }
    let baud =
        raw.baud.ok_or_else(|| path.field("baud").error("a uart needs its baud rate, such as 9600"))?;
    let bits = raw.bits_per_character.unwrap_or(10);
    if ![8, 10, 11].contains(&bits) {
        let problem = format!("must be 8 (as the notes count), 10 (8N1) or 11, is {bits}");
        return Err(path.field("bits_per_character").error(problem));
    }
    let depth =
        |field, depth: Option<u64>, default| path.whole_within(field, depth.unwrap_or(default), 1, 1 << 20);
    Ok(Link::Uart(Uart {
        baud: path.whole_within("baud", baud, 50, 100_000_000)? as u32,
        bits_per_character: bits as u8,
        receive_depth: depth("receive_depth", raw.receive_depth, 64)? as usize,
        transmit_depth: depth("transmit_depth", raw.transmit_depth, 64)? as usize,
        laptop_buffer_bytes: depth("laptop_buffer_bytes", raw.laptop_buffer_bytes, 4096)? as usize,
        byte_error_rate: path.within("byte_error_rate", raw.byte_error_rate.unwrap_or(0.0), 0.0, 1.0)?,
    }))
}

fn refuse(path: &Path, field: &str, given: bool, problem: &str) -> Result<()> {
    if given { Err(path.field(field).error(problem)) } else { Ok(()) }
}
