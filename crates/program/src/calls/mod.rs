//! The system calls that a program may not simply do: each is answered from simulated time, done by the kernel without waiting, or
//! refused by its name.

mod clocks;
mod descriptors;
mod futex;
mod glance;
mod listing;
mod multiplex;
mod paths;
mod port;
mod port_control;
mod refused;
mod signals;
mod tasks;
mod timers;

use crate::cables::Cables;
use crate::error::Error;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::task::{Activity, After, Task};

/// The outcome of a call.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// It returns this.
    Answer(i64),
    /// It returns this, and has only looked.
    Look(i64),
    /// It returns this, and has moved bytes or woken somebody.
    Moved(i64),
    /// It returns 0, as the kernel would have answered.
    Nothing,
    /// The kernel does it.
    Native,
    /// The kernel does it, and its return matters.
    Observed(After),
    /// It waits.
    Wait(Activity),
    /// It returns 0, and others run first.
    Yield,
    /// The kernel does it, and the thread ends by it.
    ThreadEnd,
    /// The kernel does it, and the process ends by it.
    ProcessEnd,
}

type Handler = fn(&mut Kernel, usize, &mut dyn Cables) -> Result<Outcome, Fault>;

/// The numbers of all calls that stop a task.
pub(crate) fn shown() -> Vec<i64> {
    TABLE.iter().flat_map(|(numbers, _)| numbers.iter().copied()).collect()
}

/// A call at its entry, or one of ours that is looked at again.
pub(crate) fn enter(kernel: &mut Kernel, task: usize, cables: &mut dyn Cables) -> Result<Outcome, Error> {
    let number = kernel.tasks[task].number_of_call();
    let Some((_, handler)) = TABLE.iter().find(|(numbers, _)| numbers.contains(&number)) else {
        return Err(kernel.tasks[task].refuse(
            format!("{} (call {number:#x})", crate::names::call(number)),
            "only 64-bit programs run in simulated time",
        ));
    };
    match handler(kernel, task, cables) {
        Ok(outcome) => Ok(outcome),
        Err(Fault::Errno(errno)) => Ok(Outcome::Answer(-i64::from(errno))),
        Err(Fault::Session(error)) => Err(error),
    }
}

/// The return of a call that is observed.
pub(crate) fn leave(
    kernel: &mut Kernel,
    task: usize,
    after: After,
    cables: &mut dyn Cables,
) -> Result<(), Error> {
    match after {
        After::Multiplex { deadline, sets } => multiplex::leave(kernel, task, deadline, &sets),
        After::Child { is_patient } => multiplex::leave_child(kernel, task, is_patient),
        After::Probe { descriptor } => descriptors::leave_probe(kernel, task, descriptor),
        After::Listing => listing::leave(kernel, task),
        After::Piece => descriptors::leave_piece(kernel, task),
        After::Opening { port } => paths::leave_opening(kernel, task, port, cables),
        After::Closing => {
            kernel.close_ports(cables);
            Ok(())
        }
        // The processes that are killed are seen to by the session.
        After::Signals { .. } => Ok(()),
    }
}

/// The deadline of a call that may be the same one again.
fn deadline(
    task: &mut Task,
    compute: impl FnOnce(&Task) -> Result<Option<u64>, Fault>,
) -> Result<Option<u64>, Fault> {
    if let Some(deadline) = task.call.again {
        return Ok(deadline);
    }
    let deadline = compute(task)?;
    task.call.again = Some(deadline);
    Ok(deadline)
}

const TABLE: &[(&[i64], Handler)] = &[
    (&[libc::SYS_clock_gettime, libc::SYS_gettimeofday, libc::SYS_time], clocks::read),
    (&[libc::SYS_times, libc::SYS_getrusage], clocks::usage),
    (
        &[libc::SYS_clock_settime, libc::SYS_settimeofday, libc::SYS_adjtimex, libc::SYS_clock_adjtime],
        clocks::set,
    ),
    (&[libc::SYS_nanosleep, libc::SYS_clock_nanosleep], clocks::sleep),
    (&[libc::SYS_alarm, libc::SYS_setitimer, libc::SYS_getitimer], timers::alarm),
    (&[libc::SYS_timer_create, libc::SYS_timerfd_create], timers::create),
    (&[libc::SYS_timer_settime, libc::SYS_timerfd_settime], timers::set),
    (&[libc::SYS_timer_gettime, libc::SYS_timerfd_gettime], timers::tell),
    (&[libc::SYS_timer_delete, libc::SYS_timer_getoverrun], timers::delete),
    (&[libc::SYS_futex], futex::call),
    (&[libc::SYS_read, libc::SYS_readv, libc::SYS_recvfrom, libc::SYS_recvmsg], descriptors::read),
    (&[libc::SYS_write, libc::SYS_writev, libc::SYS_sendto, libc::SYS_sendmsg], descriptors::write),
    (
        &[libc::SYS_splice, libc::SYS_copy_file_range, libc::SYS_sendfile, libc::SYS_tee, libc::SYS_vmsplice],
        descriptors::transfer,
    ),
    (&[libc::SYS_ioctl], port_control::call),
    (
        &[
            libc::SYS_select,
            libc::SYS_pselect6,
            libc::SYS_poll,
            libc::SYS_ppoll,
            libc::SYS_epoll_wait,
            libc::SYS_epoll_pwait,
            libc::SYS_epoll_pwait2,
        ],
        multiplex::enter,
    ),
    (&[libc::SYS_wait4, libc::SYS_waitid], multiplex::enter_child),
    (&[libc::SYS_open, libc::SYS_openat, libc::SYS_creat], paths::open),
    (&[libc::SYS_stat, libc::SYS_lstat, libc::SYS_fstat, libc::SYS_newfstatat, libc::SYS_statx], paths::stat),
    (&[libc::SYS_access, libc::SYS_faccessat, libc::SYS_faccessat2], paths::access),
    (&[libc::SYS_readlink, libc::SYS_readlinkat], paths::read_link),
    (&[libc::SYS_close, libc::SYS_close_range, libc::SYS_dup2, libc::SYS_dup3], descriptors::close),
    (&[libc::SYS_getdents64], listing::list),
    (&[libc::SYS_getrandom], tasks::random),
    (&[libc::SYS_sched_yield], tasks::give_way),
    (&[libc::SYS_sched_getaffinity, libc::SYS_sched_setaffinity, libc::SYS_getcpu], tasks::affinity),
    (&[libc::SYS_epoll_ctl, libc::SYS_shutdown], tasks::change_descriptor),
    (&[libc::SYS_clone], tasks::clone),
    (&[libc::SYS_execve, libc::SYS_execveat], tasks::exec),
    (&[libc::SYS_exit, libc::SYS_exit_group], tasks::exit),
    (
        &[
            libc::SYS_kill,
            libc::SYS_tkill,
            libc::SYS_tgkill,
            libc::SYS_rt_sigqueueinfo,
            libc::SYS_rt_tgsigqueueinfo,
            libc::SYS_pidfd_send_signal,
        ],
        signals::send,
    ),
    (&[libc::SYS_pause, libc::SYS_rt_sigsuspend, libc::SYS_rt_sigtimedwait], signals::wait),
    (refused::ABSENT, refused::absent),
    (refused::REFUSED, refused::refuse),
    (&[libc::SYS_socket, libc::SYS_connect], refused::socket),
];
