//! Calls about tasks and processors, and random numbers.

use super::Outcome;
use crate::cables::Cables;
use crate::fault::Fault;
use crate::kernel::Kernel;

/// Namespaces, and tasks that are not traced.
const REFUSED_FLAGS: i32 = libc::CLONE_NEWCGROUP
    | libc::CLONE_NEWIPC
    | libc::CLONE_NEWNET
    | libc::CLONE_NEWNS
    | libc::CLONE_NEWPID
    | libc::CLONE_NEWUSER
    | libc::CLONE_NEWUTS
    | libc::CLONE_UNTRACED;

pub(super) fn random(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let count = kernel.tasks[task].argument(1).min(65_536) as usize;
    let bytes = kernel.random.bytes(count);
    let caller = &kernel.tasks[task];
    caller.write(caller.argument(0), &bytes)?;
    Ok(Outcome::Answer(count as i64))
}

pub(super) fn give_way(_: &mut Kernel, _: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    Ok(Outcome::Yield)
}

/// One task runs at a time, so a program sees one processor, on whatever machine.
pub(super) fn affinity(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    match caller.number_of_call() {
        libc::SYS_sched_setaffinity => Ok(Outcome::Answer(0)),
        libc::SYS_getcpu => {
            for place in [caller.argument(0), caller.argument(1)] {
                if place != 0 {
                    caller.write(place, &[0; 4])?;
                }
            }
            Ok(Outcome::Answer(0))
        }
        _ => {
            if caller.argument(1) < 8 {
                return Err(Fault::Errno(libc::EINVAL));
            }
            caller.write(caller.argument(2), &1u64.to_ne_bytes())?;
            Ok(Outcome::Answer(8))
        }
    }
}

pub(super) fn clone(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    if caller.argument(0) as i32 & REFUSED_FLAGS != 0 {
        return Err(caller
            .refuse("clone(CLONE_NEW… or CLONE_UNTRACED)", "start the program inside of its container")
            .into());
    }
    Ok(Outcome::Native)
}

/// The kernel ends the other threads of a process that starts a program, and waits for us to notice while we wait for it.
pub(super) fn exec(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    if kernel.tasks.iter().filter(|task| task.process == caller.process).count() > 1 {
        let remedy = "start it from a process of its own (fork, subprocess)";
        return Err(caller.refuse("execve while it has several threads", remedy).into());
    }
    Ok(Outcome::Native)
}

/// The kernel does it; but who waits for a descriptor has to look again.
pub(super) fn change_descriptor(
    kernel: &mut Kernel,
    task: usize,
    _: &mut dyn Cables,
) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    kernel.has_port_in_epoll |=
        caller.number_of_call() == libc::SYS_epoll_ctl && kernel.is_ours(task, caller.descriptor(2));
    Ok(Outcome::Native)
}

pub(super) fn exit(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let is_last = kernel.tasks.iter().filter(|task| task.process == caller.process).count() == 1;
    let is_whole = is_last || caller.number_of_call() == libc::SYS_exit_group;
    Ok(if is_whole { Outcome::ProcessEnd } else { Outcome::ThreadEnd })
}
