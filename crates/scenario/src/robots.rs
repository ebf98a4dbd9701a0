//! The way from raw robots to [`RobotSpec`]s.

use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_wire::Encoding;

use super::body::Body;
use super::context::{MAX_SUBSTEPS, Step, World};
use super::motors::{self, ParsedMotors};
use super::names::Names;
use super::starts::{self, Place};
use super::{
    actuators, cable, chip, create, faults, link, microcontroller, raw, sensors, serial_ports, shapes,
};
use baudbot_fields::number::Number;
use baudbot_fields::{FieldError, Path};
use baudbot_sim::actuator::Actuator;
use baudbot_sim::battery::Battery;
use baudbot_sim::drive::{Deviation, Drive, Wheel, forward_gain, turn_gain};
use baudbot_sim::firmware::Firmware;
use baudbot_sim::link::Link;
use baudbot_sim::model::{PortUse, RobotModel, RobotSpec, Writes};
use baudbot_sim::motor::Motors;
use baudbot_sim::processor::Processor;
use baudbot_sim::sensor::Sensor;
use baudbot_sim::time::SECOND_NS;

/// Most robots of one scenario.
pub(super) const MAX_ROBOTS: usize = 10_000;

/// Most rays that one sensor casts in a tick.
const MAX_RAYS_A_TICK: u64 = 100_000;

type Result<T> = core::result::Result<T, FieldError>;

/// The robots, in the order of their names.
pub(super) fn robots(path: &Path, raw: Vec<raw::Robot>, context: &mut World<'_>) -> Result<Vec<RobotSpec>> {
    let number: usize = raw.iter().map(starts::number).sum();
    if number > MAX_ROBOTS {
        return Err(path.error(format!("there are {number}, the limit is {MAX_ROBOTS}")));
    }
    let mut names = Names::default();
    let mut robots: Vec<(Place, RobotSpec)> = Vec::with_capacity(number);
    for (i, robot) in raw.into_iter().enumerate() {
        let path = path.index(i);
        let places = starts::places(&path, &robot, &mut names)?;
        let first = places.first().map_or("", |(_, name, _)| name);
        context.serial_ports.extend(serial_ports::of(&path, &robot, first)?);
        let group: Option<Arc<str>> = robot.starts.is_some().then(|| robot.name.as_str().into());
        let (model, faults) = model(&path, robot, context)?;
        is_stable(&path, &model, context.step)?;
        is_affordable(&path, &model, context.step)?;
        let model = shared(model, robots.last().map(|(_, last)| last));
        for (place, name, start) in places {
            let model = with_faults(&path, &model, (&name, context.seed), &faults)?;
            robots.push((
                place,
                RobotSpec { name, group: group.clone(), start, model, port_use: PortUse::Closed },
            ));
        }
    }
    starts::stand_free(&robots, context)?;
    robots.sort_by(|(_, a), (_, b)| a.name.cmp(&b.name));
    Ok(robots.into_iter().map(|(_, spec)| spec).collect())
}

/// The model of the robot before, or its sensors, if they are the same.
fn shared(mut model: RobotModel, last: Option<&RobotSpec>) -> Arc<RobotModel> {
    match last {
        Some(last) if *last.model == model => return Arc::clone(&last.model),
        Some(last) if last.sensors == model.sensors => model.sensors = last.sensors.clone(),
        Some(_) | None => {}
    }
    Arc::new(model)
}

/// Euler steps that are too long for a body blow up, and end in numbers that are none.
fn is_stable(path: &Path, spec: &RobotModel, step: Step) -> Result<()> {
    let dt = step.step_ns as f64 / step.substeps as f64 / SECOND_NS as f64;
    if spec.drive.winding_rate_hz() * dt > FASTEST_WINDING {
        let problem =
            "changes the current far faster than a step; leave it out, and the current follows at once";
        return Err(path.field("motors").field("inductance_h").error(problem));
    }
    let worst = spec.drive.stiffness(dt).into_iter().fold(0.0, f64::max);
    if worst < 2.0 {
        return Ok(());
    }
    let needed = ((step.substeps as f64 * worst) as u64).saturating_add(1);
    let mending = if needed <= MAX_SUBSTEPS {
        format!("set substeps to {needed} or more")
    } else {
        format!(
            "the {MAX_SUBSTEPS} substeps that there can be are too few: it is too light for its motors or damping"
        )
    };
    let problem =
        format!("Euler steps of {} ms are too long for this body and would blow up; {mending}", dt * 1e3);
    Err(path.field("body").error(problem))
}

/// Changes of a winding's equations in a step beyond which nothing is left of the bits of slower ones.
const FASTEST_WINDING: f64 = 1e8;

/// A scenario that would take years is a mistake in a unit.
fn is_affordable(path: &Path, spec: &RobotModel, step: Step) -> Result<()> {
    for sensor in spec.sensors.iter() {
        let Some(fan) = sensor.device.fan() else { continue };
        let period_ns = sensor.own_clock.map_or_else(|| sensor.schedule.period_ns(), |clock| clock.period_ns);
        let rays = step.step_ns.div_ceil(period_ns) * fan.len() as u64;
        if rays > MAX_RAYS_A_TICK {
            let problem = format!("casts {rays} rays a tick, the limit is {MAX_RAYS_A_TICK}");
            return Err(path.field("sensors").field(&sensor.name).field("rays").error(problem));
        }
    }
    Ok(())
}

/// The models of the robots of a table, and their faults, which each has of its own.
fn model(
    path: &Path,
    mut raw: raw::Robot,
    context: &mut World<'_>,
) -> Result<(RobotModel, Vec<faults::RawFault>)> {
    let motors = motors::motors(&path.field("motors"), core::mem::take(&mut raw.motors))?;
    let (signal_limit, motor, timeout) = (motors.signal_limit, motors.encoding, motors.timeout_ns);
    let dead_time_ns = motors.dead_time_ns;
    let Body { outline, radius_m, parts } = Body::new(&path.field("body"), &raw.body)?;
    let drive = drive(&raw.body, radius_m, motors);
    let Equipment { actuators, battery, mut sensors } = equipment(path, &mut raw, radius_m, context)?;
    motors::can_be_regulated(&path.field("motors"), &drive.motor, &sensors)?;
    motors::can_be_counted(&path.field("sensors"), &drive.motor, &sensors)?;
    let motor = cable::speeds(raw.firmware.protocol(&raw.microcontroller), motor, &drive, &sensors);
    let encodings = alloc::vec![motor; 2 + actuators.len()];
    let Mind { processor, link, thinking_ns, firmware } =
        mind(path, &raw, &mut sensors, encodings, context.step)?;
    let on_pins = chip::Parts { sensors: &sensors, motors: &drive.motor, actuators: &actuators, link: &link };
    let chip = chip::chip(path, &raw, &on_pins)?;
    let within_ns = raw.brain.deadline_ms.map(Number::get);
    let model = RobotModel {
        drive,
        outline,
        look: shapes::look(raw.body.height_m, raw.body.color),
        parts,
        signal_limit,
        actuators,
        battery,
        command_timeout_ns: timeout,
        dead_time_ns,
        sensors: sensors.into(),
        processor,
        chip,
        firmware,
        link,
        thinking_ns,
        writes: writes(&path.field("brain"), raw.brain.writes.as_deref())?,
        deadline: faults::deadline(path, within_ns, raw.brain.on_late, context.step.step_ns)?,
        faults: Vec::new(),
        brain_operations: raw.brain.operations,
        brain_memory_bytes: raw.brain.memory_bytes,
    };
    Ok((model, raw.faults))
}

/// The model with the faults of the robot of this name. Faults by chance come by its own random numbers.
fn with_faults(
    path: &Path,
    model: &Arc<RobotModel>,
    (name, seed): (&str, u64),
    raw: &[faults::RawFault],
) -> Result<Arc<RobotModel>> {
    if raw.is_empty() {
        return Ok(Arc::clone(model));
    }
    let mut own = RobotModel::clone(model);
    let parts = faults::Parts { name, seed, sensors: &own.sensors, link: &mut own.link };
    own.faults = faults::faults(path, raw, parts)?;
    Ok(Arc::new(own))
}

/// The brain of a robot, and its exchange with the robot.
struct Mind {
    processor: Processor,
    link: Link,
    thinking_ns: u64,
    firmware: Firmware,
}

fn mind(
    path: &Path,
    raw: &raw::Robot,
    sensors: &mut [Sensor],
    motors: Vec<Encoding>,
    step: Step,
) -> Result<Mind> {
    let processor = microcontroller::processor(&raw.microcontroller);
    let link = link::link(&path.field("link"), &raw.link)?;
    let thinking_ns = brain(path, &raw.brain, &processor, &link)?;
    let on_wire: Vec<_> = sensors.iter().filter(|sensor| sensor.is_on_wire()).collect();
    let at = path.field("firmware");
    let mut firmware = cable::firmware(
        &at,
        (&raw.firmware, raw.firmware.protocol(&raw.microcontroller)),
        &on_wire,
        motors,
        step.step_ns,
        &link,
    )?;
    cable::check_sizes(path, &firmware, &link)?;
    microcontroller::start_later(path, (&processor, &link), &mut firmware, sensors)?;
    Ok(Mind { processor, link, thinking_ns, firmware })
}

/// The parts that are mounted on a robot.
struct Equipment {
    actuators: Vec<Actuator>,
    battery: Option<Battery>,
    sensors: Vec<Sensor>,
}

fn equipment(path: &Path, raw: &mut raw::Robot, radius_m: f64, context: &mut World<'_>) -> Result<Equipment> {
    let tables = core::mem::take(&mut raw.actuators);
    let actuators = each_named(&path.field("actuators"), tables, |path, name, table| {
        actuators::actuator(path, name, table, context.surroundings)
    })?;
    let battery = raw.battery.take().map(|raw| raw.checked(&path.field("battery"))).transpose()?;
    let mut context = sensors::Context {
        step_ns: context.step.step_ns,
        radius_m,
        onboard: raw.link.kind == raw::LinkKind::Onboard
            && !raw.firmware.protocol(&raw.microcontroller).is_dialogue(),
        actuators: &actuators,
        battery: battery.as_ref(),
        surroundings: context.surroundings,
        arena: context.arena,
    };
    let path = path.field("sensors");
    let sensor = |path: &Path, name, table| sensors::sensor(path, name, table, &mut context);
    let mut sensors = each_named(&path, core::mem::take(&mut raw.sensors), sensor)?;
    let protocol = raw.firmware.protocol(&raw.microcontroller);
    if matches!(protocol, raw::Protocol::Create | raw::Protocol::Create2) {
        create::tell_battery(&mut sensors, battery.as_ref());
    }
    if sensors.len() > usize::from(u8::MAX) {
        return Err(path.error(format!("there are {} sensors, the limit is {}", sensors.len(), u8::MAX)));
    }
    // The sensors on the wire keep their order and come first, so that their places are those on the wire.
    sensors.sort_by_key(|sensor| !sensor.is_on_wire());
    Ok(Equipment { actuators, battery, sensors })
}

/// Makes something of each table of a robot's sensors or actuators.
fn each_named<T>(
    path: &Path,
    raw: raw::Tables,
    mut make: impl FnMut(&Path, String, toml::Table) -> Result<T>,
) -> Result<Vec<T>> {
    let mut names = Names::default();
    let mut made = Vec::new();
    for (name, table) in raw.0 {
        let path = path.field(&name);
        let name = names.take(&path, &name)?;
        made.push(make(&path, name, table)?);
    }
    Ok(made)
}

fn drive(body: &raw::Body, radius_m: f64, motors: ParsedMotors) -> Drive {
    let half_track_m = body.half_track_m.map_or(radius_m, Number::get);
    let wheel_radius_m = body.wheel_radius_m.get();
    let (mass_kg, inertia_kg_m2) = (body.mass_kg.get(), body.inertia_kg_m2.get());
    let rotor_kg_m2 = match &motors.motors {
        Motors::Dc(motor) => motor.inertia_at_wheel_kg_m2(),
        Motors::Velocity(_) | Motors::Servo(_) | Motors::Stepper(_) => 0.0,
    };
    let inertia_of_wheel_kg_m2 = body.wheel_inertia_kg_m2.get() + rotor_kg_m2;
    let wheel = Wheel { mass_kg: body.wheel_mass_kg.get(), inertia_kg_m2: inertia_of_wheel_kg_m2 };
    Drive {
        radius_m,
        half_track_m,
        wheel_radius_m,
        mass_kg,
        inertia_kg_m2,
        damping_n_s_m: body.damping_n_s_m.get(),
        turn_damping_nm_s: body.turn_damping_nm_s.get(),
        forward_gain: forward_gain(mass_kg, wheel_radius_m, wheel),
        turn_gain: turn_gain(inertia_kg_m2, half_track_m, wheel_radius_m, wheel),
        motor: motors.motors,
        motor_noise: motors.noise,
        motor_track_factor: motors.track_factor,
        deviation: deviation(body, half_track_m),
    }
}

/// The deviation of a robot from its data sheet; none if there is none.
fn deviation(body: &raw::Body, half_track_m: f64) -> Option<Deviation> {
    let factors = [body.wheel_ratio, body.wheel_scale, body.track_ratio];
    let [wheel_ratio, wheel_scale, track_ratio] = factors.map(|factor| factor.map_or(1.0, Number::get));
    let differs = [wheel_ratio, wheel_scale, track_ratio] != [1.0; 3];
    differs.then(|| Deviation::new(wheel_ratio, wheel_scale, track_ratio * half_track_m))
}

/// The writing of a brain, if that is stated.
fn writes(path: &Path, raw: Option<&str>) -> Result<Option<Writes>> {
    let read = |text: &str| {
        let refused = |error| path.field("writes").error(format!("{error}, is {text:?}"));
        text.parse::<Writes>().map_err(refused)
    };
    raw.map(read).transpose()
}

/// The thinking time of a brain that does not state it, in nanoseconds: a time, or operations of the processor that it
/// runs on. In both ways no longer than [`MAX_THINKING_US`].
fn brain(path: &Path, raw: &raw::Brain, processor: &Processor, link: &Link) -> Result<u64> {
    let path = path.field("brain");
    let onboard = matches!(link, Link::Onboard);
    if !onboard {
        let problem = "is for a brain that is the microcontroller's program: link = { kind = \"onboard\" }";
        path.refuse_all(&given!(raw; operations, memory_bytes), problem)?;
    }
    if let (Some(needs), Some(has)) = (raw.memory_bytes, processor.ram_bytes)
        && needs > has
    {
        let problem = format!("needs {needs} bytes, but the microcontroller has {has} (ram_bytes)");
        return Err(path.field("memory_bytes").error(problem));
    }
    match (raw.thinking_us, raw.operations) {
        (Some(_), Some(_)) => Err(path.field("operations").error("give either this or thinking_us")),
        (thinking, None) => Ok(thinking.map_or(0, Number::get)),
        (None, Some(operations)) => operations_ns(&path.field("operations"), operations, processor),
    }
}

fn operations_ns(path: &Path, operations: u64, processor: &Processor) -> Result<u64> {
    let (Some(ns), Some(per_s)) = (processor.thinking_ns(operations), processor.operations_per_s) else {
        return Err(path.error("needs microcontroller.operations_per_s"));
    };
    let limit_s = MAX_THINKING_US / 1e6;
    if ns as f64 > MAX_THINKING_US * 1e3 {
        let problem = format!(
            "must be done in {limit_s} s or less; at microcontroller.operations_per_s = {per_s}, {operations} take \
             {} s",
            operations as f64 / per_s
        );
        return Err(path.error(problem));
    }
    Ok(ns)
}

/// Longest thinking, in microseconds.
const MAX_THINKING_US: f64 = 1e9;
