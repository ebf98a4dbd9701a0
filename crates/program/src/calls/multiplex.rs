//! Calls that wait for any of several things. The kernel does them, without waiting; they are made again when something has happened.

use super::glance::{self, Answer};
use super::{Outcome, deadline};
use crate::cables::Cables;
use crate::error::Error;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::os::trace::Registers;
use crate::task::{Activity, After, Task};

/// The values of calls that a signal has interrupted, before the kernel makes EINTR of it or restarts it (linux/errno.h).
const RESTARTS: std::ops::RangeInclusive<i64> = -516..=-512;
const RESTART_WITHOUT_HANDLER: i64 = -514;

/// The places of a time-out.
enum Timeout {
    /// An argument, in milliseconds.
    Milliseconds(usize),
    /// An argument that points to a `struct timespec` (1) or `struct timeval` (1,000).
    Pointer(usize, u64),
}

fn timeout(number: i64) -> Timeout {
    match number {
        libc::SYS_poll => Timeout::Milliseconds(2),
        libc::SYS_epoll_wait | libc::SYS_epoll_pwait => Timeout::Milliseconds(3),
        libc::SYS_select => Timeout::Pointer(4, 1000),
        libc::SYS_pselect6 => Timeout::Pointer(4, 1),
        libc::SYS_ppoll => Timeout::Pointer(2, 1),
        _ => Timeout::Pointer(3, 1),
    }
}

fn argument(registers: &mut Registers, place: usize) -> &mut u64 {
    match place {
        2 => &mut registers.rdx,
        3 => &mut registers.r10,
        _ => &mut registers.r8,
    }
}

pub(super) fn enter(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let now_ns = kernel.now_ns;
    let caller = &mut kernel.tasks[task];
    let timeout = timeout(caller.number_of_call());
    let deadline = deadline(caller, |task| {
        Ok(match timeout {
            Timeout::Milliseconds(place) => match task.argument(place) as i32 {
                ..0 => None,
                milliseconds => Some(now_ns + u64::from(milliseconds.unsigned_abs()) * 1_000_000),
            },
            Timeout::Pointer(place, unit_ns) => match task.argument(place) {
                0 => None,
                address => Some(now_ns.saturating_add(task.read_time(address, unit_ns)?)),
            },
        })
    })?;
    if let Some(answer) = glance::answer(kernel, task)? {
        return glanced(kernel, task, deadline, &answer);
    }
    if kernel.empty_epoll.is_some_and(|empty| Some(empty) == epoll(kernel, task)) {
        return Ok(match deadline {
            Some(deadline) if deadline <= kernel.now_ns => Outcome::Nothing,
            until_ns => Outcome::Wait(Activity::Ours { until_ns, seen: kernel.progress }),
        });
    }
    kernel.show_flags();
    let caller = &kernel.tasks[task];
    let sets = sets(caller)?;
    match timeout {
        Timeout::Milliseconds(place) => caller.replace(|registers| *argument(registers, place) = 0)?,
        Timeout::Pointer(place, _) => {
            caller.write(caller.scratch, &[0; 16])?;
            caller.replace(|registers| *argument(registers, place) = caller.scratch)?;
        }
    }
    Ok(Outcome::Observed(After::Multiplex { deadline, sets }))
}

/// The epoll that a task looks at, and what the kernel has done by now; none if it may have a port in it.
fn epoll(kernel: &Kernel, task: usize) -> Option<(i32, i32, u64)> {
    let caller = &kernel.tasks[task];
    let is_epoll = matches!(
        caller.number_of_call(),
        libc::SYS_epoll_wait | libc::SYS_epoll_pwait | libc::SYS_epoll_pwait2
    );
    // One with a mask of signals may end by a signal that has come long before.
    let has_mask = caller.number_of_call() != libc::SYS_epoll_wait && caller.argument(4) != 0;
    (is_epoll && !has_mask && !kernel.has_port_in_epoll).then_some((
        caller.process,
        caller.descriptor(0),
        kernel.done,
    ))
}

/// The outcome of a call whose answer needs no kernel.
fn glanced(kernel: &Kernel, task: usize, deadline: Option<u64>, answer: &Answer) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    if answer.count == 0 && deadline.is_none_or(|deadline| deadline > kernel.now_ns) {
        return Ok(Outcome::Wait(Activity::Ours { until_ns: deadline, seen: kernel.progress }));
    }
    for (address, bytes) in &answer.told {
        caller.write(*address, bytes)?;
    }
    tell_rest(caller, deadline, kernel.now_ns);
    Ok(Outcome::Look(answer.count))
}

/// Linux writes the time that is left, if it can.
fn tell_rest(task: &Task, deadline: Option<u64>, now_ns: u64) {
    if let (Timeout::Pointer(place, unit_ns), Some(deadline)) = (timeout(task.number_of_call()), deadline)
        && task.number_of_call() != libc::SYS_epoll_pwait2
    {
        let _ = task.write_time(task.argument(place), deadline.saturating_sub(now_ns), unit_ns);
    }
}

/// The sets of a select, which the kernel overwrites.
fn sets(task: &Task) -> Result<Vec<(u64, Vec<u8>)>, Fault> {
    if !matches!(task.number_of_call(), libc::SYS_select | libc::SYS_pselect6) {
        return Ok(Vec::new());
    }
    let size = task.argument(0).min(65_536).div_ceil(64) as usize * 8;
    let mut sets = Vec::new();
    for place in 1..4 {
        if task.argument(place) != 0 {
            let mut set = vec![0; size];
            task.read(task.argument(place), &mut set)?;
            sets.push((task.argument(place), set));
        }
    }
    Ok(sets)
}

pub(super) fn leave(
    kernel: &mut Kernel,
    task: usize,
    deadline: Option<u64>,
    sets: &[(u64, Vec<u8>)],
) -> Result<(), Error> {
    let (now_ns, seen) = (kernel.now_ns, kernel.progress);
    let epoll = epoll(kernel, task);
    let caller = &mut kernel.tasks[task];
    let answer = caller.value()?;
    if RESTARTS.contains(&answer) {
        return caller.returns(RESTART_WITHOUT_HANDLER);
    }
    if answer == 0 {
        kernel.empty_epoll = epoll;
    }
    let caller = &mut kernel.tasks[task];
    if answer == 0 && deadline.is_none_or(|deadline| deadline > now_ns) {
        for (address, set) in sets {
            // The kernel has just written there.
            let _ = caller.write(*address, set);
        }
        caller.rewind(deadline)?;
        caller.activity =
            Activity::Kernels { until_ns: deadline, seen, done: epoll.map(|(_, _, done)| done) };
        return Ok(());
    }
    caller.complete();
    caller.returns(answer)?;
    tell_rest(caller, deadline, now_ns);
    kernel.charge(task);
    Ok(())
}

/// The options of a wait for children.
fn options(task: &Task) -> usize {
    if task.number_of_call() == libc::SYS_wait4 { 2 } else { 3 }
}

pub(super) fn enter_child(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let task = &mut kernel.tasks[task];
    let is_patient = task.argument(options(task)) & libc::WNOHANG as u64 == 0;
    let is_waitid = task.number_of_call() == libc::SYS_waitid;
    if is_patient {
        task.replace(|registers| {
            *argument(registers, options(task)) |= libc::WNOHANG as u64;
            if is_waitid && registers.rdx == 0 {
                registers.rdx = task.scratch;
            }
        })?;
    }
    Ok(Outcome::Observed(After::Child { is_patient }))
}

pub(super) fn leave_child(kernel: &mut Kernel, task: usize, is_patient: bool) -> Result<(), Error> {
    let waiting = kernel.waiting();
    let caller = &mut kernel.tasks[task];
    let answer = caller.value()?;
    let is_nobody = if caller.number_of_call() == libc::SYS_waitid {
        let told = if caller.argument(2) == 0 { caller.scratch } else { caller.argument(2) };
        answer == 0 && is_patient && caller.read_u32(told).is_ok_and(|signal| signal == 0)
    } else {
        answer == 0
    };
    if is_nobody && is_patient {
        caller.rewind(None)?;
        caller.activity = waiting;
        return Ok(());
    }
    caller.complete();
    caller.returns(answer)?;
    if is_nobody {
        kernel.charge(task);
    }
    Ok(())
}
