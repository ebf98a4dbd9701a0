//! How much processor time programs have used.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rustix::process::Pid;

/// The processor time that the programs of a run have used, each with its children. It knows none before a [`Crew`](crate::Crew)
/// has told it.
#[derive(Clone, Debug, Default)]
pub struct ProcessorClock(Arc<Mutex<Vec<Program>>>);

/// A program and its robots.
#[derive(Debug)]
struct Program {
    robots: Vec<String>,
    /// Its process and its children.
    processes: Vec<Pid>,
    /// What was read last: the time of a child that has ended is no longer known, and the sum never decreases.
    last: Duration,
}

impl ProcessorClock {
    /// The time that the program of a robot has used with its children that live, in all their threads. `None` if no program
    /// drives the robot, or the system cannot tell.
    pub fn read(&self, robot: &str) -> Option<Duration> {
        let mut programs = self.programs();
        let program = programs.iter_mut().find(|program| program.robots.iter().any(|name| name == robot))?;
        let times: Vec<_> = program.processes.iter().filter_map(|&process| used(process)).collect();
        if times.is_empty() {
            return None;
        }
        program.last = program.last.max(times.iter().sum());
        Some(program.last)
    }

    /// Sets which programs there are: of each the robots and the processes.
    pub(crate) fn set(&self, programs: impl Iterator<Item = (Vec<String>, Vec<Pid>)>) {
        let mut known = self.programs();
        let old = std::mem::take(&mut *known);
        let last = |robots: &[String]| {
            old.iter().find(|program| program.robots == robots).map_or(Duration::ZERO, |program| program.last)
        };
        known.extend(programs.map(|(robots, processes)| Program { last: last(&robots), robots, processes }));
    }

    fn programs(&self) -> MutexGuard<'_, Vec<Program>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The time that a process has used in all its threads; `None` if it has ended.
#[cfg(target_os = "linux")]
fn used(process: Pid) -> Option<Duration> {
    let process = nix::unistd::Pid::from_raw(process.as_raw_nonzero().get());
    let clock = nix::time::clock_getcpuclockid(process).ok()?;
    Some(clock.now().ok()?.into())
}

#[cfg(not(target_os = "linux"))]
fn used(_: Pid) -> Option<Duration> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn the_time_of_this_process_grows_as_it_works_and_never_decreases() {
        let clock = ProcessorClock::default();
        assert_eq!(clock.read("alice"), None);
        let this = rustix::process::getpid();
        clock.set([(vec!["alice".to_owned()], vec![this])].into_iter());
        let begun = clock.read("alice").unwrap();
        let mut sum = 0_u64;
        while clock.read("alice").unwrap() < begun + Duration::from_millis(20) {
            sum = sum.wrapping_mul(3).wrapping_add(1);
        }
        assert_eq!(clock.read("bob"), None, "{sum}");
        let used = clock.read("alice").unwrap();
        // Its only child is a process that has hardly begun.
        let child = std::process::Command::new("sleep").arg("60").spawn();
        let mut child = child.unwrap();
        let id = Pid::from_raw(child.id().cast_signed()).unwrap();
        clock.set([(vec!["alice".to_owned()], vec![id])].into_iter());
        assert_eq!(clock.read("alice"), Some(used));
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(clock.read("alice"), None);
    }
}
