//! A program's budget as text.

use std::fmt::Write;

use baudbot_plot::quantity::{NOTHING, count, duration, handy};
use baudbot_scenario::budget::{Span, Verdict};

use super::ProgramBudget;
use crate::text::{percent, table};

/// The complete report on a robot.
pub(in crate::budget) fn told(budget: &ProgramBudget) -> String {
    let mut text = format!("robot {}: {}\n", budget.robot, verdict(budget));
    let (mhz, watched) = (f64::from(budget.clock_hz) / 1e6, duration(budget.watched_ns as f64));
    let _ = writeln!(
        text,
        "  measured: {watched} of its program on an {} at {mhz} MHz; another run may take longer",
        budget.part
    );
    if budget.starts_after_ns > 0 {
        let starts = duration(budget.starts_after_ns as f64);
        let _ = writeln!(text, "  nothing happens before {starts}, when the bootloader starts the program");
    }
    text + &cycle(budget) + &rates(budget) + &ages(budget) + &loads(budget) + &notes(budget)
}

fn verdict(budget: &ProgramBudget) -> String {
    let deadline = format!("deadline of {}", duration(budget.deadline_ns as f64));
    let (what, cycle) = longest(budget);
    let ns = |ns: Option<u64>| ns.map_or_else(|| NOTHING.to_owned(), |ns| duration(ns as f64));
    let times = format!("{what} takes {} typically, {} at most", ns(cycle.typical_ns), ns(cycle.worst_ns));
    match budget.verdict {
        Verdict::Keeps => format!("meets its {deadline}: {times}"),
        Verdict::Sometimes => format!("mostly meets its {deadline}: {times}"),
        Verdict::Misses if budget.round.is_none() => {
            format!("MISSES its {deadline}: the main loop of its program completed no round")
        }
        Verdict::Misses if cycle.typical_ns > Some(budget.deadline_ns) => {
            format!("MISSES its {deadline}: {times}")
        }
        Verdict::Misses => {
            let lost = count(usize::try_from(budget.lost_bytes).unwrap_or(usize::MAX), "byte");
            format!("MISSES its {deadline}: the cable has lost {lost}")
        }
    }
}

/// The one of a cycle's two spans on which the verdict depends.
fn longest(budget: &ProgramBudget) -> (&'static str, Span) {
    let way = budget.readings_to_motors.map(|span| ("the path from the readings to the motors", span));
    let all = way.into_iter().chain(budget.round.map(|span| ("a round of its main loop", span)));
    let misses = budget.verdict == Verdict::Misses;
    all.max_by_key(|(_, span)| if misses { span.typical_ns } else { span.worst_ns }).unwrap_or_default()
}

fn ms(ns: Option<u64>) -> String {
    ns.map_or_else(|| NOTHING.to_owned(), |ns| format!("{:.4}", ns as f64 / 1e6))
}

fn cells(name: &str, span: Span) -> [String; 4] {
    [format!("  {name}"), ms(Some(span.best_ns)), ms(span.typical_ns), ms(span.worst_ns)]
}

fn cycle(budget: &ProgramBudget) -> String {
    let mut rows = vec![["one cycle, in ms", "best", "typical", "worst"].map(str::to_owned)];
    rows.extend(budget.round.map(|span| cells("round of the main loop", span)));
    rows.extend(budget.readings_to_motors.map(|span| cells("from the readings to the motors", span)));
    if let Some(rounds) = budget.round_cycles {
        let [best, typical, worst] = [rounds.best, rounds.typical, rounds.worst].map(|n| n.to_string());
        rows.push(["the round in cycles of the clock".to_owned(), best, typical, worst]);
    }
    table("  ", &rows)
}

fn rates(budget: &ProgramBudget) -> String {
    let mut rows = vec![["rate, per second".to_owned(), "typical".to_owned()]];
    rows.extend(budget.rates.iter().map(|rate| [format!("  {}", rate.what), format!("{:.1}", rate.per_s)]));
    table("  ", &rows)
}

fn ages(budget: &ProgramBudget) -> String {
    if budget.ages.is_empty() {
        return String::new();
    }
    let mut rows = vec![
        ["age of readings when the motors change, in ms", "best", "typical", "worst"].map(str::to_owned),
    ];
    rows.extend(budget.ages.iter().map(|age| cells(&age.sensor, age.span)));
    table("  ", &rows)
}

fn loads(budget: &ProgramBudget) -> String {
    let mut rows = vec![["in use".to_owned(), String::new(), String::new()]];
    for load in &budget.loads {
        let bytes = load.bytes_per_s.zip(load.most_bytes_per_s);
        let bytes = bytes.map_or_else(String::new, |(bytes, most)| {
            format!("{} of {} bytes a second", handy(bytes), handy(most))
        });
        rows.push([format!("  {}", load.what), percent(load.share), bytes]);
    }
    table("  ", &rows) + &format!("  stack: {} bytes at most\n", budget.stack_bytes)
}

fn notes(budget: &ProgramBudget) -> String {
    let mut text = String::new();
    let is_full = |what| budget.loads.iter().any(|load| load.what == what && load.share > FULL);
    if is_full("uplink") {
        text +=
            "  the cable limits the program, which fills it and waits: send less, or at a higher baud rate\n";
    }
    if budget.lost_bytes > 0 {
        let lost = budget.lost_bytes;
        let _ = writeln!(
            text,
            "  {lost} bytes were lost or damaged: the laptop or the program cannot process so many"
        );
    }
    if budget.readings_to_motors.is_none() {
        text += "  the program never changed the motors after a reading, so the time from readings to motors is unknown\n";
    }
    text
}

/// A cable that is busier than this is full.
const FULL: f64 = 0.98;
