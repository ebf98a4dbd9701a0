//! The processor time of programs.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rustix::process::Pid;

/// The processor time that the programs of a run have used, each with its children. It has none before a
/// [`Crew`](crate::programs::Crew) gives it some.
#[derive(Clone, Debug, Default)]
pub struct ProcessorClock(Arc<Mutex<Vec<Program>>>);

/// A program and its robots.
#[derive(Debug)]
struct Program {
    robots: Vec<String>,
    processes: Vec<Process>,
    /// The time of programs that have ended.
    ended: Duration,
}

/// A process of a program: its own, or a child.
#[derive(Debug)]
struct Process {
    id: Pid,
    /// The time that it had used when it was found: it was loaded then, and did not think.
    before: Duration,
    /// The time that it has used since, at the last look.
    used: Duration,
}

impl ProcessorClock {
    /// The time that the program of a robot has used with its children, in all their threads, since they were found. It
    /// never decreases. `None` if no program drives the robot, or the system has no such numbers.
    pub fn read(&self, robot: &str) -> Option<Duration> {
        let mut programs = self.programs();
        let program = programs.iter_mut().find(|program| program.robots.iter().any(|name| name == robot))?;
        let mut is_known = false;
        for process in &mut program.processes {
            if let Some(used) = used(process.id) {
                process.used = used.saturating_sub(process.before);
                is_known = true;
            }
        }
        let sum: Duration = program.processes.iter().map(|process| process.used).sum();
        is_known.then_some(program.ended + sum)
    }

    /// Sets which programs there are: of each the robots and the processes that live.
    pub(crate) fn set(&self, programs: impl Iterator<Item = (Vec<String>, Vec<Pid>)>) {
        let mut known = self.programs();
        let mut old = std::mem::take(&mut *known);
        known.extend(programs.map(|(robots, ids)| {
            let place = old.iter().position(|program| program.robots == robots);
            let mut program = place.map_or_else(
                || Program { robots, processes: Vec::new(), ended: Duration::ZERO },
                |place| old.swap_remove(place),
            );
            program.renew(&ids);
            program
        }));
    }

    fn programs(&self) -> MutexGuard<'_, Vec<Program>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Program {
    /// Replaces the processes that live by these.
    fn renew(&mut self, ids: &[Pid]) {
        let (live, ended): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.processes).into_iter().partition(|process| ids.contains(&process.id));
        self.ended += ended.iter().map(|process| process.used).sum::<Duration>();
        self.processes = live;
        for &id in ids {
            if !self.processes.iter().any(|process| process.id == id)
                && let Some(before) = used(id)
            {
                self.processes.push(Process { id, before, used: Duration::ZERO });
            }
        }
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
        assert_eq!(clock.read("bob"), None);
        let mut sum = 0_u64;
        while clock.read("alice").unwrap() < Duration::from_millis(20) {
            sum = sum.wrapping_mul(3).wrapping_add(1);
        }
        let used = clock.read("alice").unwrap();
        let alone = std::process::Command::new("sleep").arg("60").spawn();
        let mut alone = alone.unwrap();
        let idle = Pid::from_raw(alone.id().cast_signed()).unwrap();
        while std::fs::read_to_string(format!("/proc/{}/comm", alone.id())).unwrap() != "sleep\n" {
            std::thread::yield_now();
        }
        // A process that is found later has used nothing, and what an ended one has used counts on.
        clock.set([(vec!["alice".to_owned()], vec![idle])].into_iter());
        let kept = clock.read("alice").unwrap();
        assert!(kept >= used && kept < used + Duration::from_secs(1), "{kept:?} {used:?} {sum}");
        alone.kill().unwrap();
        alone.wait().unwrap();
        assert_eq!(clock.read("alice"), None);
    }
}
