//! The first process of a program: traced, filtered, without a clock of its own.

use std::ffi::CString;
use std::io;
use std::os::fd::{AsRawFd, OwnedFd, RawFd};
use std::ptr::null;

use libc::{c_char, sock_filter, sock_fprog};

use super::trace::{self, Resume, Stop};

/// All that the new process needs. It is complete before the fork, as there may be no allocation after it.
pub(crate) struct Launch {
    /// The file to run.
    pub(crate) file: CString,
    /// Its words, the name first.
    pub(crate) words: Vec<CString>,
    /// Lines `NAME=VALUE`.
    pub(crate) environment: Vec<CString>,
    /// The folder to run in.
    pub(crate) folder: CString,
    /// Standard input, output and errors; none: as ours.
    pub(crate) streams: [Option<OwnedFd>; 3],
    /// See `filter`.
    pub(crate) filter: Vec<sock_filter>,
}

/// Starts it. It stands still just after the exec, with nothing of the program run.
pub(crate) fn spawn(launch: &Launch) -> io::Result<i32> {
    let words = pointers(&launch.words);
    let environment = pointers(&launch.environment);
    let streams = launch.streams.each_ref().map(|stream| stream.as_ref().map_or(-1, AsRawFd::as_raw_fd));
    // SAFETY: the child calls only functions that are safe after a fork, on memory that was there before.
    let pid = unsafe { libc::fork() };
    match pid {
        -1 => Err(io::Error::last_os_error()),
        // SAFETY: as above; the pointers end with a null and outlive the call.
        0 => unsafe { child(launch, &words, &environment, streams) },
        _ => attend(pid).inspect_err(|_| {
            // SAFETY: a call with two numbers, about our own child.
            unsafe { libc::kill(pid, libc::SIGKILL) };
            let _ = trace::wait(pid);
        }),
    }
}

fn pointers(texts: &[CString]) -> Vec<*const c_char> {
    texts.iter().map(|text| text.as_ptr()).chain([null()]).collect()
}

/// Brings the child from its first stop to that behind its exec.
fn attend(pid: i32) -> io::Result<i32> {
    let unexpected = |stop: Stop| {
        let Stop::Exit(code) = stop else {
            return io::Error::other(format!("unexpected before its exec: {stop:?}"));
        };
        io::Error::from_raw_os_error(code)
    };
    let stop = trace::wait(pid)?;
    if stop != Stop::Signal(libc::SIGSTOP) {
        return Err(unexpected(stop));
    }
    trace::set_options(pid)?;
    loop {
        trace::resume(pid, Resume::Free, 0)?;
        let stop = trace::wait(pid)?;
        if stop == Stop::Exec {
            return Ok(pid);
        }
        // The entry of the exec itself, or of the exit after one that has failed.
        if stop != Stop::Entry {
            return Err(unexpected(stop));
        }
    }
}

/// The child between fork and exec. What fails is told as the exit code, which holds any errno.
unsafe fn child(
    launch: &Launch,
    words: &[*const c_char],
    environment: &[*const c_char],
    streams: [RawFd; 3],
) -> ! {
    // SAFETY: system calls with numbers and pointers into memory that is valid since before the fork.
    unsafe {
        let parent_is_gone =
            libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) != 0 || libc::setpgid(0, 0) != 0;
        if parent_is_gone || libc::ptrace(libc::PTRACE_TRACEME, 0, 0, 0) != 0 {
            fail();
        }
        for (number, stream) in streams.into_iter().enumerate() {
            if stream >= 0 && libc::dup2(stream, number as i32) < 0 {
                fail();
            }
        }
        // Descriptors that somebody left open would give the program other numbers from one start to the next.
        libc::syscall(libc::SYS_close_range, 3, u32::MAX, libc::CLOSE_RANGE_CLOEXEC);
        unmask_signals();
        if libc::chdir(launch.folder.as_ptr()) != 0 {
            fail();
        }
        // Containers refuse it, which the report tells.
        libc::personality(libc::ADDR_NO_RANDOMIZE as _);
        libc::raise(libc::SIGSTOP);
        if !is_filtered(&launch.filter) {
            fail();
        }
        libc::execve(launch.file.as_ptr(), words.as_ptr(), environment.as_ptr());
        fail();
    }
}

/// The processor's counter is trapped from here on, and calls are filtered.
unsafe fn is_filtered(filter: &[sock_filter]) -> bool {
    let program = sock_fprog { len: filter.len() as u16, filter: filter.as_ptr().cast_mut() };
    // SAFETY: the filter outlives the call, which only reads it.
    unsafe {
        libc::prctl(libc::PR_SET_TSC, libc::PR_TSC_SIGSEGV) == 0
            && libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0
            && libc::syscall(
                libc::SYS_seccomp,
                libc::SECCOMP_SET_MODE_FILTER,
                libc::SECCOMP_FILTER_FLAG_SPEC_ALLOW,
                &raw const program,
            ) == 0
    }
}

/// Signals as a program expects them: Rust ignores SIGPIPE, and a thread of ours may block others.
unsafe fn unmask_signals() {
    // SAFETY: an empty set, and a call with two numbers.
    unsafe {
        let mut none: libc::sigset_t = std::mem::zeroed();
        libc::sigemptyset(&raw mut none);
        libc::sigprocmask(libc::SIG_SETMASK, &raw const none, std::ptr::null_mut());
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
}

unsafe fn fail() -> ! {
    // SAFETY: errno is this thread's own.
    unsafe { libc::_exit(*libc::__errno_location()) }
}
