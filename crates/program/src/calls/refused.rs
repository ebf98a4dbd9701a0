//! Calls that have no simulated time. Those that programs do without, if they have to, are absent; the others end the session with
//! their name, so that none waits in real time unseen.

use super::Outcome;
use crate::cables::Cables;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::names;

/// glibc, Go and Python take another call if these are absent: clone, open, futex.
pub(super) const ABSENT: &[i64] = &[
    libc::SYS_clone3,
    libc::SYS_openat2,
    libc::SYS_futex_waitv,
    // futex_wake, futex_wait and futex_requeue, for which the C library has no names yet.
    454,
    455,
    456,
];

pub(super) const REFUSED: &[i64] = &[
    libc::SYS_bind,
    libc::SYS_listen,
    libc::SYS_accept,
    libc::SYS_accept4,
    libc::SYS_io_uring_setup,
    libc::SYS_io_uring_enter,
    libc::SYS_io_uring_register,
    libc::SYS_io_setup,
    libc::SYS_signalfd,
    libc::SYS_signalfd4,
    libc::SYS_inotify_init,
    libc::SYS_inotify_init1,
    libc::SYS_fanotify_init,
    libc::SYS_unshare,
    libc::SYS_setns,
    libc::SYS_ptrace,
    libc::SYS_perf_event_open,
    libc::SYS_userfaultfd,
    libc::SYS_msgrcv,
    libc::SYS_msgsnd,
    libc::SYS_semop,
    libc::SYS_semtimedop,
    libc::SYS_mq_open,
];

/// The system's cache of names asks here; if it is absent, the C library reads the files itself.
const NAME_CACHE: &[u8] = b"/var/run/nscd/socket";

const REMEDY: &str = "run the program in real time, at a port of `baudbot port`";
const NETWORK_REMEDY: &str =
    "the network is in real time; run the program in real time, at a port of `baudbot port`";

pub(super) fn absent(_: &mut Kernel, _: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    Err(Fault::Errno(libc::ENOSYS))
}

pub(super) fn refuse(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    Err(caller.refuse(names::call(caller.number_of_call()), REMEDY).into())
}

/// Sockets of the machine itself come into being, as some libraries make one to ask for names; but they lead nowhere.
pub(super) fn socket(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    if caller.number_of_call() == libc::SYS_socket {
        let family = match caller.argument(0) as i32 {
            libc::AF_UNIX => return Ok(Outcome::Native),
            libc::AF_INET => "AF_INET".to_owned(),
            libc::AF_INET6 => "AF_INET6".to_owned(),
            libc::AF_NETLINK => "AF_NETLINK".to_owned(),
            libc::AF_CAN => "AF_CAN".to_owned(),
            other => format!("family {other}"),
        };
        return Err(caller.refuse(format!("socket({family})"), NETWORK_REMEDY).into());
    }
    let mut address = vec![0; caller.argument(2).min(110) as usize];
    caller.read(caller.argument(1), &mut address)?;
    let path = address.get(2..).unwrap_or_default().split(|byte| *byte == 0).next().unwrap_or_default();
    if path == NAME_CACHE {
        return Err(Fault::Errno(libc::ENOENT));
    }
    Err(caller.refuse(format!("connect({})", String::from_utf8_lossy(path)), NETWORK_REMEDY).into())
}
