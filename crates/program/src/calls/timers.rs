//! Timers: those of processes (alarm, setitimer), those that programs create (timer_create), and those that are descriptors (timerfd).

use std::path::Path;

use super::Outcome;
use super::clocks::{TIMESPEC, TIMEVAL, start_ns};
use crate::cables::Cables;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::task::{Activity, After, Task};
use crate::timers::{Notice, Owner, Timer};
use crate::tty::flag::Flag;

const NO_PROCESSOR_TIME: &str = "computing takes no time";
/// Ways of a `struct sigevent` to tell (linux/signal.h).
const NOT: i32 = 1;
const TO_THREAD: i32 = 4;

/// The timer of a process that follows the wall clock. The others follow processor time, which does not pass.
pub(super) fn alarm(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let (process, number) = (caller.process, caller.number_of_call());
    if number != libc::SYS_alarm && caller.descriptor(0) != libc::ITIMER_REAL {
        return Err(caller.refuse("setitimer(ITIMER_VIRTUAL or ITIMER_PROF)", NO_PROCESSOR_TIME).into());
    }
    let is_own = |timer: &Timer| matches!(timer.owner, Owner::Process(owner) if owner == process);
    let left =
        kernel.timers.iter().find(|timer| is_own(timer)).map_or((0, 0), |timer| timer.left(kernel.now_ns));
    let (wanted, answer) = match number {
        libc::SYS_alarm => {
            let wanted_ns = u64::from(caller.argument(0) as u32) * 1_000_000_000;
            (Some((wanted_ns, 0)), left.0.div_ceil(1_000_000_000).cast_signed())
        }
        libc::SYS_getitimer => {
            write_times(caller, caller.argument(1), left, TIMEVAL)?;
            (None, 0)
        }
        _ => {
            let wanted = read_times(caller, caller.argument(1), TIMEVAL)?;
            write_times(caller, caller.argument(2), left, TIMEVAL)?;
            (Some(wanted), 0)
        }
    };
    if let Some((first_ns, every_ns)) = wanted {
        kernel.timers.retain(|timer| !is_own(timer));
        if first_ns > 0 {
            let due_ns = kernel.now_ns.saturating_add(first_ns);
            kernel.timers.push(Timer { owner: Owner::Process(process), start_ns: 0, due_ns, every_ns });
        }
    }
    Ok(Outcome::Answer(answer))
}

/// `struct itimerval` and `struct itimerspec`: the period, and the time to the first ring. Here they are the other way round.
fn read_times(task: &Task, place: u64, unit_ns: u64) -> Result<(u64, u64), Fault> {
    Ok((task.read_time(place + 16, unit_ns)?, task.read_time(place, unit_ns)?))
}

fn write_times(task: &Task, place: u64, (left_ns, every_ns): (u64, u64), unit_ns: u64) -> Result<(), Fault> {
    if place == 0 {
        return Ok(());
    }
    task.write_time(place, every_ns, unit_ns)?;
    task.write_time(place + 16, left_ns, unit_ns)
}

pub(super) fn create(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let is_file = caller.number_of_call() == libc::SYS_timerfd_create;
    let Some(start_ns) = start_ns(caller.descriptor(0)) else {
        let call = crate::names::call(caller.number_of_call());
        return Err(caller.refuse(format!("{call}(of processor time)"), NO_PROCESSOR_TIME).into());
    };
    let stopped = |owner| Timer { owner, start_ns, due_ns: u64::MAX, every_ns: 0 };
    if is_file {
        let flag = Flag::new().map_err(|_| Fault::Errno(libc::EMFILE))?;
        // The bits of TFD_NONBLOCK and TFD_CLOEXEC are those of open.
        caller.open_instead(&flag.path(), caller.argument(1))?;
        kernel.timers.push(stopped(Owner::File { flag, rings: 0 }));
        return Ok(Outcome::Observed(After::Opening { port: None }));
    }
    let process = caller.process;
    let id = kernel.timers_created;
    let mut notice = Notice { signal: libc::SIGALRM, value: u64::from(id.cast_unsigned()), tid: None };
    let event = caller.argument(1);
    let mut is_told = true;
    if event != 0 {
        let word = |place| Ok::<_, Fault>(caller.read_u32(event + place)?.cast_signed());
        notice = Notice { signal: word(8)?, value: caller.read_u64(event)?, tid: None };
        is_told = word(12)? != NOT;
        if word(12)? == TO_THREAD {
            notice.tid = Some(word(16)?);
        }
    }
    caller.write(caller.argument(2), &id.to_ne_bytes())?;
    kernel.timers_created += 1;
    kernel.timers.push(stopped(Owner::Created { process, id, notice: is_told.then_some(notice) }));
    Ok(Outcome::Answer(0))
}

/// The place of the timer that a call is about.
fn place(kernel: &Kernel, task: usize) -> Result<usize, Fault> {
    let caller = &kernel.tasks[task];
    let wanted = caller.descriptor(0);
    let file = kernel.files.name(caller, wanted);
    let is_file = matches!(caller.number_of_call(), libc::SYS_timerfd_settime | libc::SYS_timerfd_gettime);
    let is_meant = |timer: &Timer| match timer.owner {
        Owner::File { .. } => is_file && file.as_ref().is_some_and(|file| timer.rings(file).is_some()),
        Owner::Created { process, id, .. } => !is_file && (process, id) == (caller.process, wanted),
        Owner::Process(_) => false,
    };
    kernel.timers.iter().position(is_meant).ok_or(Fault::Errno(libc::EINVAL))
}

pub(super) fn set(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let now_ns = kernel.now_ns;
    let place = place(kernel, task)?;
    let (caller, timer) = (&kernel.tasks[task], &mut kernel.timers[place]);
    let (first_ns, every_ns) = read_times(caller, caller.argument(2), TIMESPEC)?;
    write_times(caller, caller.argument(3), timer.left(now_ns), TIMESPEC)?;
    let is_absolute = caller.argument(1) & libc::TIMER_ABSTIME as u64 != 0;
    timer.every_ns = every_ns;
    timer.due_ns = match first_ns {
        0 => u64::MAX,
        _ if is_absolute => first_ns.saturating_sub(timer.start_ns).max(now_ns),
        _ => now_ns.saturating_add(first_ns),
    };
    if let Owner::File { flag, rings } = &mut timer.owner {
        *rings = 0;
        flag.set(false);
    }
    kernel.ring();
    Ok(Outcome::Answer(0))
}

pub(super) fn tell(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let left = kernel.timers[place(kernel, task)?].left(kernel.now_ns);
    let caller = &kernel.tasks[task];
    write_times(caller, caller.argument(1), left, TIMESPEC)?;
    Ok(Outcome::Answer(0))
}

pub(super) fn delete(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let place = place(kernel, task)?;
    // A ring that has not been delivered stands for all, so none is overrun.
    if kernel.tasks[task].number_of_call() == libc::SYS_timer_delete {
        kernel.timers.remove(place);
    }
    Ok(Outcome::Answer(0))
}

/// A read of a timer that is a descriptor, if the file is one: the number of its rings.
pub(super) fn read(kernel: &mut Kernel, task: usize, file: &Path) -> Result<Option<Outcome>, Fault> {
    let caller = &kernel.tasks[task];
    let timer = kernel.timers.iter_mut().find_map(|timer| match &mut timer.owner {
        Owner::File { flag, rings } if flag.name() == file => Some((flag, rings)),
        Owner::File { .. } | Owner::Process(_) | Owner::Created { .. } => None,
    });
    let Some((flag, rings)) = timer else { return Ok(None) };
    if caller.argument(2) < 8 {
        return Err(Fault::Errno(libc::EINVAL));
    }
    if *rings == 0 {
        let waits = !crate::os::proc::is_nonblocking(caller.tid, caller.descriptor(0));
        let wait = Activity::Ours { until_ns: None, seen: kernel.progress };
        return Ok(Some(if waits { Outcome::Wait(wait) } else { Outcome::Look(-i64::from(libc::EAGAIN)) }));
    }
    caller.write(caller.argument(1), &rings.to_ne_bytes())?;
    *rings = 0;
    flag.set(false);
    Ok(Some(Outcome::Moved(8)))
}
