//! A robot's budget as text.

use std::fmt::Write;

use baudbot_plot::quantity::{NOTHING, count, duration, handy};
use baudbot_scenario::budget::{Cost, Remedy, RobotBudget, Span, Verdict};

use crate::text::{percent, table};

/// The complete report on a robot; `thinking` is a line about its brain.
pub(super) fn robot(robot: &RobotBudget, thinking: &str) -> String {
    let mut text = format!("robot {}: {}\n{thinking}", robot.robot, verdict(robot));
    if robot.starts_after_ns > 0 {
        let starts = duration(robot.starts_after_ns as f64);
        let _ = writeln!(text, "  nothing happens before {starts}, when the bootloader starts the firmware");
    }
    text += &cycle(robot);
    text += &rates(robot);
    text += &ages(robot);
    text += &loads(robot);
    text += &chip(robot);
    text += &remedies(robot);
    text
}

/// The verdict in words.
fn verdict(robot: &RobotBudget) -> String {
    let deadline = format!("deadline of {}", duration(robot.deadline_ns as f64));
    let total = robot.cycle.total;
    let times = format!("{} typical, {}", span_ms(total.typical_ns), worst(total));
    match (robot.verdict, total.typical_ns) {
        (Verdict::Keeps, _) => format!("meets its {deadline}: {times}"),
        (Verdict::Sometimes, _) => format!("mostly meets its {deadline}: {times}"),
        (Verdict::Misses, None) => format!("MISSES its {deadline}: no cycle is ever completed"),
        (Verdict::Misses, Some(typical)) if typical > robot.deadline_ns => {
            let (needs, blame) = (duration(typical as f64), &robot.bottleneck);
            format!("MISSES its {deadline}: needs {needs}; the bottleneck is {blame}")
        }
        (Verdict::Misses, Some(_)) => {
            format!("MISSES its {deadline}: {times}, but {} is overloaded", robot.bottleneck)
        }
    }
}

fn worst(span: Span) -> String {
    span.worst_ns.map_or_else(|| "worst unbounded".to_owned(), |ns| format!("{} worst", duration(ns as f64)))
}

fn span_ms(ns: Option<u64>) -> String {
    ns.map_or_else(|| NOTHING.to_owned(), |ns| duration(ns as f64))
}

/// Milliseconds with three decimals, so that columns line up.
fn ms(ns: Option<u64>) -> String {
    ns.map_or_else(|| NOTHING.to_owned(), |ns| format!("{:.3}", ns as f64 / 1e6))
}

fn cells(name: &str, span: Span) -> [String; 4] {
    [name.to_owned(), ms(Some(span.best_ns)), ms(span.typical_ns), ms(span.worst_ns)]
}

fn cycle(robot: &RobotBudget) -> String {
    let head = ["one cycle, in ms", "best", "typical", "worst", ""];
    let mut rows = vec![head.map(str::to_owned)];
    let whole = robot.cycle.total.typical_ns.unwrap_or(0);
    let used = |span: Span| span.worst_ns != Some(0);
    for row in robot.cycle.rows.iter().filter(|row| used(row.span)) {
        let [name, best, typical, worst] = cells(row.part.phrase(), row.span);
        rows.push([format!("  {name}"), best, typical, worst, bar(row.span.typical_ns.unwrap_or(0), whole)]);
    }
    let [name, best, typical, worst] = cells("whole cycle", robot.cycle.total);
    rows.push([name, best, typical, worst, String::new()]);
    let mut text = with_bars(&rows);
    if let Some(why) = &robot.cycle.unbounded {
        let _ = writeln!(text, "    no worst case: {why}");
    }
    if robot.dead_time_ns > 0 {
        let dead = duration(robot.dead_time_ns as f64);
        let _ = writeln!(text, "    the motors have a dead time of {dead}, which comes after the cycle");
    }
    text
}

/// The rows of a table with a bar behind each, which stands at the left.
fn with_bars(rows: &[[String; 5]]) -> String {
    let numbers: Vec<_> =
        rows.iter().map(|[a, b, c, d, _]| [a.clone(), b.clone(), c.clone(), d.clone()]).collect();
    let text = table("  ", &numbers);
    let lines =
        text.lines().zip(rows).map(|(line, [.., bar])| format!("{line}  {bar}").trim_end().to_owned() + "\n");
    lines.collect()
}

/// A part of a whole as a bar of up to 20 characters.
fn bar(part: u64, whole: u64) -> String {
    let eighths = (part as f64 / whole.max(1) as f64 * 160.0).round() as usize;
    let rest = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"][eighths % 8];
    "█".repeat(eighths / 8) + rest
}

fn rates(robot: &RobotBudget) -> String {
    let head = ["rate, per second", "at most", "typical", ""];
    let mut rows = vec![head.map(str::to_owned)];
    let number = |per_s: Option<f64>| per_s.map_or_else(|| NOTHING.to_owned(), |n| format!("{n:.1}"));
    for rate in &robot.rates {
        let limits = if rate.limits { "limits the exchanges" } else { "" };
        let typical = if rate.typical_per_s.is_some() { number(rate.typical_per_s) } else { String::new() };
        rows.push([format!("  {}", rate.what), number(rate.most_per_s), typical, limits.to_owned()]);
    }
    table("  ", &rows)
}

fn ages(robot: &RobotBudget) -> String {
    if robot.ages.is_empty() {
        return String::new();
    }
    let mut rows = vec![["age of readings, in ms", "best", "typical", "worst"].map(str::to_owned)];
    rows.extend(robot.ages.iter().map(|age| cells(&format!("  {}", age.sensor), age.span)));
    let mut text = table("  ", &rows);
    let mut reasons: Vec<_> = robot.ages.iter().filter_map(|age| age.unbounded.as_ref()).collect();
    reasons.dedup();
    for why in reasons {
        let _ = writeln!(text, "    no worst case: {why}");
    }
    text
}

fn loads(robot: &RobotBudget) -> String {
    let mut rows = vec![["in use".to_owned(), String::new()]];
    rows.extend(robot.loads.iter().map(|load| [format!("  {}", load.what), percent(load.share)]));
    table("  ", &rows)
}

fn chip(robot: &RobotBudget) -> String {
    let chip = &robot.chip;
    let mut text = String::new();
    if let Some(ram) = chip.ram_bytes {
        let bytes = |n: u64| count(usize::try_from(n).unwrap_or(usize::MAX), "byte");
        let needs =
            chip.brain_memory_bytes.map_or_else(String::new, |n| format!(", of which the brain needs {n}"));
        let _ = writeln!(text, "  memory for variables: {}{needs}", bytes(ram));
    }
    if let Some(most) = chip.operations_per_step {
        let takes =
            chip.brain_operations.map_or_else(String::new, |n| format!("; the brain does {}", handy(n)));
        let _ = writeln!(text, "  operations in a step: {}{takes}", handy(most));
    }
    text
}

fn remedies(robot: &RobotBudget) -> String {
    let mut text = String::new();
    if let Some(left_out) = &robot.left_out {
        let _ = writeln!(text, "  {left_out}");
    }
    if robot.remedies.is_empty() {
        let change = if robot.left_out.is_some() { "change that was tried" } else { "known change" };
        if robot.verdict == Verdict::Misses {
            let _ = writeln!(text, "  no {change} fixes this");
        }
        return text;
    }
    text += "  possible fixes, the cheapest first\n";
    for remedy in &robot.remedies {
        let _ = writeln!(text, "    {} ({}): {}", remedy.what, cost(remedy.cost), outcome(remedy));
        for change in &remedy.overrides {
            let quoted =
                if change.contains([' ', '{', '"']) { format!("'{change}'") } else { change.clone() };
            let _ = writeln!(text, "      --set {quoted}");
        }
    }
    text
}

fn outcome(remedy: &Remedy) -> String {
    let meets = match remedy.verdict {
        Verdict::Keeps => "meets",
        Verdict::Sometimes => "mostly meets",
        Verdict::Misses => "misses",
    };
    let step = duration(remedy.step_ns as f64);
    format!("{} typical, {}; {meets} {step}", span_ms(remedy.total.typical_ns), worst(remedy.total))
}

fn cost(cost: Cost) -> &'static str {
    match cost {
        Cost::Setting => "a setting of the laptop",
        Cost::BothEnds => "a setting at both ends",
        Cost::Firmware => "another firmware",
        Cost::LongerStep => "a slower brain",
        Cost::Cable => "another cable",
        Cost::Processor => "another processor",
        Cost::Layout => "another layout",
        Cost::Loss => "a loss of data",
    }
}
