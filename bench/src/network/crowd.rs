//! Many robots in real time: does the world keep its clock, and what does it cost?

use std::process::Command;
use std::time::{Duration, Instant};

use baudbot_proto::v1::WorldStatus;
use baudbot_server::Pace;
use baudbot_sim::Scenario;

use super::server::Running;
use super::{Brains, Found, NetworkError, check};
use crate::calibration;
use crate::child::{Child, Task};
use crate::measure::{Effort, Sample};
use crate::process;

/// Attaches the brains, lets the world go, and looks at its clock once a repeat.
pub(super) fn run(
    scenario: Scenario,
    robots: Vec<String>,
    effort: Effort,
    command: Command,
    mut progress: impl FnMut(u32),
) -> Result<(Found, Vec<String>), NetworkError> {
    let server = Running::start(scenario, Pace::REAL_TIME, true)?;
    let what = Brains::RealTime { robots, streams: STREAMS };
    let child = Child::start(command, &Task::Brains { address: server.address(), what })?;
    wait_for_brains(&server)?;
    // Once, as long as nothing moves: later it would take the processor from what is measured.
    let calibration_per_s = calibration::rounds_per_second();
    server.go()?;
    std::thread::sleep(Duration::from_secs_f64(effort.seconds / 4.0));
    let mut before = server.status()?;
    let first = before.clone();
    let (start, cpu) = (Instant::now(), process::cpu_time());
    let mut samples = Vec::new();
    for repeat in 1..=effort.repeats {
        progress(repeat);
        std::thread::sleep(Duration::from_secs_f64(effort.seconds));
        let status = server.status()?;
        samples.push(Sample { value: 100.0 * on_time(&before, &status), calibration_per_s });
        before = status;
    }
    let processors = (process::cpu_time() - cpu).as_secs_f64() / start.elapsed().as_secs_f64();
    let usage = process::usage();
    server.end();
    let mut brains: Found = child.end(|_| {})?;
    check(&before, samples.len())?;
    let mut notes = vec![format!("server {usage}; {processors:.2} processors while measured")];
    notes.extend(brains.usage.take().map(|usage| format!("brains {usage}")));
    notes.push(told(&first, &before));
    Ok((Found { samples, ping: Vec::new(), usage: Some(usage) }, notes))
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

/// Share of the ticks in between that ended before the next was over, too.
fn on_time(before: &WorldStatus, after: &WorldStatus) -> f64 {
    let late = |status: &WorldStatus| status.pacing.as_ref().map_or(0, |pacing| pacing.late_ticks);
    // A world that is behind may not have finished a tick at all.
    let ticks = after.tick.saturating_sub(before.tick);
    if ticks == 0 { 0.0 } else { 1.0 - (late(after) - late(before)) as f64 / ticks as f64 }
}

/// How fast time went, how late ticks were, and how many answers came in time.
fn told(before: &WorldStatus, after: &WorldStatus) -> String {
    let lateness = |status: &WorldStatus| {
        let pacing = status.pacing.clone().unwrap_or_default();
        let soon: u64 = pacing.lateness_us_log2.iter().take(SOON_LOG2_US + 1).sum();
        (soon, pacing.lateness_us_log2.iter().sum::<u64>(), pacing.lateness_max_wall_ns)
    };
    let cycles = |status: &WorldStatus| {
        let cycles = status.robots.iter().filter_map(|robot| robot.cycles.as_ref());
        cycles.fold((0, 0), |(kept, all), c| (kept + c.kept, all + c.kept + c.late + c.unanswered))
    };
    let share = |part: u64, whole: u64| 100.0 * part as f64 / whole.max(1) as f64;
    let ((soon_before, all_before, _), (soon, all, most_ns)) = (lateness(before), lateness(after));
    let ((kept_before, cycles_before), (kept, cycles)) = (cycles(before), cycles(after));
    let wall_ns = after.running_wall_ns.saturating_sub(before.running_wall_ns).max(1);
    format!(
        "{:.3} × real time; {:.2} % of ticks less than {} ms late, {:.1} ms at most; {:.2} % of readings answered within a step",
        (after.time_ns - before.time_ns) as f64 / wall_ns as f64,
        share(soon - soon_before, all - all_before),
        1 << (SOON_LOG2_US - 10),
        most_ns as f64 / 1e6,
        share(kept - kept_before, cycles - cycles_before),
    )
}

const STREAMS: usize = 10;

/// Brains that are not attached by then never will be.
const PATIENCE: Duration = Duration::from_secs(60);

/// 2^10 µs, about a millisecond.
const SOON_LOG2_US: usize = 10;
