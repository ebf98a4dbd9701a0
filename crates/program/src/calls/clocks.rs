//! Clocks and sleeps.

use super::{Outcome, deadline};
use crate::cables::Cables;
use crate::fault::Fault;
use crate::kernel::{EPOCH_NS, Kernel, UPTIME_NS};
use crate::task::{Activity, Task};

/// Nanoseconds in what `struct timespec` and `struct timeval` count.
pub(super) const TIMESPEC: u64 = 1;
pub(super) const TIMEVAL: u64 = 1000;
/// A `Ours` that is looked at again only when it is due.
const ONLY_WHEN_DUE: u64 = u64::MAX;
/// Nanoseconds in a tick of `times`.
const TICK_NS: u64 = 10_000_000;

/// The value of a clock at the beginning of simulated time; none for processor time.
pub(super) fn start_ns(clock: i32) -> Option<u64> {
    match clock {
        libc::CLOCK_REALTIME | libc::CLOCK_REALTIME_COARSE | libc::CLOCK_REALTIME_ALARM | libc::CLOCK_TAI => {
            Some(EPOCH_NS)
        }
        libc::CLOCK_MONOTONIC
        | libc::CLOCK_MONOTONIC_RAW
        | libc::CLOCK_MONOTONIC_COARSE
        | libc::CLOCK_BOOTTIME
        | libc::CLOCK_BOOTTIME_ALARM => Some(UPTIME_NS),
        _ => None,
    }
}

/// Processor time is what the task was charged: computing is free.
fn clock_ns(kernel: &Kernel, task: &Task, clock: i32) -> Result<u64, Fault> {
    match clock {
        12.. => Err(Fault::Errno(libc::EINVAL)),
        _ => Ok(start_ns(clock).map_or(task.charged_ns, |start_ns| start_ns + kernel.now_ns)),
    }
}

pub(super) fn read(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let place = caller.argument(0);
    let wall_ns = EPOCH_NS + kernel.now_ns;
    Ok(Outcome::Look(match caller.number_of_call() {
        libc::SYS_clock_gettime => {
            let value_ns = clock_ns(kernel, caller, place as i32)?;
            caller.write_time(caller.argument(1), value_ns, TIMESPEC)?;
            0
        }
        libc::SYS_time => {
            let seconds = wall_ns / 1_000_000_000;
            if place != 0 {
                caller.write(place, &seconds.to_ne_bytes())?;
            }
            seconds.cast_signed()
        }
        _ => {
            if place != 0 {
                caller.write_time(place, wall_ns, TIMEVAL)?;
            }
            if caller.argument(1) != 0 {
                caller.write(caller.argument(1), &[0; 8])?;
            }
            0
        }
    }))
}

/// Processor time and memory of a process are zeros: they would differ from run to run.
pub(super) fn usage(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    if caller.number_of_call() == libc::SYS_times {
        if caller.argument(0) != 0 {
            caller.write(caller.argument(0), &[0; 32])?;
        }
        return Ok(Outcome::Look(((UPTIME_NS + kernel.now_ns) / TICK_NS).cast_signed()));
    }
    caller.write(caller.argument(1), &[0; 144])?;
    caller.write_time(caller.argument(1), caller.charged_ns, TIMEVAL)?;
    Ok(Outcome::Look(0))
}

/// A program must not set the clock of the machine it runs on.
pub(super) fn set(_: &mut Kernel, _: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    Err(Fault::Errno(libc::EPERM))
}

pub(super) fn sleep(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let now_ns = kernel.now_ns;
    let until_ns = deadline(&mut kernel.tasks[task], |task| {
        if task.number_of_call() == libc::SYS_nanosleep {
            return Ok(Some(now_ns.saturating_add(task.read_time(task.argument(0), TIMESPEC)?)));
        }
        let time_ns = task.read_time(task.argument(2), TIMESPEC)?;
        let is_absolute = task.argument(1) & libc::TIMER_ABSTIME as u64 != 0;
        let start_ns = start_ns(task.descriptor(0)).ok_or(Fault::Errno(libc::EINVAL))?;
        Ok(Some(if is_absolute { time_ns.saturating_sub(start_ns) } else { now_ns.saturating_add(time_ns) }))
    })?;
    match until_ns {
        Some(until_ns) if until_ns <= now_ns => Ok(Outcome::Look(0)),
        until_ns => Ok(Outcome::Wait(Activity::Ours { until_ns, seen: ONLY_WHEN_DUE })),
    }
}
