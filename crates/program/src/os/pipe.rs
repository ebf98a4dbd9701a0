//! Pipes of other processes.

use std::fs::OpenOptions;
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;

/// Whether a task's end of a pipe has nothing to read, and nobody has closed the other one.
pub(crate) fn is_quiet(tid: i32, descriptor: i32) -> bool {
    let path = format!("/proc/{tid}/fd/{descriptor}");
    let Ok(pipe) = OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK).open(path) else {
        return false;
    };
    let mut question = libc::pollfd { fd: pipe.as_raw_fd(), events: libc::POLLIN, revents: 0 };
    // SAFETY: one question, which outlives the call.
    unsafe { libc::poll(&raw mut question, 1, 0) == 0 }
}
