//! The description of a scenario's robot, and the cost of its messages on its cable.

use std::fmt::Write;

use baudbot_geometry::Pose;
use baudbot_plot::quantity::{NOTHING, count, duration, handy};
use baudbot_sim::drive::{Deviation, Drive, Wheels};
use baudbot_sim::fault::{Fault, When};
use baudbot_sim::firmware::{Mode, Protocol};
use baudbot_sim::model::{Deadline, OnLate, RobotSpec};
use baudbot_sim::sensor::Sensor;
use baudbot_wire::Encoding;

use super::chip;
use crate::link;
use crate::text::{pairs, percent, table};

/// A robot with all that it carries, and what its messages cost.
pub(super) fn describe(robot: &RobotSpec) -> String {
    let load = load(robot);
    let mut facts = equipment(robot);
    match &robot.chip {
        Some(chip) => facts.extend(chip::describe(robot, chip)),
        None => facts.extend(messages(robot)),
    }
    facts.extend(deadline(&robot.deadline).map(|deadline| ("deadline", deadline)));
    let fault = |fault: &Fault| ("fault", format!("{}, {}", fault.kind, when(&fault.when)));
    facts.extend(robot.faults.iter().map(fault));
    let uplink =
        |(bytes, used)| ("uplink", format!("{} bytes/s, {} of its capacity", handy(bytes), percent(used)));
    facts.extend(load.map(uplink));
    let mut text = format!("robot {}\n{}", robot.name, pairs("  ", &facts));
    if load.is_some_and(|(_, used)| used > 1.0) {
        let _ = writeln!(text, "  warning: the uplink cannot carry that much; frames will be skipped");
    }
    if let Some(chip) = &robot.chip {
        text += "  pins\n";
        text += &table("    ", &chip::pins(chip));
    }
    if !robot.sensors.is_empty() {
        text += "  sensors\n";
        text += &table("    ", &sensors(robot));
    }
    text
}

/// The robot's pose, and its equipment besides sensors.
fn equipment(robot: &RobotSpec) -> Vec<(&'static str, String)> {
    let Pose { position, heading } = robot.start.pose;
    let encoding = encoding(robot.firmware.motor_encoding());
    let mut facts = vec![
        ("start", format!("x {} m, y {} m, heading {heading} rad", position.x, position.y)),
        ("body", body(robot)),
        ("motors", format!("{}, signals of {encoding}", robot.drive.motor.kind())),
    ];
    if !robot.actuators.is_empty() {
        let actuators =
            robot.actuators.iter().map(|actuator| format!("{} ({})", actuator.name, actuator.kind()));
        facts.push(("actuators", actuators.collect::<Vec<_>>().join(", ")));
    }
    if let Some(battery) = &robot.battery {
        let capacity = handy(battery.capacity_c() / 3.6);
        let battery = format!("{} V, {capacity} mAh, {} full", battery.nominal_v, percent(battery.charge));
        facts.push(("battery", battery));
    }
    facts
}

/// The protocol, and the length of its messages.
fn messages(robot: &RobotSpec) -> [(&'static str, String); 4] {
    [
        ("firmware", firmware(robot)),
        ("link", link::text(&robot.link)),
        ("readings", message(robot, robot.firmware.readings_len_max(), "with all sensors")),
        ("command", message(robot, robot.firmware.command_len_max(), "each")),
    ]
}

fn body(robot: &RobotSpec) -> String {
    let drive = &robot.drive;
    let shape = match robot.outline.len() {
        0 => format!("radius {} m", drive.radius_m),
        corners => format!("{corners} corners in a radius of {} m", handy(drive.radius_m)),
    };
    format!(
        "{shape}, {} kg, wheels of radius {} m, {} m apart{}",
        drive.mass_kg,
        drive.wheel_radius_m,
        handy(2.0 * drive.half_track_m),
        drive.deviation.map_or(String::new(), |deviation| specimen(drive, &deviation))
    )
}

/// The deviations of one robot from its data sheet.
fn specimen(drive: &Drive, deviation: &Deviation) -> String {
    let Wheels { left, right } = deviation.wheels;
    format!(
        "; in truth the left wheel is {left:.6} and the right wheel {right:.6} times as large, and the distance {:.6} times",
        deviation.half_track_m / drive.half_track_m
    )
}

/// The deadline of a brain, if the scenario states one.
fn deadline(deadline: &Deadline) -> Option<String> {
    let late = match deadline.on_late? {
        OnLate::Hold => "the last command stays in effect until a late brain answers",
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
    let title = robot.firmware.protocol.title();
    let protocol = if let Protocol::Framed { ages } = robot.firmware.protocol {
        format!("{title}, {} ages", if ages { "with" } else { "without" })
    } else if let Protocol::Bare { gap_ns } = robot.firmware.protocol {
        format!("{title}, a gap of {} ends a message", duration(gap_ns as f64))
    } else {
        title.to_owned()
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
pub(super) fn load(robot: &RobotSpec) -> Option<(f64, f64)> {
    if robot.chip.is_some() {
        return None;
    }
    let Mode::Stream(schedule) = robot.firmware.mode else { return None };
    let frames = 1e9 / schedule.period_ns() as f64;
    let mut bytes = robot.firmware.readings_len_max() as f64 * frames;
    if let Protocol::Framed { ages } = robot.firmware.protocol {
        for sensor in robot.sensors.iter().filter(|sensor| sensor.is_on_wire()) {
            let entry = robot.firmware.protocol.values_len_max(&sensor.encodings) + usize::from(ages);
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
            None => robot.firmware.protocol.values_len_max(&sensor.encodings),
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

/// The times at which it is read, with the first; or, with a port of its own, those at which it speaks.
fn times(sensor: &Sensor) -> (String, String) {
    let show = |ns: u64| duration(ns as f64);
    let phase = match sensor.own_clock {
        Some(clock) if sensor.port.is_some() => clock.phase_ns.map_or_else(|| NOTHING.to_owned(), show),
        _ => show(sensor.schedule.phase_ns()),
    };
    (show(period_ns(sensor)), phase)
}

pub(super) fn period_ns(sensor: &Sensor) -> u64 {
    match sensor.own_clock {
        Some(clock) if sensor.port.is_some() => clock.period_ns,
        _ => sensor.schedule.period_ns(),
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
    use crate::check::tests::scenario;

    #[test]
    fn wanders_cable_just_keeps_up() {
        // A frame of five 8-bit readings is 8 + 1 + 5 · 2 = 19 bytes, 50 times a second.
        let wander = scenario("wander", &[]);
        let (bytes, used) = load(&wander.robots[0]).unwrap();
        assert_eq!((wander.robots[0].firmware.readings_len_max(), bytes), (19, 950.0));
        assert!((used - 950.0 / 960.0).abs() < 1e-12);
        assert!(!describe(&wander.robots[0]).contains("warning"));
    }

    #[test]
    fn a_slow_cable_is_warned_of() {
        let slow = scenario("wander", &["robots.robot.link.baud=4800"]);
        assert!(describe(&slow.robots[0]).contains("warning: the uplink cannot carry"));
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
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/devices/khepera-ascii.toml");
        let text = describe(&scenario(path, &[]).robots[0]);
        for part in [
            "khepera, lines of text; answers when polled\n",
            "43 bytes with all sensors, 49.271 ms on the link\n",
            "    ir_7            ir   20 ms  17.5 ms      10 bits      5\n",
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
