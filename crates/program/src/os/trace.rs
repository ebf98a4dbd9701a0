//! ptrace and waitpid: stops of tasks, their registers, and how they go on.

use std::io;

/// The registers of a task on x86-64.
pub(crate) type Registers = libc::user_regs_struct;

/// Everything that a task of ours starts is traced from its first instruction on, and dies with us.
const OPTIONS: i32 = libc::PTRACE_O_TRACESECCOMP
    | libc::PTRACE_O_TRACECLONE
    | libc::PTRACE_O_TRACEFORK
    | libc::PTRACE_O_TRACEVFORK
    | libc::PTRACE_O_TRACEVFORKDONE
    | libc::PTRACE_O_TRACEEXEC
    | libc::PTRACE_O_EXITKILL
    | libc::PTRACE_O_TRACESYSGOOD;

/// The reason why a task stands still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stop {
    /// It is no more; its exit code.
    Exit(i32),
    /// It is no more; the signal that has killed it.
    Death(i32),
    /// At the entry of a call that the filter shows us.
    Entry,
    /// At the return of a call.
    Return,
    /// A new thread or process exists, which waits for us.
    Birth(i32),
    /// A new process exists, which has the memory of this one until it starts a program.
    BorrowingBirth(i32),
    /// The process that had its memory has given it back.
    MemoryBack,
    /// It runs another program from here on.
    Exec,
    /// A signal is about to be delivered.
    Signal(i32),
}

/// The next stop of a task that goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Resume {
    /// To the next call that the filter shows, or a signal.
    Free,
    /// To the return of the call at whose entry it stands.
    ToReturn,
}

fn request(what: libc::c_uint, tid: i32, data: *mut libc::c_void) -> io::Result<()> {
    // SAFETY: `data` is null, a number, or points to what the request writes or reads; the callers see to that.
    let answer = unsafe { libc::ptrace(what, tid, std::ptr::null_mut::<libc::c_void>(), data) };
    if answer == -1 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

/// Sets what is reported of a task and of all that it starts.
pub(crate) fn set_options(tid: i32) -> io::Result<()> {
    request(libc::PTRACE_SETOPTIONS, tid, OPTIONS as usize as *mut libc::c_void)
}

/// Lets a task go on; `signal` is delivered, if it is not 0. A task that has been killed meanwhile is no error.
pub(crate) fn resume(tid: i32, how: Resume, signal: i32) -> io::Result<()> {
    let what = match how {
        Resume::Free => libc::PTRACE_CONT,
        Resume::ToReturn => libc::PTRACE_SYSCALL,
    };
    match request(what, tid, signal as usize as *mut libc::c_void) {
        Err(error) if error.raw_os_error() == Some(libc::ESRCH) => Ok(()),
        other => other,
    }
}

/// The registers of a task that stands still.
pub(crate) fn registers(tid: i32) -> io::Result<Registers> {
    // SAFETY: a structure of integers, for which zeros are valid.
    let mut registers: Registers = unsafe { std::mem::zeroed() };
    request(libc::PTRACE_GETREGS, tid, (&raw mut registers).cast())?;
    Ok(registers)
}

/// Sets the registers of a task that stands still.
pub(crate) fn set_registers(tid: i32, registers: &Registers) -> io::Result<()> {
    request(libc::PTRACE_SETREGS, tid, std::ptr::from_ref(registers).cast_mut().cast())
}

/// Waits until a task stands still or is no more.
pub(crate) fn wait(tid: i32) -> io::Result<Stop> {
    let mut status = 0;
    loop {
        // SAFETY: `status` outlives the call.
        let answer = unsafe { libc::waitpid(tid, &raw mut status, libc::__WALL) };
        if answer >= 0 {
            return stop(tid, status);
        }
        let error = io::Error::last_os_error();
        if error.kind() != io::ErrorKind::Interrupted {
            return Err(error);
        }
    }
}

fn stop(tid: i32, status: i32) -> io::Result<Stop> {
    if libc::WIFEXITED(status) {
        return Ok(Stop::Exit(libc::WEXITSTATUS(status)));
    }
    if libc::WIFSIGNALED(status) {
        return Ok(Stop::Death(libc::WTERMSIG(status)));
    }
    let signal = libc::WSTOPSIG(status);
    Ok(match status >> 16 {
        libc::PTRACE_EVENT_SECCOMP => Stop::Entry,
        libc::PTRACE_EVENT_CLONE | libc::PTRACE_EVENT_FORK => Stop::Birth(message(tid)?),
        libc::PTRACE_EVENT_VFORK => Stop::BorrowingBirth(message(tid)?),
        libc::PTRACE_EVENT_VFORK_DONE => Stop::MemoryBack,
        libc::PTRACE_EVENT_EXEC => Stop::Exec,
        _ if signal == libc::SIGTRAP | 0x80 => Stop::Return,
        _ => Stop::Signal(signal),
    })
}

/// The number of the task that has come into being.
fn message(tid: i32) -> io::Result<i32> {
    let mut message: libc::c_ulong = 0;
    request(libc::PTRACE_GETEVENTMSG, tid, (&raw mut message).cast())?;
    Ok(message as i32)
}

/// Sends the signal of a timer to one task of a process (`(process, tid)`), with the timer's number and a value of the program's.
pub(crate) fn signal_of_timer((process, tid): (i32, i32), signal: i32, (id, value): (i32, u64)) {
    // `siginfo_t`: signal, errno, code, padding, timer, overruns, value.
    let mut info = [0u64; 16];
    info[0] = u64::from(signal.cast_unsigned());
    info[1] = u64::from(libc::SI_TIMER.cast_unsigned());
    info[2] = u64::from(id.cast_unsigned());
    info[3] = value;
    // SAFETY: the facts have the size of `siginfo_t`, and outlive the call.
    unsafe { libc::syscall(libc::SYS_rt_tgsigqueueinfo, process, tid, signal, info.as_ptr()) };
}

/// Sends a signal to one task of a process. A task that is no more is no error.
pub(crate) fn signal(process: i32, tid: i32, signal: i32) {
    // SAFETY: a call with three numbers.
    unsafe { libc::syscall(libc::SYS_tgkill, process, tid, signal) };
}
