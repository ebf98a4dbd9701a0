//! `baudbot check`: what a scenario is.

use std::fmt::Write;

use baudbot_geometry::{Bounds, Circle, Fan, Segment};
use baudbot_import::Weight;
use baudbot_plot::arena;
use baudbot_plot::quantity::{count, duration, handy};
use baudbot_sim::Scenario;
use baudbot_sim::arena::Arena;
use baudbot_sim::collision::CollisionPolicy;
use baudbot_sim::scenario::SerialPort;
use baudbot_sim::sensor::{Device, SensorKind};

use crate::args::CheckArgs;
use crate::error::Refused;
use crate::export::ends_meet;
use crate::output_files::Inputs;
use crate::robot_groups;
use crate::run::overrides;
use crate::scenarios::{self, Source};
use crate::text::{self, pairs, percent};
use crate::together;

mod chip;
mod json;
mod robot;

pub(crate) fn check(args: &CheckArgs) -> anyhow::Result<()> {
    let svg = args.svg.iter().map(|path| ("--svg", path.as_path()));
    Inputs::of(&args.scenario, &args.changes).check(svg)?;
    let found = read(args).inspect_err(|error| {
        if args.json && error.is::<Refused>() {
            // The error itself follows on stderr.
            let _ = text::print_json(&json::refused(&args.scenario, &error.to_string()));
        }
    });
    let (source, scenario) = found?;
    if let Some(path) = &args.svg {
        let picture = arena::draw(&scenario, source.label());
        text::write(path, &picture)?;
        // A picture on stdout is for another program, which a text behind it would confuse.
        if path.as_os_str() == "-" {
            return Ok(());
        }
    }
    if args.json {
        return text::print_json(&json::sound(&source, &scenario));
    }
    text::print(&describe(&source, &scenario))
}

fn read(args: &CheckArgs) -> anyhow::Result<(Source, Scenario)> {
    let source = Source::find(&args.scenario)?;
    let scenario = source.parse(&overrides(&args.changes)?)?;
    Ok((source, scenario))
}

fn describe(source: &Source, scenario: &Scenario) -> String {
    let mut text = format!("{}: valid\n", source.label());
    text += &pairs("  ", &facts(scenario));
    for (robot, count) in robot_groups::first_of_each(&scenario.robots) {
        text.push('\n');
        text += &robot::describe(robot);
        text += &robot_groups::others(robot, count);
    }
    for note in source.notes(Weight::Remark) {
        let _ = writeln!(text, "\nnote: {note}");
    }
    for warning in scenarios::warnings(source, scenario) {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    for (robot, warning) in of_robots(scenario) {
        let _ = writeln!(text, "\nwarning: robot `{robot}`: {warning}");
    }
    text
}

/// The warnings for robots, each with a robot's name.
fn of_robots(scenario: &Scenario) -> Vec<(&str, String)> {
    let mut warnings = together::all_warnings(scenario);
    for (robot, _) in robot_groups::first_of_each(&scenario.robots) {
        let full_turns = robot.sensors.iter().filter_map(|sensor| Some((sensor, full_turn(&sensor.device)?)));
        warnings.extend(full_turns.map(|(sensor, fan)| {
            let (name, rays) = (&sensor.name, fan.len());
            let fewer = rays - 1;
            let problem = format!(
                "sensors.{name}: the last of the {rays} rays coincides with the first; ROS bags omit it, and {fewer} rays over \
                 opening_rad = {} are the same without it",
                fan.opening_rad() * (rays - 2) as f64 / fewer as f64
            );
            (robot.name.as_str(), problem)
        }));
    }
    warnings
}

/// The rays of a laser that go all around, the first of them twice.
fn full_turn(device: &Device) -> Option<&Fan> {
    let is_laser = device.sensor_kind() == SensorKind::Laser;
    device.fan().filter(|fan| is_laser && ends_meet(fan))
}

fn facts(scenario: &Scenario) -> Vec<(&'static str, String)> {
    let substeps = count(scenario.substeps as usize, "substep");
    let collision = match scenario.collision {
        CollisionPolicy::StopRun => "ends the run".to_owned(),
        CollisionPolicy::StopRobot => "stops the robot".to_owned(),
        CollisionPolicy::Slide { friction } => format!("slides along, friction {friction}"),
    };
    vec![
        ("name", scenario.name.clone()),
        ("description", text::one_line(&scenario.description)),
        ("step", format!("{} in {substeps}", duration(scenario.step_ns as f64))),
        ("seed", format!("{}, sensor noise {}", scenario.seed, if scenario.noise { "on" } else { "off" })),
        ("arena", arena(&scenario.arena)),
        ("in it", things(scenario)),
        ("collision", collision),
        ("end", end(scenario)),
        ("robots", scenario.robots.len().to_string()),
        ("serial ports", serial_ports(&scenario.serial_ports)),
    ]
    .into_iter()
    .filter(|(_, value)| !value.is_empty())
    .collect()
}

/// The ports as `--port` takes them.
fn serial_ports(ports: &[SerialPort]) -> String {
    let port = |SerialPort { robot, sensor, endpoint }: &SerialPort| {
        let sensor = sensor.as_ref().map_or_else(String::new, |sensor| format!("/{sensor}"));
        format!("{robot}{sensor}={endpoint}")
    };
    ports.iter().map(port).collect::<Vec<_>>().join(", ")
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

/// The contents of the arena besides walls and robots.
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

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    pub(super) fn scenario(name: &str, sets: &[&str]) -> Scenario {
        let sets: Vec<_> = sets.iter().map(|set| baudbot_scenario::Override::parse(set).unwrap()).collect();
        Source::find(name).unwrap().parse(&sets).unwrap()
    }

    #[test]
    fn a_laser_whose_first_ray_stands_twice_is_told_of() {
        let told = |rays: usize, opening_rad: f64| {
            let laser = format!(
                "robots.robot.sensors.eye={{kind=\"laser\",mount={{}},opening_rad={opening_rad:?},rays={rays},range_m=4,\
                 port={{link={{kind=\"ideal\"}}}},period_ms=100}}"
            );
            let scenario = scenario("wander", &[&laser]);
            of_robots(&scenario)
                .into_iter()
                .map(|(robot, warning)| format!("{robot}: {warning}"))
                .collect::<Vec<_>>()
        };
        let [full] = &told(721, TAU)[..] else { panic!("one warning") };
        let least = "robot: sensors.eye: the last of the 721 rays coincides with the first; ROS bags omit it, and 720 rays over \
                     opening_rad = 6.274458";
        assert!(full.starts_with(least), "{full}");
        assert_eq!(told(720, TAU * 719.0 / 720.0), [""; 0]);
        assert_eq!(told(682, 4.18), [""; 0]);
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
}
