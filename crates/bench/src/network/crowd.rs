//! Many robots in real time: does the world keep its clock, and what does it cost?

use std::process::Command;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use baudbot_proto::v1::WorldStatus;
use baudbot_server::{Pace, WorldConfig};
use baudbot_sim::Scenario;

use super::server::{Running, WORLD};
use super::{Found, NetworkError, check};
use crate::calibration;
use crate::child::{Brains, Child, Task};
use crate::measure::{Effort, Sample};
use crate::process;

/// Attaches the brains, lets the world go, and looks at how late its ticks begin. A world's status has that, too, but a
/// status of a thousand robots makes it late.
pub(super) fn run(
    scenario: Scenario,
    robots: Vec<String>,
    effort: Effort,
    command: Command,
    mut progress: impl FnMut(u32),
) -> Result<(Found, Vec<String>), NetworkError> {
    let step = Duration::from_nanos(scenario.step_ns);
    let ticks = Ticks::default();
    let heard = ticks.clone();
    let world = WorldConfig::new(WORLD, scenario).pace(Pace::REAL_TIME).paused(true);
    let server = Running::start(vec![world.on_tick(Box::new(move |_| heard.note()))], None)?;
    let what = Brains::RealTime { robots, streams: STREAMS };
    let child = Child::start(command, &Task::Brains { address: server.address(), what })?;
    wait_for_brains(&server)?;
    // Once, as long as nothing moves: later it would take the processor from what is measured.
    let calibration_per_s = calibration::rounds_per_second();
    server.go(WORLD)?;
    std::thread::sleep(Duration::from_secs_f64(effort.seconds / 4.0));
    let (start, cpu) = (Instant::now(), process::cpu_time());
    let mut samples = Vec::new();
    for repeat in 1..=effort.repeats {
        progress(repeat);
        let from = Instant::now();
        std::thread::sleep(Duration::from_secs_f64(effort.seconds));
        let value = percent(&ticks.lateness(step, from), |late| late < step);
        samples.push(Sample { value, calibration_per_s });
    }
    let processors = (process::cpu_time() - cpu).as_secs_f64() / start.elapsed().as_secs_f64();
    let lateness = ticks.lateness(step, start);
    let status = server.status()?;
    let usage = process::usage();
    server.end();
    let brains: Found = child.end(|_| {})?;
    check(&status, samples.len())?;
    let mut notes =
        vec![told(&lateness, &status), format!("server {usage}; {processors:.2} processors while measured")];
    notes.extend(brains.usage.map(|usage| format!("brains {usage}")));
    Ok((Found { samples, beside: None, usage: Some(usage) }, notes))
}

/// The note with the numbers that are not in the figure.
fn told(lateness: &[Duration], status: &WorldStatus) -> String {
    format!(
        "{} ticks, {:.2} % of them less than 1 ms late, {:.1} ms at most; {:.2} % of readings answered within a step",
        lateness.len(),
        percent(lateness, |late| late < Duration::from_millis(1)),
        lateness.iter().max().map_or(0.0, |most| most.as_secs_f64() * 1e3),
        100.0 * answered_in_time(status),
    )
}

/// The begin of each tick.
#[derive(Clone, Default)]
pub(super) struct Ticks(Arc<Mutex<Vec<Instant>>>);

impl Ticks {
    pub(super) fn note(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(Instant::now());
    }

    /// The lateness of each tick that ended since then: the time from its due end to the begin of the next. The first
    /// one's beginning starts the clock.
    pub(super) fn lateness(&self, step: Duration, since: Instant) -> Vec<Duration> {
        let begun = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(&first) = begun.first() else { return Vec::new() };
        let ends = begun.iter().enumerate().filter(|(_, at)| **at >= since);
        ends.map(|(tick, at)| at.saturating_duration_since(first + step * tick as u32)).collect()
    }
}

pub(super) fn percent(lateness: &[Duration], is: impl Fn(Duration) -> bool) -> f64 {
    let some = lateness.iter().filter(|late| is(**late)).count();
    // A world that is far behind may not have finished a tick at all.
    100.0 * some as f64 / lateness.len().max(1) as f64
}

fn wait_for_brains(server: &Running) -> Result<(), NetworkError> {
    let deadline = Instant::now() + PATIENCE;
    while !server.status()?.robots.iter().all(|robot| robot.attached) {
        if Instant::now() > deadline {
            return Err(NetworkError::Server(format!("not all brains were there after {PATIENCE:?}")));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(())
}

/// Share of the messages of readings that were answered within a step.
fn answered_in_time(status: &WorldStatus) -> f64 {
    let cycles = status.robots.iter().filter_map(|robot| robot.cycles.as_ref());
    let (kept, all) = cycles.fold((0, 0), |(kept, all), cycles| {
        (kept + cycles.kept, all + cycles.kept + cycles.late + cycles.unanswered)
    });
    kept as f64 / all.max(1) as f64
}

const STREAMS: usize = 10;

/// Brains that are not attached by then never will be.
const PATIENCE: Duration = Duration::from_secs(60);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_late_after_their_time_on_the_first_ones_clock() {
        let (start, ms) = (Instant::now(), Duration::from_millis);
        let ticks = Ticks(Arc::new(Mutex::new([0, 10, 21, 45, 40].map(|at| start + ms(at)).to_vec())));
        let lateness = ticks.lateness(ms(10), start + ms(5));
        assert_eq!(lateness, [0, 1, 15, 0].map(ms));
        assert_eq!(percent(&lateness, |late| late < ms(10)), 75.0);
        assert_eq!(percent(&[], |_| true), 0.0);
    }
}
