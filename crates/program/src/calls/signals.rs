//! Signals that tasks send, and waits for signals.

use std::fs;

use super::{Outcome, deadline};
use crate::cables::Cables;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::os::proc;
use crate::task::{Activity, After, Task};

pub(super) fn send(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let number = caller.number_of_call();
    let place = if matches!(number, libc::SYS_tgkill | libc::SYS_rt_tgsigqueueinfo) { 2 } else { 1 };
    let (target, signal) = (caller.descriptor(0), caller.argument(place) as i32);
    if number == libc::SYS_kill && target == -1 {
        return Err(caller.refuse("kill(-1)", "it would reach every process of this machine").into());
    }
    if matches!(signal, libc::SIGSTOP | libc::SIGTSTP | libc::SIGTTIN | libc::SIGTTOU) {
        return Err(caller
            .refuse(
                format!("{} to stop a process", crate::names::call(number)),
                "simulated time has no stopped processes",
            )
            .into());
    }
    if signal != libc::SIGKILL {
        return Ok(Outcome::Observed(After::Signals { killed: Vec::new() }));
    }
    let mut killed: Vec<i32> =
        kernel.tasks.iter().filter(|task| is_target(caller, target, task)).map(|task| task.process).collect();
    killed.sort_unstable();
    killed.dedup();
    if killed.contains(&caller.process) {
        return Ok(Outcome::ProcessEnd);
    }
    Ok(Outcome::Observed(After::Signals { killed }))
}

/// Whether a signal of the caller to `target` reaches a task's process.
fn is_target(caller: &Task, target: i32, task: &Task) -> bool {
    match caller.number_of_call() {
        libc::SYS_kill if target == 0 => group(task.tid) == group(caller.tid),
        libc::SYS_kill if target < 0 => group(task.tid) == Some(-target),
        libc::SYS_tkill => task.tid == target,
        libc::SYS_pidfd_send_signal => {
            let facts =
                fs::read_to_string(format!("/proc/{}/fdinfo/{target}", caller.tid)).unwrap_or_default();
            facts.lines().any(|line| line == format!("Pid:\t{}", task.process))
        }
        _ => task.process == target,
    }
}

/// The process group of a task.
fn group(tid: i32) -> Option<i32> {
    let stat = fs::read_to_string(format!("/proc/{tid}/stat")).ok()?;
    stat.rsplit_once(") ")?.1.split(' ').nth(2)?.parse().ok()
}

pub(super) fn wait(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let now_ns = kernel.now_ns;
    let caller = &mut kernel.tasks[task];
    let signals = proc::signals(caller.tid);
    let number = caller.number_of_call();
    let (blocked, until_ns) = match number {
        libc::SYS_pause => (signals.blocked, None),
        libc::SYS_rt_sigsuspend => (caller.read_u64(caller.argument(0))?, None),
        _ => {
            let until_ns = deadline(caller, |task| match task.argument(2) {
                0 => Ok(None),
                place => Ok(Some(now_ns.saturating_add(task.read_time(place, 1)?))),
            })?;
            // Those of the set are taken although they are blocked.
            (signals.blocked & !caller.read_u64(caller.argument(0))?, until_ns)
        }
    };
    if signals.is_due(blocked, signals.pending | signals.shared) {
        caller.complete();
        return Ok(Outcome::Native);
    }
    if until_ns.is_some_and(|until_ns| until_ns <= now_ns) {
        return Ok(Outcome::Look(-i64::from(libc::EAGAIN)));
    }
    Ok(Outcome::Wait(Activity::Signal { blocked, until_ns }))
}
