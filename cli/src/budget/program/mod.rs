//! The budget of a robot whose microcontroller runs a program of its own. What the program costs cannot be computed from the
//! scenario: it is measured in a run.
//!
//! A cycle is a round of the program's main loop, and the time from the readings to the motors: when the program
//! changes what the motors do, how long ago it has read the sensor whose newest reading is the oldest of all. A sensor
//! that it has not read for a second is none of those that it goes by. Whether a sensor takes part in the decision is
//! unknown.

mod told;
mod watch;

use std::sync::Arc;

use baudbot_scenario::budget::{Span, Verdict};
use baudbot_sim::Scenario;
use serde::Serialize;

pub(super) use told::told;
use watch::{Watch, measure};

/// The measured timing of a program.
#[derive(Debug, Serialize)]
pub(super) struct ProgramBudget {
    pub(super) robot: String,
    /// The part's name, such as ATmega328P.
    part: String,
    clock_hz: u32,
    /// The time for which it was watched, in nanoseconds: since its bootloader was over.
    watched_ns: u64,
    starts_after_ns: u64,
    deadline_ns: u64,
    /// In cycles of the clock source; absent if no main loop was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    round_cycles: Option<Rounds>,
    /// The same in time. The worst is the longest that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    round: Option<Span>,
    /// The time from the readings to the motors; absent if the program never changed what they do, or read no sensor
    /// before.
    #[serde(skip_serializing_if = "Option::is_none")]
    readings_to_motors: Option<Span>,
    rates: Vec<Rate>,
    /// The age of each sensor's last reading when the program changed the motors' signals.
    ages: Vec<Age>,
    loads: Vec<Load>,
    /// The most bytes that the stack has had.
    stack_bytes: u32,
    /// Bytes that one side has sent and the other has not got.
    lost_bytes: u64,
    pub(super) verdict: Verdict,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Rounds {
    count: u64,
    best: u64,
    typical: u64,
    worst: u64,
}

#[derive(Debug, Serialize)]
struct Rate {
    what: String,
    per_s: f64,
}

#[derive(Debug, Serialize)]
struct Age {
    sensor: String,
    #[serde(flatten)]
    span: Span,
}

/// The bytes a second over a cable, and the number that it carries.
#[derive(Debug, Serialize)]
struct Load {
    what: &'static str,
    share: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes_per_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    most_bytes_per_s: Option<f64>,
}

/// Runs the scenario without brains, and returns the costs of the programs of these robots.
pub(super) fn of(scenario: &Arc<Scenario>, robots: &[usize], seconds: f64) -> Vec<ProgramBudget> {
    if robots.is_empty() {
        return Vec::new();
    }
    let (world, watches) = measure(scenario, robots, seconds);
    let budget = |watch: &Watch| watch.budget(&world);
    watches.iter().filter_map(budget).collect()
}

/// The verdict about a program, by the longer of its round and its way from the readings to the motors.
fn verdict(deadline_ns: u64, cycles: [Option<Span>; 2], lost_bytes: u64) -> Verdict {
    let cycles = || cycles.into_iter().flatten();
    let typical = cycles().filter_map(|cycle| cycle.typical_ns).max();
    let worst = cycles().filter_map(|cycle| cycle.worst_ns).max();
    match (typical, worst) {
        (Some(typical), Some(worst)) if typical <= deadline_ns && lost_bytes == 0 => {
            if worst <= deadline_ns {
                Verdict::Keeps
            } else {
                Verdict::Sometimes
            }
        }
        _ => Verdict::Misses,
    }
}
