//! The summary of a run as people read it: the run here, its robots in `robot`.

mod robot;

use baudbot_plot::quantity::{NOTHING, count, duration, handy};

use crate::args::Over;
use crate::natural;
use crate::summary::{Blocked, Clock, Lateness, Program, Recording, Required, Robot, Score, Summary};
use crate::text::{pairs, percent, table};

/// The whole summary.
pub(crate) fn text(summary: &Summary) -> String {
    let mut text = pairs("", &head(summary));
    if let Some(clock) = &summary.clock {
        text += "lateness of ticks\n";
        text += &histogram(clock);
    }
    for robot in natural::sorted(&summary.robots, |robot| &robot.robot) {
        text.push('\n');
        text += &robot::text(robot, summary.simulated_s);
    }
    text
}

/// The summary in a line.
pub(crate) fn line(summary: &Summary) -> String {
    let Summary { world, ticks, simulated_s, wall_s, ending, state_hash, .. } = summary;
    let sum = |of: fn(&Robot) -> u64| summary.robots.iter().map(of).sum::<u64>();
    let late =
        summary.clock.as_ref().map_or(String::new(), |clock| format!(", {} late ticks", clock.overruns));
    format!(
        "world {world}: {ticks} ticks, {} s simulated in {wall_s:.3} s{late}, {} commands, {} collisions, ended because {ending}, hash \
         {state_hash}\n",
        handy(*simulated_s),
        sum(|robot| robot.commands),
        sum(|robot| robot.collisions),
    )
}

fn head(summary: &Summary) -> Vec<(&'static str, String)> {
    let name = if summary.scenario.is_empty() { &summary.world } else { &summary.scenario };
    let time = format!(
        "{} s simulated in {:.3} s by the wall clock, {} times real time",
        handy(summary.simulated_s),
        summary.wall_s,
        if summary.simulated_per_wall.is_finite() {
            handy(summary.simulated_per_wall)
        } else {
            NOTHING.to_owned()
        }
    );
    let path = match (summary.over, has_brains(summary)) {
        (Over::Direct, true) => "direct: the world and its brains on one thread",
        (Over::Direct, false) => "direct: the world on one thread",
        (Over::Grpc, true) => "over gRPC: the world on a server, the brains attached to it",
        (Over::Grpc, false) => "over gRPC: the world on a server",
    };
    let mut head = vec![
        ("scenario", format!("{name}, seed {}", summary.seed)),
        ("pace", summary.pace.clone()),
        ("path", path.to_owned()),
        ("ticks", format!("{} of {}", summary.ticks, duration(summary.step_ns as f64))),
        ("time", time),
        ("ended", format!("because {}", summary.ending)),
        ("state hash", summary.state_hash.clone()),
    ];
    head.extend(pacing(summary));
    head.extend(summary.score.iter().flat_map(score));
    head.extend(summary.recording.iter().flat_map(recording));
    head.extend(summary.programs.iter().map(|program| ("program", of_program(program))));
    head.extend(summary.requirements.iter().map(required));
    head.extend(hints(summary));
    head.extend(summary.blocked.iter().map(blocked));
    head
}

/// What a user may want to know about programs.
fn hints(summary: &Summary) -> Vec<(&'static str, String)> {
    let mut hints = Vec::new();
    if summary.programs.iter().any(|program| program.random_addresses) {
        hints.push(("warning", RANDOM_ADDRESSES.to_owned()));
    }
    if summary.unseen_lines > 0 {
        let lines = count(usize::try_from(summary.unseen_lines).unwrap_or(usize::MAX), "line");
        hints.push(("hint", format!("the brain's program printed {lines}: --show-output shows them")));
    }
    hints
}

fn required(Required { requirement, robot, holds, robustness, at_s }: &Required) -> (&'static str, String) {
    let verdict = if *holds { "holds" } else { "FAILS" };
    ("required", format!("{requirement}: {verdict} for {robot} by {:.4} at {at_s:.3} s", robustness.abs()))
}

fn blocked(Blocked { mover, blocked_s }: &Blocked) -> (&'static str, String) {
    ("warning", format!("`{mover}` was blocked for {} s by something in its way", handy(*blocked_s)))
}

const RANDOM_ADDRESSES: &str = "this system does not allow a program the same addresses in each run, as in a container; what follows \
    from addresses, such as the order of a set of objects in Python, may differ from run to run";

/// What a program in simulated time has come to, and what computing cost it.
fn of_program(program: &Program) -> String {
    let Program { robot, ended_s, price_ns, charged_calls, charged_s, waits, .. } = program;
    let end = match ended_s {
        Some(at_s) => format!("ended at {} s", handy(*at_s)),
        None => waits.first().map_or_else(|| "was running".to_owned(), |wait| format!("was running: {wait}")),
    };
    let calls = count(usize::try_from(*charged_calls).unwrap_or(usize::MAX), "call");
    let cost = match price_ns {
        Some(price) => {
            format!(
                "{calls} that did not wait took {} s, {} each",
                handy(*charged_s),
                duration(*price as f64)
            )
        }
        None if *charged_calls > 0 => format!(
            "computing took no time, but {calls} that were made over and over without waiting took {} s",
            handy(*charged_s)
        ),
        None => "computing took no time".to_owned(),
    };
    format!("in simulated time, at the ports of `{robot}`; it {end}; {cost}")
}

/// Whether robots may have brains, and not only programs.
fn has_brains(summary: &Summary) -> bool {
    summary.robots.is_empty() || !summary.robots.iter().all(Robot::has_program_only)
}

/// The quality of the pace.
fn pacing(summary: &Summary) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    if let Some(lockstep) = summary.lockstep.as_ref().filter(|_| has_brains(summary)) {
        let share = percent(lockstep.waiting_s / summary.wall_s);
        let timeouts = usize::try_from(lockstep.watchdog_timeouts).unwrap_or(usize::MAX);
        let timeouts = count(timeouts, "timeout");
        let text = format!("{:.3} s for brains, {share} of the wall time; {timeouts}", lockstep.waiting_s);
        facts.push(("waited", text));
    }
    if let Some(clock) = &summary.clock {
        let late = duration(clock.lateness_max_ms * 1e6);
        let text =
            format!("{} overruns, at most {late} late, drift {:+.4} %", clock.overruns, clock.drift_percent);
        facts.push(("clock", text));
        if clock.times_let_go > 0 {
            let times = usize::try_from(clock.times_let_go).unwrap_or(usize::MAX);
            let lags = count(times, "lag");
            facts.push((
                "dropped",
                format!("{} s of wall time, in {lags} too long to catch up", handy(clock.let_go_s)),
            ));
        }
    }
    facts
}

fn recording(recording: &Recording) -> Vec<(&'static str, String)> {
    let Recording { file, bytes, ticks, problem } = recording;
    let mut facts = vec![("recorded", format!("{ticks} ticks in {file}, {bytes} bytes"))];
    let rest = if *bytes > 0 { "; the recorded part can be replayed" } else { "" };
    let ended = |problem: &String| format!("the recording ended before the run: {problem}{rest}");
    facts.extend(problem.as_ref().map(|problem| ("warning", ended(problem))));
    facts
}

fn score(score: &Score) -> Vec<(&'static str, String)> {
    let share = |share: f64| format!("{} of the free floor", percent(share / 100.0));
    let mut facts = Vec::new();
    facts.extend(score.covered_percent.map(|covered| ("covered", share(covered))));
    facts.extend(score.sensed_percent.map(|sensed| ("sensed", share(sensed))));
    if score.goals > 0 {
        facts.push(("goals", format!("{} of {} reached", score.goals_reached, score.goals)));
    }
    if !score.visited.is_empty() {
        facts.push(("visited", score.visited.join(", ")));
    }
    facts
}

/// A bar for each power of two of microseconds, from the first that occurred to the last.
fn histogram(clock: &Clock) -> String {
    let used = |entry: &Lateness| entry.ticks > 0;
    let first = clock.lateness.iter().position(used).unwrap_or(0);
    let last = clock.lateness.iter().rposition(used).map_or(0, |last| last + 1);
    let shown = &clock.lateness[first.min(last)..last];
    let most = shown.iter().map(|entry| entry.ticks).max().unwrap_or(1);
    let row = |entry: &Lateness| {
        let length = (entry.ticks * BAR).div_ceil(most) as usize;
        [
            format!("< {}", duration(entry.below_us as f64 * 1e3)),
            entry.ticks.to_string(),
            format!("{:<40}", "█".repeat(length)),
        ]
    };
    table("  ", &shown.iter().map(row).collect::<Vec<_>>())
}

/// Characters of the longest bar.
const BAR: u64 = 40;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_in_proportion_and_none_that_is_used_is_empty() {
        let entry = |below_us, ticks| Lateness { below_us, ticks };
        let lateness = vec![entry(1, 0), entry(2, 4000), entry(4, 0), entry(8, 1), entry(16, 0)];
        let clock = Clock {
            overruns: 0,
            lateness_max_ms: 0.007,
            let_go_s: 0.0,
            times_let_go: 0,
            drift_percent: 0.0,
            lateness,
        };
        let expected = format!("  < 2 µs  4000  {}\n  < 4 µs     0\n  < 8 µs     1  █\n", "█".repeat(40));
        assert_eq!(histogram(&clock), expected);
    }

    #[test]
    fn no_ticks_no_bars() {
        let clock = Clock {
            overruns: 0,
            lateness_max_ms: 0.0,
            let_go_s: 0.0,
            times_let_go: 0,
            drift_percent: f64::NAN,
            lateness: vec![],
        };
        assert_eq!(histogram(&clock), "");
    }
}
