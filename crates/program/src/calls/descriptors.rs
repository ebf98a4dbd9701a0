//! Reads and writes. Those of ports are ours; others are the kernel's, which must not wait in them: before a read or write of a pipe
//! or socket, the task polls in its place.

use std::path::Path;

use super::{Outcome, port, timers};
use crate::cables::Cables;
use crate::error::Error;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::os::proc;
use crate::task::{After, Task};

/// Writes to a pipe of up to so many bytes are done as one (PIPE_BUF), and go through at once if it has room at all.
const PIECE: u64 = 4096;

/// A file that may let its readers and writers wait.
fn may_wait(file: &Path) -> bool {
    let name = file.as_os_str().as_encoded_bytes();
    [&b"pipe:"[..], b"socket:", b"anon_inode:[eventfd", b"anon_inode:[pidfd"]
        .iter()
        .any(|start| name.starts_with(start))
        || (name.starts_with(b"/") && is_fifo(file))
}

/// Only names in folders where programs put FIFOs are worth a look.
fn is_fifo(file: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    ["/tmp", "/run", "/var", "/dev/shm"].iter().any(|folder| file.starts_with(folder))
        && file.metadata().is_ok_and(|facts| facts.file_type().is_fifo())
}

pub(super) fn read(kernel: &mut Kernel, task: usize, cables: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let number = caller.number_of_call();
    let Some(file) = kernel.files.name(caller, caller.descriptor(0)) else { return Ok(Outcome::Native) };
    if let Some(port) = kernel.ports.iter().position(|port| *port.flag.name() == *file) {
        return port::read(kernel, task, port, cables);
    }
    if number == libc::SYS_read && (*file == *Path::new("/dev/urandom") || *file == *Path::new("/dev/random"))
    {
        let count = caller.argument(2).min(65_536) as usize;
        let bytes = kernel.random.bytes(count);
        kernel.tasks[task].write(kernel.tasks[task].argument(1), &bytes)?;
        return Ok(Outcome::Moved(count as i64));
    }
    if let Some(outcome) = timers::read(kernel, task, &file)? {
        return Ok(outcome);
    }
    let flags = match number {
        libc::SYS_recvfrom => 3,
        libc::SYS_recvmsg => 2,
        _ => return probe(kernel, task, &file, libc::POLLIN),
    };
    if kernel.tasks[task].argument(flags) & libc::MSG_DONTWAIT as u64 != 0 {
        return Ok(Outcome::Native);
    }
    probe(kernel, task, &file, libc::POLLIN)
}

pub(super) fn write(kernel: &mut Kernel, task: usize, cables: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let number = caller.number_of_call();
    let Some(file) = kernel.files.name(caller, caller.descriptor(0)) else { return Ok(Outcome::Native) };
    if let Some(port) = kernel.ports.iter().position(|port| *port.flag.name() == *file) {
        return port::write(kernel, task, port, cables);
    }
    kernel.files.stir();
    // The reader of the program's own output is outside of simulated time.
    if kernel.outputs.iter().any(|output| **output == *file) {
        return Ok(Outcome::Native);
    }
    let flags = match number {
        libc::SYS_sendto => 3,
        libc::SYS_sendmsg => 2,
        _ => return probe(kernel, task, &file, libc::POLLOUT),
    };
    if caller.argument(flags) & libc::MSG_DONTWAIT as u64 != 0 {
        return Ok(Outcome::Native);
    }
    probe(kernel, task, &file, libc::POLLOUT)
}

/// A poll without time-out in place of the call, or the call itself, once it will not wait.
fn probe(kernel: &mut Kernel, task: usize, file: &Path, events: i16) -> Result<Outcome, Fault> {
    let caller = &mut kernel.tasks[task];
    if !may_wait(file) {
        return Ok(Outcome::Native);
    }
    if caller.call.is_cleared {
        caller.looks = 0;
        let is_socket = file.as_os_str().as_encoded_bytes().starts_with(b"socket:");
        return cleared(caller, is_socket);
    }
    let descriptor = caller.descriptor(0);
    let mut question = [0; 8];
    question[..4].copy_from_slice(&descriptor.to_ne_bytes());
    question[4..6].copy_from_slice(&events.to_ne_bytes());
    caller.write(caller.scratch, &question)?;
    caller.replace(|registers| {
        registers.orig_rax = libc::SYS_poll.cast_unsigned();
        (registers.rdi, registers.rsi, registers.rdx) = (caller.scratch, 1, 0);
    })?;
    Ok(Outcome::Observed(After::Probe { descriptor }))
}

/// The call itself. A large write is done in pieces, as it would wait for its readers in the kernel.
fn cleared(caller: &Task, is_socket: bool) -> Result<Outcome, Fault> {
    let number = caller.number_of_call();
    let rest = caller.argument(2).saturating_sub(caller.call.done);
    let is_large = rest > PIECE || caller.call.done > 0;
    let is_written = matches!(number, libc::SYS_write | libc::SYS_sendto);
    if !is_written || !is_large || proc::is_nonblocking(caller.tid, caller.descriptor(0)) {
        return Ok(Outcome::Native);
    }
    caller.replace(|registers| {
        registers.rsi += caller.call.done;
        registers.rdx = if is_socket { rest } else { rest.min(PIECE) };
        if is_socket {
            // It takes what it has room for; messages stay whole.
            if number == libc::SYS_write {
                (registers.r10, registers.r8, registers.r9) = (0, 0, 0);
            }
            registers.orig_rax = libc::SYS_sendto.cast_unsigned();
            registers.r10 |= libc::MSG_DONTWAIT as u64;
        }
    })?;
    Ok(Outcome::Observed(After::Piece))
}

pub(super) fn leave_probe(kernel: &mut Kernel, task: usize, descriptor: i32) -> Result<(), Error> {
    let waiting = kernel.waiting();
    let caller = &mut kernel.tasks[task];
    if caller.value()? > 0 {
        caller.call.is_cleared = true;
        return caller.rewind(None);
    }
    if proc::is_nonblocking(caller.tid, descriptor) {
        caller.complete();
        caller.returns(-i64::from(libc::EAGAIN))?;
        kernel.charge(task);
        return Ok(());
    }
    caller.rewind(None)?;
    caller.activity = waiting;
    Ok(())
}

pub(super) fn leave_piece(kernel: &mut Kernel, task: usize) -> Result<(), Error> {
    let waiting = kernel.waiting();
    let caller = &mut kernel.tasks[task];
    let written = caller.value()?;
    let done = caller.call.done + written.max(0).unsigned_abs();
    let is_full = written == -i64::from(libc::EAGAIN);
    if is_full || (written > 0 && done < caller.argument(2)) {
        caller.call.done = done;
        caller.call.is_cleared = false;
        caller.rewind(None)?;
        if is_full {
            caller.activity = waiting;
        }
        return Ok(());
    }
    caller.complete();
    caller.returns(if done > 0 { done.cast_signed() } else { written })
}

/// Bytes go from one descriptor to another. Programs read and write them themselves if that is not possible.
pub(super) fn transfer(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let second = match caller.number_of_call() {
        libc::SYS_splice | libc::SYS_copy_file_range => 2,
        libc::SYS_vmsplice => 0,
        _ => 1,
    };
    kernel.files.stir();
    let is_port = |place| kernel.port(task, caller.descriptor(place)).is_some();
    if is_port(0) || is_port(second) { Err(Fault::Errno(libc::EINVAL)) } else { Ok(Outcome::Native) }
}

/// Whether the last descriptor of a port goes is seen once the call is done. A pipe's end that closes may wake others.
pub(super) fn close(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let closed = match caller.number_of_call() {
        libc::SYS_close => 0,
        libc::SYS_dup2 | libc::SYS_dup3 => 1,
        _ => {
            kernel.files.forget_all();
            return Ok(Outcome::Observed(After::Closing));
        }
    };
    let matters = |file: &Path| may_wait(file) || kernel.ports.iter().any(|port| *port.flag.name() == *file);
    let file = kernel.files.name(caller, caller.descriptor(closed));
    kernel.files.forget(caller.descriptor(closed));
    match file {
        Some(file) if matters(&file) => Ok(Outcome::Observed(After::Closing)),
        _ => Ok(Outcome::Native),
    }
}

/// The pieces of memory of a `readv` or `writev`, or the one of a `read` or `write`: addresses and lengths.
pub(super) fn pieces(task: &Task) -> Result<Vec<(u64, u64)>, Fault> {
    match task.number_of_call() {
        libc::SYS_read | libc::SYS_write => Ok(vec![(task.argument(1), task.argument(2))]),
        libc::SYS_readv | libc::SYS_writev => (0..task.argument(2).min(1024))
            .map(|place| {
                let at = task.argument(1) + 16 * place;
                Ok((task.read_u64(at)?, task.read_u64(at + 8)?))
            })
            .collect(),
        _ => Err(Fault::Errno(libc::ENOTSOCK)),
    }
}
