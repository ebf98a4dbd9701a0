//! A robot's part of a summary: facts about its brain, its chip and its body, and tables of its cables and sensors.

use std::fmt::Write;

use baudbot_fields::printable::Printable;
use baudbot_plot::quantity::{NOTHING, count, duration, handy};

use crate::summary::{
    Battery, Chip, ChipWarning, Cycles, Durations, Line, Robot, Rounds, Sensor, Thinking, Zone,
};
use crate::text::{pairs, percent, table};

/// All about a robot, in a run that lasted so long.
pub(super) fn text(robot: &Robot, simulated_s: f64) -> String {
    let mut text = format!("robot {}\n", robot.robot);
    text += &pairs("  ", &facts(robot, simulated_s));
    if robot.has_program_only() {
        text += &table("    ", &program_lines(robot));
        if !robot.sensors.is_empty() {
            let _ = writeln!(text, "  sensors, with the numbers of their readings");
            text += &table("    ", &program_sensors(robot));
        }
        return text;
    }
    text += &table("    ", &lines(robot));
    if !robot.sensors.is_empty() {
        let _ = writeln!(text, "  sensors, with the ages of their readings when the brain got them");
        text += &table("    ", &sensors(robot));
    }
    text
}

fn facts(robot: &Robot, simulated_s: f64) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    if !robot.has_program_only() {
        let brain = match (robot.brain.as_str(), robot.turns) {
            ("", 0) => "none",
            // The brain may have left, or there never was one: turns are those of the robot.
            ("", _) => "none at the end",
            (brain, _) => brain,
        };
        let text = format!("{brain}, {} turns, {} commands obeyed", robot.turns, robot.commands);
        facts.push(("brain", text));
    }
    facts.extend(habit(robot, simulated_s).map(|habit| ("hint", habit)));
    if !robot.said.is_empty() {
        facts.push(("said", Printable(&robot.said).to_string()));
    }
    facts.extend(robot.chip.iter().flat_map(|chip| self::chip(chip, robot.uplink.bytes)));
    let [distance, speed] = [robot.distance_m, robot.distance_m / simulated_s].map(handy);
    let collisions = count(usize::try_from(robot.collisions).unwrap_or(usize::MAX), "collision");
    let stood = match robot.stood_in_contact_s {
        0.0 => String::new(),
        stood_s => format!(", stood in contact for {} s", handy(stood_s)),
    };
    facts.push(("driven", format!("{distance} m, {speed} m/s on average, {collisions}{stood}")));
    facts.push(("link", link(robot)));
    if !robot.has_program_only() {
        facts.push(("cycles", cycles(&robot.cycles)));
    }
    let clocks = [(&robot.thinking_wall, "the wall clock"), (&robot.thinking_processor, "processor time")];
    let thinking = clocks.into_iter().filter_map(|(thinking, clock)| Some((thinking.as_ref()?, clock)));
    facts.extend(thinking.map(|(thinking, clock)| ("thinking", self::thinking(thinking, clock))));
    facts.extend(losses(robot).map(|losses| ("lost", losses)));
    facts.extend(overload(robot));
    facts.extend(robot.battery.as_ref().map(|battery| ("battery", self::battery(battery))));
    if !robot.zones.is_empty() {
        let zone = |zone: &Zone| format!("{} {} s", zone.zone, handy(zone.time_s));
        facts.push(("zones", robot.zones.iter().map(zone).collect::<Vec<_>>().join(", ")));
    }
    facts
}

/// An oddity of the rate at which a brain wrote.
fn habit(robot: &Robot, simulated_s: f64) -> Option<String> {
    if robot.brain.is_empty() || robot.turns == 0 {
        return None;
    }
    if robot.downlink.bytes == 0 {
        return Some(format!(
            "the brain sent nothing in {} turns: does its step return a command?",
            robot.turns
        ));
    }
    let times = times_too_often(robot.commands, robot.uplink.messages, simulated_s)?;
    Some(format!("the brain wrote {times} commands for each message that it got: one is enough"))
}

/// The number of commands for each message, if there were too many: each takes the cable from the next. Repetitions are
/// right where few messages come.
fn times_too_often(commands: u64, messages: u64, simulated_s: f64) -> Option<String> {
    let enough = (messages as f64).max(REPEATS_PER_S * simulated_s);
    (messages > 0 && commands as f64 > OFTEN * enough)
        .then(|| format!("{:.1}", commands as f64 / messages as f64))
}

/// So often a brain may repeat its command without news.
const REPEATS_PER_S: f64 = 10.0;

/// The ratio of commands to those that are enough, above which there are too many.
const OFTEN: f64 = 1.5;

/// The events of a chip, the bytes that it sent, and the acts of its program or its wiring that are hardly meant.
fn chip(chip: &Chip, sent_bytes: u64) -> impl Iterator<Item = (&'static str, String)> {
    let mhz = f64::from(chip.clock_hz) / 1e6;
    let resets = match chip.watchdog_resets {
        0 => String::new(),
        n => format!(", {} by its watchdog", count(n as usize, "reset")),
    };
    let text = format!(
        "{} at {mhz} MHz, {} cycles, a stack of {} bytes at most{resets}",
        chip.part, chip.cycles, chip.stack_bytes
    );
    let warning = |warning: &ChipWarning| {
        let at = match (&warning.pin, &warning.part) {
            (pin, _) if !pin.is_empty() => format!("pin {pin}: "),
            (_, part) if !part.is_empty() => format!("{part}: "),
            _ => String::new(),
        };
        let first = handy(warning.first_s);
        ("warning", format!("{at}{} ({} times, first at {first} s)", warning.problem, warning.count))
    };
    let sent = count(usize::try_from(sent_bytes).unwrap_or(usize::MAX), "byte");
    let sent = match &chip.last_line {
        Some(line) => format!("{sent}; the last line is \"{}\"", Printable(line)),
        None => sent,
    };
    let rounds = chip.rounds.iter().map(|rounds| ("main loop", self::rounds(rounds, chip.asleep_percent)));
    [("chip", text), ("sent", sent)]
        .into_iter()
        .chain(rounds.collect::<Vec<_>>())
        .chain(chip.warnings.iter().map(warning).collect::<Vec<_>>())
}

/// The durations of a main loop's rounds.
fn rounds(rounds: &Rounds, asleep_percent: Option<f64>) -> String {
    let Rounds { count, least_cycles, mean_cycles, most_cycles, least_ms, mean_ms, most_ms } = *rounds;
    let [least, mean, most] = [least_ms, mean_ms, most_ms].map(|ms| duration(ms * 1e6));
    let asleep = asleep_percent.filter(|percent| *percent > 0.0);
    let asleep =
        asleep.map_or_else(String::new, |share| format!("; asleep {} of the time", percent(share / 100.0)));
    format!(
        "{count} rounds of {least_cycles} cycles at least, {} on average, {most_cycles} at most ({least}, {mean}, {most}){asleep}",
        handy(mean_cycles)
    )
}

/// The turns, steps and frames that were left out as there were too many.
fn overload(robot: &Robot) -> impl Iterator<Item = (&'static str, String)> {
    let Robot { lost_deliveries, lost_steps, frames_missed, .. } = robot;
    let turns = format!("{lost_deliveries} turns were not delivered, as the brain did not read");
    let steps = format!("{lost_steps} steps were discarded, as there were too many in a tick");
    let frames = format!("{frames_missed} frames skipped by the microcontroller");
    let all = [
        (*lost_deliveries, ("slow brain", turns)),
        (*lost_steps, ("fast brain", steps)),
        (*frames_missed, ("busy", frames)),
    ];
    all.into_iter().filter(|(count, _)| *count > 0).map(|(_, fact)| fact)
}

fn cycles(cycles: &Cycles) -> String {
    let unanswered = match cycles.unanswered {
        0 => String::new(),
        n => format!("; {n} unanswered"),
    };
    let Some(percent_kept) = cycles.kept_percent else {
        return format!("none was answered by a command{unanswered}");
    };
    let deadline = duration(cycles.deadline_ms * 1e6);
    let all = cycles.kept + cycles.late;
    let kept = percent(percent_kept / 100.0);
    let mut text = format!("{} of {all} ({kept}) within {deadline}{unanswered}", cycles.kept);
    if let Some(Durations { p50_ms, p95_ms, max_ms, .. }) = cycles.duration {
        let [median, most] = [p50_ms, p95_ms].map(|ms| duration(about(ms) * 1e6));
        text += &format!("; median {median}, 95th percentile {most}, longest {}", duration(max_ms * 1e6));
    }
    if cycles.unstated_writes > 0 {
        let [writes, disturbed] =
            [cycles.unstated_writes, cycles.disturbed].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        text += &format!(
            "; {} outside the pattern `{}`, which disturbed {} that a budget for this pattern does not cover",
            count(writes, "write"),
            cycles.writes,
            count(disturbed, "cycle")
        );
    }
    text + &format!("; {} exchanges a second", handy(about(cycles.exchanges_per_s)))
}

/// The answering time of a brain.
fn thinking(Thinking { turns, durations }: &Thinking, clock: &str) -> String {
    let Durations { min_ms, p50_ms, p95_ms, p99_ms, max_ms, .. } = *durations;
    let [median, p95, p99] = [p50_ms, p95_ms, p99_ms].map(|ms| duration(about(ms) * 1e6));
    let [least, most] = [min_ms, max_ms].map(|ms| duration(about(ms) * 1e6));
    let turns = count(usize::try_from(*turns).unwrap_or(usize::MAX), "turn");
    format!("{turns} took {least} to {most} by {clock}; median {median}, 95th percentile {p95}, 99th {p99}")
}

/// The number with three digits: quantiles are right to no more than 0.8 %.
fn about(number: f64) -> f64 {
    if number == 0.0 || !number.is_finite() {
        return number;
    }
    let unit = 10_f64.powi(number.abs().log10().floor() as i32 - 2);
    // A negative power is not exact, so it is divided by the positive one.
    if unit < 1.0 { (number / unit).round() / (1.0 / unit).round() } else { (number / unit).round() * unit }
}

/// Bytes that were lost on the robot's cables, and why; `None` if there were none.
fn losses(robot: &Robot) -> Option<String> {
    let ports =
        robot.sensors.iter().filter_map(|sensor| Some((sensor.sensor.as_str(), sensor.port.as_ref()?)));
    let lines = [("up", &robot.uplink), ("down", &robot.downlink)].into_iter().chain(ports);
    let reasons = lines.filter_map(|(name, line)| {
        let reasons = [
            (line.overrun_bytes, "overran a full receiver"),
            (line.refused_bytes, "were refused by a full driver"),
            (line.lost_bytes, "arrived while the cable was out or the microcontroller was starting"),
            (line.corrupted_bytes, "arrived with a wrong bit"),
        ];
        let reasons: Vec<_> =
            reasons.iter().filter(|(n, _)| *n > 0).map(|(n, why)| format!("{n} {why}")).collect();
        (!reasons.is_empty()).then(|| format!("{name}: {}", reasons.join(", ")))
    });
    let reasons: Vec<_> = reasons.collect();
    (!reasons.is_empty()).then(|| reasons.join("; "))
}

fn battery(battery: &Battery) -> String {
    let Battery { charge_percent, voltage_v, used_j, charged_j } = *battery;
    let left = format!("{} left, {} V", percent(charge_percent / 100.0), handy(voltage_v));
    let charged = if charged_j > 0.0 { format!(", {} J put in", handy(charged_j)) } else { String::new() };
    format!("{left}, {} J used{charged}", handy(used_j))
}

fn link(robot: &Robot) -> String {
    if robot.onboard {
        return "none: the brain is the microcontroller's program".to_owned();
    }
    match (robot.baud, robot.bits_per_character) {
        (Some(baud), Some(bits)) => format!("{baud} baud, {bits} bits a character"),
        _ => robot.link.to_owned(),
    }
}

fn lines(robot: &Robot) -> Vec<[String; 8]> {
    let row = |name: &str, line: &Line| {
        let counts = [line.bytes, line.messages];
        let losses = [
            line.overrun_bytes + line.refused_bytes + line.lost_bytes,
            line.corrupted_bytes,
            line.bad_frames,
            line.bad_messages,
        ];
        let [bytes, messages] = counts.map(|n| n.to_string());
        let [lost, corrupted, frames, content] = losses.map(|n| n.to_string());
        let used = line.used_percent.map_or_else(|| NOTHING.to_owned(), |used| percent(used / 100.0));
        [name.to_owned(), bytes, messages, used, lost, corrupted, frames, content]
    };
    let head = ["", "bytes", "messages", "used", "lost", "corrupted", "bad frames", "bad messages"];
    let mut rows = vec![head.map(str::to_owned), row("up", &robot.uplink), row("down", &robot.downlink)];
    let ports = robot.sensors.iter().filter_map(|sensor| Some((&sensor.sensor, sensor.port.as_ref()?)));
    rows.extend(ports.map(|(sensor, line)| row(sensor, line)));
    rows
}

/// The cable of a program whose bytes have no meaning here.
fn program_lines(robot: &Robot) -> Vec<[String; 5]> {
    let head = ["", "bytes", "used", "lost", "corrupted"].map(str::to_owned);
    let row = |[name, bytes, _, used, lost, corrupted, ..]: [String; 8]| [name, bytes, used, lost, corrupted];
    core::iter::once(head).chain(lines(robot).into_iter().skip(1).map(row)).collect()
}

fn program_sensors(robot: &Robot) -> Vec<[String; 2]> {
    let head = ["", "samples"].map(str::to_owned);
    let rows = robot.sensors.iter().map(|sensor| [sensor.sensor.clone(), sensor.samples.to_string()]);
    core::iter::once(head).chain(rows).collect()
}

fn sensors(robot: &Robot) -> Vec<[String; 9]> {
    let age = |age: Option<f64>| age.map_or_else(|| NOTHING.to_owned(), |ms| format!("{ms:.3} ms"));
    let about =
        |age: Option<f64>| age.map_or_else(|| NOTHING.to_owned(), |ms| format!("{} ms", handy(about(ms))));
    let row = |sensor: &Sensor| {
        let share = percent(sensor.readable as f64 / robot.turns as f64);
        let counts = [sensor.samples, sensor.missed, sensor.readable];
        let [samples, missed, readable] = counts.map(|n| n.to_string());
        let ages = |of: fn(&Durations) -> f64| sensor.age.as_ref().map(of);
        let [mean, max] = [ages(|age| age.mean_ms), ages(|age| age.max_ms)].map(age);
        let [median, most] = [ages(|age| age.p50_ms), ages(|age| age.p95_ms)].map(about);
        [sensor.sensor.clone(), samples, missed, readable, share, mean, median, most, max]
    };
    let head =
        ["", "samples", "missed", "readable", "of turns", "mean age", "median age", "p95 age", "max age"];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(robot.sensors.iter().map(row));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_told_with_three_digits() {
        let found = [0.0, 0.012_345, 28.8051, 399.01, 12_345.0, 0.999_9].map(about);
        assert_eq!(found, [0.0, 0.0123, 28.8, 399.0, 12_300.0, 1.0]);
    }

    #[test]
    fn more_commands_than_messages_are_too_many() {
        assert_eq!(times_too_often(1179, 590, 19.0).as_deref(), Some("2.0"));
        let enough =
            [(590, 590), (700, 590), (300, 590), (200, 3)].map(|(n, of)| times_too_often(n, of, 20.0));
        assert_eq!(enough, [const { None }; 4]);
    }
}
