//! `baudbot check`: what a scenario is.

use std::fmt::Write;

use baudbot_geometry::{Bounds, Circle, Segment};
use baudbot_plot::arena;
use baudbot_plot::quantity::{NOTHING, count, duration, handy};
use baudbot_sim::Scenario;
use baudbot_sim::arena::Arena;
use baudbot_sim::collision::CollisionPolicy;
use baudbot_sim::fault::When;
use baudbot_sim::firmware::{Mode, Protocol};
use baudbot_sim::model::{Deadline, OnLate, RobotSpec};
use baudbot_sim::sensor::Sensor;
use baudbot_wire::Encoding;

use crate::alike;
use crate::args::CheckArgs;
use crate::link;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text::{self, pairs, percent, table};
use crate::together;

pub(crate) fn check(args: &CheckArgs) -> anyhow::Result<()> {
    let source = Source::find(&args.scenario)?;
    let scenario = source.parse(&overrides(&args.changes)?)?;
    if let Some(path) = &args.svg {
        let picture = arena::draw(&scenario, source.label());
        text::write(path, &picture)?;
        // A picture on stdout is for another program, which a text behind it would confuse.
        if path.as_os_str() == "-" {
            return Ok(());
        }
    }
    text::print(&describe(&source, &scenario))
}

fn describe(source: &Source, scenario: &Scenario) -> String {
    let mut text = format!("{}: sound\n", source.label());
    text += &pairs("  ", &facts(scenario));
    for (robot, count) in alike::first_of_each(&scenario.robots) {
        text.push('\n');
        text += &describe_robot(robot);
        text += &alike::others(robot, count);
    }
    for warning in baudbot_scenario::warnings(scenario) {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    for (robot, warning) in together::all_warnings(scenario) {
        let _ = writeln!(text, "\nwarning: robot `{robot}`: {warning}");
    }
    text
}

fn facts(scenario: &Scenario) -> Vec<(&'static str, String)> {
    let substeps = count(scenario.substeps as usize, "substep");
    let collision = match scenario.collision {
        CollisionPolicy::StopRun => "ends the run",
        CollisionPolicy::StopRobot => "stops the robot",
    };
    vec![
        ("name", scenario.name.to_owned()),
        ("description", text::one_line(&scenario.description)),
        ("step", format!("{} in {substeps}", duration(scenario.step_ns as f64))),
        ("seed", format!("{}, sensor noise {}", scenario.seed, if scenario.noise { "on" } else { "off" })),
        ("arena", arena(&scenario.arena)),
        ("in it", things(scenario)),
        ("collision", collision.to_owned()),
        ("end", end(scenario)),
        ("robots", scenario.robots.len().to_string()),
    ]
    .into_iter()
    .filter(|(_, value)| !value.is_empty())
    .collect()
}

fn arena(arena: &Arena) -> String {
    let (solid, hollow): (Vec<_>, Vec<_>) = arena.polygons().iter().partition(|polygon| polygon.solid);
    let shapes =
        [(solid.len(), "solid polygon"), (hollow.len(), "hollow polygon"), (arena.pillars().len(), "circle")];
    let shapes: Vec<_> = shapes.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| count(n, what)).collect();
    let corners = arena.polygons().iter().flat_map(|polygon| &polygon.points);
    let corners = corners.map(|&point| Bounds::of_segment(&Segment { start: point, end: point }));
    let pillars = arena.pillars().iter().map(|pillar| Bounds::of_circle(&pillar.circle));
    match corners.chain(pillars).reduce(|a, b| a.union(&b)) {
        None => "empty".to_owned(),
        Some(Bounds { min, max }) => {
            format!("{}; x from {} to {} m, y from {} to {} m", shapes.join(", "), min.x, max.x, min.y, max.y)
        }
    }
}

/// What is in the arena besides walls and robots.
fn things(scenario: &Scenario) -> String {
    let around = &scenario.surroundings;
    let things = [
        (around.zones.len(), "zone"),
        (around.lights.len(), "lamp"),
        (around.fields.len(), "field"),
        (scenario.movers.len(), "mover"),
        (scenario.movables.len(), "movable"),
    ];
    let things: Vec<_> = things.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| count(n, what)).collect();
    things.join(", ")
}

fn end(scenario: &Scenario) -> String {
    let mut ends = Vec::new();
    if let Some(after) = scenario.end.after {
        ends.push(format!("after {} s", handy(after.as_seconds())));
    }
    if let Some(Circle { center, radius }) = scenario.end.goal {
        ends.push(format!("when a robot is within {radius} m of ({}, {}) m", center.x, center.y));
    }
    let rules = &scenario.rules;
    if let Some(collisions) = rules.collisions {
        let collisions = usize::try_from(collisions).unwrap_or(usize::MAX);
        ends.push(format!("after {}", count(collisions, "collision")));
    }
    if rules.all_goals {
        ends.push("when all goals are reached".to_owned());
    }
    if let Some(share) = rules.covered {
        ends.push(format!("when {} of the floor is covered", percent(share)));
    }
    if let Some(share) = rules.sensed {
        ends.push(format!("when {} of the floor is sensed", percent(share)));
    }
    if rules.battery_empty {
        ends.push("when a battery is empty".to_owned());
    }
    if ends.is_empty() { "none; `baudbot run` ends it after 60 s".to_owned() } else { ends.join(", or ") }
}

fn describe_robot(robot: &RobotSpec) -> String {
    let drive = &robot.drive;
    let position = robot.start.pose.position;
    let mut facts = vec![
        (
            "start",
            format!("x {} m, y {} m, heading {} rad", position.x, position.y, robot.start.pose.heading),
        ),
        ("body", body(robot)),
        (
            "motors",
            format!("{}, signals of {}", drive.motor.kind(), encoding(robot.firmware.motor_encoding())),
        ),
    ];
    if !robot.actuators.is_empty() {
        let actuators =
            robot.actuators.iter().map(|actuator| format!("{} ({})", actuator.name, actuator.kind()));
        facts.push(("actuators", actuators.collect::<Vec<_>>().join(", ")));
    }
    if let Some(battery) = &robot.battery {
        let capacity = handy(battery.capacity_c / 3.6);
        let battery = format!("{} V, {capacity} mAh, {} full", battery.nominal_v, percent(robot.charge));
        facts.push(("battery", battery));
    }
    facts.extend([
        ("firmware", firmware(robot)),
        ("link", link::text(&robot.link)),
        ("readings", message(robot, robot.firmware.readings_len_max(), "with all sensors")),
        ("command", message(robot, robot.firmware.command_len_max(), "each")),
    ]);
    facts.extend(deadline(&robot.deadline).map(|deadline| ("deadline", deadline)));
    facts
        .extend(robot.faults.iter().map(|fault| ("fault", format!("{}, {}", fault.kind, when(&fault.when)))));
    let load = load(robot);
    if let Some((bytes, used)) = load {
        facts.push(("up line", format!("{} bytes/s, {} of its capacity", handy(bytes), percent(used))));
    }
    let mut text = format!("robot {}\n{}", robot.name, pairs("  ", &facts));
    if load.is_some_and(|(_, used)| used > 1.0) {
        let _ = writeln!(text, "  warning: the up line cannot carry that much; frames will be left out");
    }
    if !robot.sensors.is_empty() {
        text += "  sensors\n";
        text += &table("    ", &sensors(robot));
    }
    text
}

fn body(robot: &RobotSpec) -> String {
    let drive = &robot.drive;
    let shape = match robot.outline.len() {
        0 => format!("radius {} m", drive.radius_m),
        corners => format!("{corners} corners in a radius of {} m", handy(drive.radius_m)),
    };
    format!(
        "{shape}, {} kg, wheels of radius {} m, {} m apart",
        drive.mass_kg,
        drive.wheel_radius_m,
        handy(2.0 * drive.half_track_m)
    )
}

/// The deadline of a brain, if the scenario states one.
fn deadline(deadline: &Deadline) -> Option<String> {
    let late = match deadline.on_late? {
        OnLate::Hold => "the last command holds until a late brain answers",
        OnLate::Stop => "then the motors stop until the next command",
        OnLate::End => "then the run ends",
    };
    Some(format!("{} a cycle; {late}", duration(deadline.within_ns as f64)))
}

fn when(when: &When) -> String {
    match *when {
        When::Once { from, until } => {
            format!("from {} s on for {}", handy(from.as_seconds()), duration(until.since(from) as f64))
        }
        When::Each { every_ns, for_ns, .. } => {
            format!("for {} in every {}", duration(for_ns as f64), duration(every_ns as f64))
        }
    }
}

fn firmware(robot: &RobotSpec) -> String {
    let protocol = match robot.firmware.protocol {
        Protocol::Framed { ages: true } => "framed, with ages".to_owned(),
        Protocol::Framed { ages: false } => "framed, without ages".to_owned(),
        Protocol::Bare { gap_ns } => format!("bare, a gap of {} ends a message", duration(gap_ns as f64)),
        Protocol::Khepera => "khepera, lines of text".to_owned(),
    };
    match robot.firmware.mode {
        Mode::Poll => format!("{protocol}; answers when polled"),
        Mode::Stream(schedule) => {
            let [period, phase] = [schedule.period_ns(), schedule.phase_ns()].map(|ns| duration(ns as f64));
            format!("{protocol}; streams every {period} from {phase} on")
        }
    }
}

fn message(robot: &RobotSpec, bytes: usize, which: &str) -> String {
    let bytes_text = count(bytes, "byte");
    match link::transfer_ns(&robot.link, bytes) {
        None => format!("{bytes_text} {which}"),
        Some(ns) => format!("{bytes_text} {which}, {} on the link", duration(ns)),
    }
}

/// Bytes that a streaming firmware wants to send in a second, and which share of the line's capacity that is.
/// A sensor is in a frame only if it has a new sample.
fn load(robot: &RobotSpec) -> Option<(f64, f64)> {
    let Mode::Stream(schedule) = robot.firmware.mode else { return None };
    let frames = 1e9 / schedule.period_ns() as f64;
    let mut bytes = robot.firmware.readings_len_max() as f64 * frames;
    if let Protocol::Framed { ages } = robot.firmware.protocol {
        for sensor in robot.sensors.iter().filter(|sensor| sensor.is_on_wire()) {
            let entry = robot.firmware.values_len_max(&sensor.encodings) + usize::from(ages);
            let samples = 1e9 / sensor.schedule.period_ns() as f64;
            bytes -= entry as f64 * (frames - samples).max(0.0);
        }
    }
    Some((bytes, bytes / link::bytes_per_second(&robot.link)?))
}

fn sensors(robot: &RobotSpec) -> Vec<[String; 6]> {
    let row = |sensor: &Sensor| {
        let encodings = match (sensor.encodings.as_slice(), &sensor.port) {
            (values, Some(_)) => format!("{} on its own port", values.len()),
            ([], None) => String::new(),
            ([one], None) => encoding(*one),
            (several, None) => format!("{} × {}", several.len(), encoding(several[0])),
        };
        let bytes = match &sensor.port {
            Some(port) => port.format.message_len(&sensor.device),
            None => robot.firmware.values_len_max(&sensor.encodings),
        };
        let (period, phase) = times(sensor);
        let kind = sensor.device.kind().to_owned();
        [sensor.name.clone(), kind, period, phase, encodings, bytes.to_string()]
    };
    let head = ["", "kind", "period", "phase", "values", "bytes"];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(robot.sensors.iter().map(row));
    rows
}

/// How often, and from when on, it is read; or, with a port of its own, it speaks.
fn times(sensor: &Sensor) -> (String, String) {
    let show = |ns: u64| duration(ns as f64);
    match sensor.own_clock {
        Some(clock) if sensor.port.is_some() => {
            (show(clock.period_ns), clock.phase_ns.map_or_else(|| NOTHING.to_owned(), show))
        }
        _ => (show(sensor.schedule.period_ns()), show(sensor.schedule.phase_ns())),
    }
}

fn encoding(encoding: Encoding) -> String {
    match encoding {
        Encoding::Float64 => "64 bits, exact".to_owned(),
        Encoding::Level { bits, .. } | Encoding::Counter { bits } | Encoding::Signed { bits, .. } => {
            count(bits as usize, "bit")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(name: &str, sets: &[&str]) -> Scenario {
        let sets: Vec<_> = sets.iter().map(|set| baudbot_scenario::Override::parse(set).unwrap()).collect();
        Source::find(name).unwrap().parse(&sets).unwrap()
    }

    #[test]
    fn wanders_cable_just_keeps_up() {
        // A frame of five 8-bit readings is 8 + 1 + 5 · 2 = 19 bytes, 50 times a second.
        let wander = scenario("wander", &[]);
        let (bytes, used) = load(&wander.robots[0]).unwrap();
        assert_eq!((wander.robots[0].firmware.readings_len_max(), bytes), (19, 950.0));
        assert!((used - 950.0 / 960.0).abs() < 1e-12);
        assert!(!describe(&Source::find("wander").unwrap(), &wander).contains("warning"));
    }

    #[test]
    fn every_end_is_told_of() {
        let goal = "arena.zones=[{name=\"g\",x_m=0,y_m=0,radius_m=0.1,goal=true}]";
        let ends = "end={collisions=3,all_goals=true,covered=0.5,sensed=0.25,battery_empty=true}";
        let metrics = "metrics={cell_m=0.1,sensed_by=\"ir_left\"}";
        let battery = "robots.robot.battery={nominal_v=12,capacity_mah=1000}";
        let end = end(&scenario("wander", &[goal, ends, metrics, battery]));
        assert_eq!(
            end,
            "after 3 collisions, or when all goals are reached, or when 50.0 % of the floor is covered, or when \
             25.0 % of the floor is sensed, or when a battery is empty"
        );
    }

    #[test]
    fn what_stands_about_and_what_a_robot_carries_is_told_of() {
        let sets = [
            "arena.movables=[{name=\"b\",radius_m=0.1,x_m=1,y_m=1,mass_kg=1,friction=0.1}]",
            "arena.lights=[{name=\"l\",x_m=1,y_m=1,intensity_cd=9}, {name=\"m\",x_m=1,y_m=0,intensity_cd=9}]",
            "robots.robot.actuators={horn={kind=\"speaker\",level=1}}",
            "robots.robot.battery={nominal_v=12,capacity_mah=1000}",
            "robots.robot.body={outline_m=[[0.2,0],[-0.1,0.1],[-0.1,-0.1]],mass_kg=3,inertia_kg_m2=0.2,\
             wheel_radius_m=0.1,damping_n_s_m=15,turn_damping_nm_s=0.78}",
        ];
        let text = describe(&Source::find("wander").unwrap(), &scenario("wander", &sets));
        for part in [
            "in it        2 lamps, 1 movable\n",
            "3 corners in a radius of 0.2 m,",
            "horn (speaker)\n",
            "12 V, 1000 mAh, 100.0 % full\n",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
    }

    #[test]
    fn of_robots_that_are_alike_the_first_is_described() {
        let starts = "starts = [{ x_m = -1 }, { x_m = 1 }, { name = \"a\" }]";
        let text = format!(
            "[[robots]]\nname = \"r\"\n{starts}\n\
             body = {{ radius_m = 0.2, mass_kg = 3, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n"
        );
        let text = describe(&Source::find("wander").unwrap(), &baudbot_scenario::parse(&text).unwrap());
        assert!(text.contains("  robots     3\n") && text.matches("\nrobot ").count() == 1, "{text}");
        assert!(text.contains("\nrobot a\n  start     x 0 m"), "{text}");
        assert!(text.ends_with("  and 2 more of `r`, identical but for their start\n"), "{text}");
    }

    #[test]
    fn a_slow_cable_is_warned_of() {
        let slow = scenario("wander", &["robots.robot.link.baud=4800"]);
        assert!(describe_robot(&slow.robots[0]).contains("warning: the up line cannot carry"));
    }

    #[test]
    fn a_sensor_without_news_is_in_no_frame() {
        // 100 frames a second of 4 + 4 + 2 bytes; 8 sensors of 1 + 2 bytes at 50 Hz; encoders of 1 + 4.
        let khepera = scenario("khepera", &[]);
        let (bytes, _) = load(&khepera.robots[0]).unwrap();
        assert!((bytes - (100.0 * 10.0 + 50.0 * 8.0 * 3.0 + 100.0 * 5.0)).abs() < 1e-9, "{bytes}");
    }

    #[test]
    fn lines_of_text_are_told_with_their_greatest_length() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/devices/khepera-ascii.toml");
        let text = describe_robot(&scenario(path, &[]).robots[0]);
        for part in [
            "khepera, lines of text; answers when polled\n",
            "43 bytes with all sensors, 49.271 ms on the link\n",
            "    ir_7    ir   20 ms  17.5 ms  10 bits      5\n",
            "12 bytes each, 13.75 ms on the link\n",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
    }

    #[test]
    fn an_ideal_link_has_no_load_and_a_polled_firmware_none_either() {
        assert!(load(&scenario("arsim", &[]).robots[0]).is_none());
        let polled = "robots.robot.firmware={mode=\"poll\"}";
        assert!(load(&scenario("wander", &[polled]).robots[0]).is_none());
    }
}
