//! From the raw file to a [`Scenario`]: every number is checked, then nothing can be wrong.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_geometry::{Circle, Point, Pose, angle, polygon::is_simple};
use baudbot_wire::Encoding;

use super::check::{Names, Path};
use super::{End, Scenario, ScenarioError, cable, link, raw, sensors};
use crate::arena::{Arena, Pillar, Polygon};
use crate::collision::CollisionPolicy;
use crate::drive::{Drive, Wheel, forward_gain, turn_gain};
use crate::microcontroller::Processor;
use crate::motor::Motor;
use crate::robot::{RobotSpec, Start};
use crate::sensor::{Device, Sensor};
use crate::time::{SECOND_NS, SimTime};

/// Shortest period of anything that repeats: below it a run would do nothing else.
pub(super) const MIN_PERIOD_MS: f64 = 0.01;

/// Most corners of one polygon: whether it crosses itself is found by comparing all pairs of sides.
const MAX_POINTS: usize = 4096;

/// Most robots of one scenario.
const MAX_ROBOTS: usize = 10_000;

/// Most rays that one sensor casts in a tick.
const MAX_RAYS_A_TICK: u64 = 100_000;

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
    let step = Step { step_ms: raw.step_ms, step_ns, substeps };
    let robots = robots(&path.field("robots"), raw.robots, step, &arena)?;
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
    let after = raw.after_s.map(|s| path.within("after_s", s, 1e-9, 1e8)).transpose()?;
    let goal =
        raw.goal.map(|goal| disc(&path.field("goal"), goal.x_m, goal.y_m, goal.radius_m)).transpose()?;
    Ok(End { after: after.map(|s| SimTime::from_ns((s * SECOND_NS as f64 + 0.5) as u64)), goal })
}

fn disc(path: &Path, x_m: f64, y_m: f64, radius_m: f64) -> Result<Circle> {
    let center = Point::new(path.coordinate("x_m", x_m)?, path.coordinate("y_m", y_m)?);
    Ok(Circle { center, radius: path.length("radius_m", radius_m)? })
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
        points.push(Point::new(at.coordinate("x", x)?, at.coordinate("y", y)?));
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

fn robots(path: &Path, raw: Vec<raw::Robot>, step: Step, arena: &Arena) -> Result<Vec<RobotSpec>> {
    if raw.len() > MAX_ROBOTS {
        return Err(path.error(format!("there are {}, the limit is {MAX_ROBOTS}", raw.len())));
    }
    let mut names = Names::default();
    let mut robots: Vec<(usize, RobotSpec)> = Vec::new();
    for (i, robot) in raw.into_iter().enumerate() {
        let path = path.index(i);
        let name = names.take(&path.field("name"), &robot.name)?;
        let spec = robot_spec(&path, name, robot, step.step_ms)?;
        is_stable(&path, &spec, step)?;
        is_affordable(&path, &spec, step)?;
        stands_free(&path, &spec, arena, &robots)?;
        robots.push((i, spec));
    }
    robots.sort_by(|(_, a), (_, b)| a.name.cmp(&b.name));
    Ok(robots.into_iter().map(|(_, spec)| spec).collect())
}

/// The length of a tick, which several checks need.
#[derive(Clone, Copy)]
struct Step {
    step_ms: f64,
    step_ns: u64,
    substeps: u64,
}

/// Euler steps that are too long for a body blow up, and end in numbers that are none.
fn is_stable(path: &Path, spec: &RobotSpec, step: Step) -> Result<()> {
    let dt = step.step_ns as f64 / step.substeps as f64 / SECOND_NS as f64;
    let worst = spec.drive.stiffness(dt).into_iter().fold(0.0, f64::max);
    if worst < 2.0 {
        return Ok(());
    }
    let needed = (step.substeps as f64 * worst) as u64 + 1;
    let problem = format!(
        "Euler steps of {} ms are too long for this body and would blow up; set substeps to {needed} or more",
        dt * 1e3
    );
    Err(path.field("body").error(problem))
}

/// A scenario that nobody could wait for is a mistake in a unit.
fn is_affordable(path: &Path, spec: &RobotSpec, step: Step) -> Result<()> {
    for sensor in &spec.sensors {
        let Device::Infrared(infrared) = &sensor.device else { continue };
        let rays = step.step_ns.div_ceil(sensor.schedule.period_ns()) * infrared.fan.len() as u64;
        if rays > MAX_RAYS_A_TICK {
            let problem = format!("casts {rays} rays a tick, the limit is {MAX_RAYS_A_TICK}");
            return Err(path.field("sensors").field(&sensor.name).field("rays").error(problem));
        }
    }
    Ok(())
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
    let link = link::link(&path.field("link"), &raw.link)?;
    let firmware = cable::firmware(&path.field("firmware"), &raw.firmware, &sensors, motor, step_ms, &link)?;
    cable::check_sizes(path, &firmware, &link)?;
    Ok(RobotSpec {
        name,
        start,
        drive,
        signal_limit: (!raw.motors.unlimited_signals).then_some(1.0),
        sensors,
        processor: processor(&path.field("microcontroller"), &raw.microcontroller)?,
        firmware,
        link,
        thinking_ns: path.field("brain").us("thinking_us", raw.brain.thinking_us, 1e9)?,
    })
}

fn start(path: &Path, raw: &raw::Start) -> Result<Start> {
    let (x, y) = (path.coordinate("x_m", raw.x_m)?, path.coordinate("y_m", raw.y_m)?);
    let heading = angle::wrap(path.within("heading_rad", raw.heading_rad, -1e3, 1e3)?);
    Ok(Start {
        pose: Pose::new(x, y, heading),
        speed_m_s: path.within("speed_m_s", raw.speed_m_s, -1e3, 1e3)?,
        turn_rate_rad_s: path.within("turn_rate_rad_s", raw.turn_rate_rad_s, -1e3, 1e3)?,
        wheels_at_rest: raw.wheels_at_rest,
    })
}

fn drive(path: &Path, body: &raw::Body, motors: &raw::Motors) -> Result<Drive> {
    let motor = motor(&path.field("motors"), motors)?;
    let track_factor = path.field("motors").within("track_factor", motors.track_factor, 0.0, 1.0)?;
    let path = path.field("body");
    let radius_m = path.length("radius_m", body.radius_m)?;
    let half_track_m = path.length("half_track_m", body.half_track_m.unwrap_or(radius_m))?;
    let wheel_radius_m = path.length("wheel_radius_m", body.wheel_radius_m)?;
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
