//! All metrics, those of robots and cables by the tables of [`measures`](crate::measures). `docs/reference/metrics.md` lists them.

use super::World;
use super::text::Family;
use crate::limits::InForce;
use crate::measures::{Measures, Metric, OF_LINES, OF_ROBOTS, QUANTILES, RobotMeasures};
use crate::report::Activity;

/// A number of a world.
type OfWorld = fn(&Measures) -> f64;

/// The metrics of a world.
const WORLDS: [Metric<OfWorld>; 14] = [
    ("baudbot_world_ticks_total", "Ticks done since the run began.", |w| w.tick as f64),
    ("baudbot_world_simulated_seconds_total", "Simulated time since the run began.", |w| w.time.as_seconds()),
    ("baudbot_world_running_seconds_total", "Wall-clock time during which the world was running.", |w| {
        w.running.as_secs_f64()
    }),
    ("baudbot_world_step_seconds", "Simulated time of a tick.", |w| seconds(w.scenario.step_ns)),
    (
        "baudbot_world_tick_overruns_total",
        "Ticks that ended late by a whole tick or more of the wall clock.",
        |w| w.pacing.overruns as f64,
    ),
    (
        "baudbot_world_watchdog_timeouts_total",
        "Number of times that the watchdog found a brain that had not answered.",
        |w| w.pacing.watchdog_timeouts as f64,
    ),
    (
        "baudbot_world_brain_wait_seconds_total",
        "Wall-clock time during which the world waited for brains.",
        |w| w.pacing.waiting.as_secs_f64(),
    ),
    (
        "baudbot_world_let_go_seconds_total",
        "Wall-clock time that the world skipped because it lagged by more than its pace allows.",
        |w| w.pacing.let_go.as_secs_f64(),
    ),
    ("baudbot_world_let_go_total", "Number of times that the world skipped a lag.", |w| {
        w.pacing.times_let_go as f64
    }),
    ("baudbot_world_robots", "Robots of the world.", |w| w.scenario.robots.len() as f64),
    ("baudbot_world_observers", "Observers that are connected.", |w| w.observers as f64),
    (
        "baudbot_world_observer_frames_missed_total",
        "Frames that observers missed because they did not read.",
        |w| w.frames_missed as f64,
    ),
    (
        "baudbot_world_state_lost",
        "1 if the state of the world cannot be written at the moment, 0 if it can, or if none is stored.",
        |w| f64::from(u8::from(w.keeping.as_ref().is_some_and(|keeping| keeping.is_lost))),
    ),
    (
        "baudbot_world_state_kept_ticks",
        "The tick from which the world would continue if the server were killed; 0 if no state is stored.",
        |w| w.keeping.as_ref().map_or(0.0, |keeping| keeping.tick as f64),
    ),
];

const STATES: [(Activity, &str); 4] = [
    (Activity::WaitingForBrains, "waiting_for_brains"),
    (Activity::Running, "running"),
    (Activity::Paused, "paused"),
    (Activity::Ended, "ended"),
];

const DIRECTIONS: [&str; 2] = ["up", "down"];

/// Writes all metrics of these worlds, of at most so many robots.
pub(super) fn write(worlds: &[World], limits: &InForce, most_robots: usize) -> String {
    let mut text = String::new();
    let mut count = Family::gauge("baudbot_worlds", "Worlds of the server.");
    count.add(&[], worlds.len() as f64);
    count.write(&mut text);
    write_limits(limits, &mut text);
    let mut up = Family::gauge("baudbot_world_up", "1 if the world has answered in time, 0 if not.");
    for world in worlds {
        up.add(&[("world", &world.name)], f64::from(u8::from(world.measures.is_some())));
    }
    up.write(&mut text);
    let mut statuses = Family::counter(
        "baudbot_world_statuses_made_total",
        "Statuses made for operators; each answers all requests until the world changes.",
    );
    for world in worlds {
        statuses.add(&[("world", &world.name)], world.statuses as f64);
    }
    statuses.write(&mut text);
    let answered: Vec<_> =
        worlds.iter().filter_map(|world| Some((&*world.name, world.measures.as_ref()?))).collect();
    write_worlds(&answered, &mut text);
    write_robots(&answered, most_robots, &mut text);
    text
}

/// The server's limits: what each is, what is used of it, and how often something was refused for it.
fn write_limits(limits: &InForce, text: &mut String) {
    let mut values = Family::gauge("baudbot_limit", "A limit of the server.");
    let mut used = Family::gauge(
        "baudbot_limit_used",
        "Usage of a limit; of a limit for each caller, the usage of the caller that uses most.",
    );
    let mut refused =
        Family::counter("baudbot_limit_refused_total", "Number of refusals because of a limit.");
    for limit in limits.usage() {
        let labels = [("limit", limit.info.name)];
        values.add(&labels, limit.value.unwrap_or(u64::MAX) as f64);
        if let Some(in_use) = limit.used {
            used.add(&labels, in_use as f64);
        }
        refused.add(&labels, limit.refused as f64);
    }
    values.write(text);
    used.write(text);
    refused.write(text);
}

fn family((name, help): (&'static str, &'static str)) -> Family {
    if name.ends_with("_total") { Family::counter(name, help) } else { Family::gauge(name, help) }
}

fn write_worlds(worlds: &[(&str, &Measures)], text: &mut String) {
    for (name, help, value) in WORLDS {
        let mut family = family((name, help));
        for (world, measures) in worlds {
            family.add(&[("world", world)], value(measures));
        }
        family.write(text);
    }
    let mut states =
        Family::gauge("baudbot_world_state", "1 for the state that the world is in, 0 for others.");
    let mut lateness = Family::histogram(
        "baudbot_world_tick_lateness_seconds",
        "Lateness of the ends of ticks by the wall clock, in real-time and scaled pace.",
    );
    for (world, measures) in worlds {
        for (activity, state) in STATES {
            let is = f64::from(u8::from(measures.activity == activity));
            states.add(&[("world", world), ("state", state)], is);
        }
        let pacing = &measures.pacing;
        let buckets = pacing.lateness_us_log2[..LATENESS_BUCKETS].iter().zip(0..);
        let buckets = buckets.map(|(&n, log2)| (seconds(1000 << log2), n));
        let count = pacing.lateness_us_log2.iter().sum();
        lateness.add_histogram(&[("world", world)], buckets, count, pacing.lateness_sum.as_secs_f64());
    }
    states.write(text);
    lateness.write(text);
}

/// Buckets up to 2^24 µs, 17 s; what is later than that is in the last.
const LATENESS_BUCKETS: usize = 25;

/// A robot of a world.
struct Shown<'a> {
    world: &'a str,
    robot: &'a str,
    measures: &'a RobotMeasures,
    deadline_ns: u64,
}

fn write_robots(worlds: &[(&str, &Measures)], most_robots: usize, text: &mut String) {
    let mut shown = Vec::new();
    let mut left_out =
        Family::gauge("baudbot_world_robots_left_out", "Robots that are left out, since there are too many.");
    for (world, measures) in worlds {
        let specs = &measures.scenario.robots;
        let room = (most_robots - shown.len()).min(measures.robots.len());
        shown.extend(specs.iter().zip(&measures.robots).take(room).map(|(spec, measures)| Shown {
            world,
            robot: &spec.name,
            measures,
            deadline_ns: spec.deadline.within_ns,
        }));
        left_out.add(&[("world", world)], (specs.len() - room) as f64);
    }
    left_out.write(text);
    for (i, (name, help, _)) in OF_ROBOTS.into_iter().enumerate() {
        let mut family = family((name, help));
        for Shown { world, robot, measures, .. } in &shown {
            family.add(&[("world", world), ("robot", robot)], measures.values[i]);
        }
        family.write(text);
    }
    for (i, (name, help, _)) in OF_LINES.into_iter().enumerate() {
        let mut family = family((name, help));
        for Shown { world, robot, measures, .. } in &shown {
            for (line, direction) in measures.lines.iter().zip(DIRECTIONS) {
                family.add(&[("world", world), ("robot", robot), ("direction", direction)], line[i]);
            }
        }
        family.write(text);
    }
    write_cycles(&shown, text);
}

fn write_cycles(shown: &[Shown<'_>], text: &mut String) {
    let mut counts =
        Family::counter("baudbot_brain_cycles_total", "Control cycles that are over, by outcome.");
    let mut deadlines = Family::gauge(
        "baudbot_brain_cycle_deadline_seconds",
        "Simulated time after which a control cycle is late.",
    );
    let mut durations = Family::summary(
        "baudbot_brain_cycle_seconds",
        "Duration of answered control cycles in simulated time; quantiles are of the whole run.",
    );
    for Shown { world, robot, measures, deadline_ns } in shown {
        let (world, robot, cycles) = (("world", *world), ("robot", *robot), &measures.cycles);
        let outcomes = [("kept", cycles.kept), ("late", cycles.late), ("unanswered", cycles.unanswered)];
        for (outcome, n) in outcomes {
            counts.add(&[world, robot, ("outcome", outcome)], n as f64);
        }
        deadlines.add(&[world, robot], seconds(*deadline_ns));
        let quantiles = QUANTILES.into_iter().zip(cycles.quantiles_ns);
        let quantiles = quantiles.filter_map(|(q, ns)| Some((q, seconds(ns?))));
        durations.add_summary(&[world, robot], quantiles, cycles.count, seconds(cycles.sum_ns));
    }
    counts.write(text);
    deadlines.write(text);
    durations.write(text);
}

fn seconds(ns: u64) -> f64 {
    // A division gives the number nearest to the decimal one, so that it is short when it is written.
    ns as f64 / 1e9
}
