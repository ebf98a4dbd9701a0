//! Reads and writes of a port.

use super::{Outcome, descriptors};
use crate::cables::Cables;
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::os::proc;
use crate::task::{Activity, Task};
use crate::tty::Tty;
use crate::tty::discipline::{Reading, Request, process};

/// Bytes that the system holds for the UART.
const ROOM: usize = 4096;
/// The most that a single call moves.
const MOST: u64 = 1 << 20;

pub(super) fn read(
    kernel: &mut Kernel,
    task: usize,
    port: usize,
    _: &mut dyn Cables,
) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let pieces = descriptors::pieces(caller)?;
    let room = pieces.iter().fold(0, |sum: u64, (_, length)| sum.saturating_add(*length)).min(MOST) as usize;
    let mut request =
        Request { room, began_ns: caller.call.began_ns, now_ns: kernel.now_ns, is_nonblocking: false };
    let tty = &mut kernel.ports[port];
    let mut reading = tty.input.read(&tty.termios, &request);
    // Whether it may wait matters only if it would.
    if matches!(reading, Reading::Waiting(_)) && proc::is_nonblocking(caller.tid, caller.descriptor(0)) {
        request.is_nonblocking = true;
        reading = tty.input.read(&tty.termios, &request);
    }
    let bytes = match reading {
        Reading::Bytes(bytes) => bytes,
        Reading::Waiting(until_ns) => {
            return Ok(Outcome::Wait(Activity::Ours { until_ns, seen: kernel.progress }));
        }
        Reading::Nothing => return Ok(Outcome::Look(-i64::from(libc::EAGAIN))),
    };
    tty.show();
    scatter(caller, &pieces, &bytes)?;
    Ok(if bytes.is_empty() { Outcome::Look(0) } else { Outcome::Moved(bytes.len() as i64) })
}

fn scatter(task: &Task, pieces: &[(u64, u64)], bytes: &[u8]) -> Result<(), Fault> {
    let mut rest = bytes;
    for (address, length) in pieces {
        let (piece, behind) = rest.split_at(rest.len().min(*length as usize));
        task.write(*address, piece)?;
        rest = behind;
    }
    Ok(())
}

pub(super) fn write(
    kernel: &mut Kernel,
    task: usize,
    port: usize,
    cables: &mut dyn Cables,
) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let bytes = gather(caller)?;
    let (tid, descriptor) = (caller.tid, caller.descriptor(0));
    let tty = &kernel.ports[port];
    let done = caller.call.done as usize;
    let (taken, sent) =
        fitting(tty, &bytes[done.min(bytes.len())..], ROOM.saturating_sub(cables.unsent(port)));
    if !sent.is_empty() {
        cables.write(port, &sent);
    }
    let done = done + taken;
    let rest = bytes.len().saturating_sub(done);
    if rest == 0 {
        return Ok(Outcome::Moved(done as i64));
    }
    if proc::is_nonblocking(tid, descriptor) {
        return Ok(if done > 0 {
            Outcome::Moved(done as i64)
        } else {
            Outcome::Look(-i64::from(libc::EAGAIN))
        });
    }
    // The instant at which there is room for the rest: bytes leave one after the other until all are sent.
    let until_ns = tty.termios.line_settings().map(|settings| {
        let still_there = (ROOM - rest.min(ROOM)) as u64;
        let until_ns = cables.sent_at_ns(port).saturating_sub(settings.bytes_ns(still_there));
        until_ns.max(kernel.now_ns + 1)
    });
    kernel.tasks[task].call.done = done as u64;
    Ok(Outcome::Wait(Activity::Ours { until_ns, seen: kernel.progress }))
}

/// The bytes that a task writes.
fn gather(task: &Task) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    for (address, length) in descriptors::pieces(task)? {
        let start = bytes.len();
        bytes.resize(start + length.min(MOST.saturating_sub(start as u64)) as usize, 0);
        task.read(address, &mut bytes[start..])?;
    }
    Ok(bytes)
}

/// The bytes of the program for which there is room, and as they enter the UART.
fn fitting(tty: &Tty, bytes: &[u8], room: usize) -> (usize, Vec<u8>) {
    let all = process(&tty.termios, &bytes[..bytes.len().min(room)]);
    if all.len() <= room {
        return (bytes.len().min(room), all);
    }
    let (mut taken, mut sent) = (0, Vec::new());
    for byte in bytes {
        let next = process(&tty.termios, &[*byte]);
        if sent.len() + next.len() > room {
            break;
        }
        sent.extend(next);
        taken += 1;
    }
    (taken, sent)
}
