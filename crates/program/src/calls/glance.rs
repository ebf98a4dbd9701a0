//! A select or poll of ports only, or of ports and pipes in which nothing happens, is answered without the kernel: that takes one stop
//! in place of four.

use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::task::Task;

/// The requests of a poll, with the bits for ordinary bytes that programs use as well.
const READS: i16 = libc::POLLIN | libc::POLLRDNORM;
const WRITES: i16 = libc::POLLOUT | libc::POLLWRNORM;

/// The answer to a select or poll at this instant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Answer {
    /// The value that it returns: so many descriptors (or sets' bits) are ready.
    pub(super) count: i64,
    /// The bytes that are written, and their addresses.
    pub(super) told: Vec<(u64, Vec<u8>)>,
}

/// A descriptor that is asked for.
struct Question {
    descriptor: i32,
    reads: bool,
    writes: bool,
}

/// The answer, if it needs no kernel.
pub(super) fn answer(kernel: &Kernel, task: usize) -> Result<Option<Answer>, Fault> {
    let caller = &kernel.tasks[task];
    let has_mask = match caller.number_of_call() {
        libc::SYS_poll | libc::SYS_select => false,
        libc::SYS_ppoll => caller.argument(3) != 0,
        libc::SYS_pselect6 => caller.argument(5) != 0 && caller.read_u64(caller.argument(5))? != 0,
        _ => true,
    };
    if has_mask {
        return Ok(None);
    }
    if matches!(caller.number_of_call(), libc::SYS_poll | libc::SYS_ppoll) {
        return poll(kernel, caller);
    }
    select(kernel, caller)
}

/// Whether a descriptor can be read and written; none if only the kernel knows.
fn ready(kernel: &Kernel, task: &Task, question: &Question) -> Option<(bool, bool)> {
    let file = kernel.files.name(task, question.descriptor)?;
    if let Some(port) = kernel.ports.iter().find(|port| *port.flag.name() == *file) {
        return Some((question.reads && port.input.is_ready(&port.termios), question.writes));
    }
    if let Some(rings) = kernel.timers.iter().find_map(|timer| timer.rings(&file)) {
        return Some((question.reads && rings > 0, question.writes));
    }
    let is_pipe = file.as_os_str().as_encoded_bytes().starts_with(b"pipe:");
    (is_pipe && !question.writes && kernel.files.is_quiet(task, question.descriptor))
        .then_some((false, false))
}

/// `struct pollfd`: the descriptor (4 bytes), what is asked (2), and what is answered (2).
fn poll(kernel: &Kernel, task: &Task) -> Result<Option<Answer>, Fault> {
    let mut list = vec![0; 8 * task.argument(1).min(1024) as usize];
    task.read(task.argument(0), &mut list)?;
    let mut count = 0;
    for entry in list.chunks_exact_mut(8) {
        let descriptor = i32::from_ne_bytes([entry[0], entry[1], entry[2], entry[3]]);
        let events = i16::from_ne_bytes([entry[4], entry[5]]);
        let question = Question { descriptor, reads: events & READS != 0, writes: events & WRITES != 0 };
        let Some((reads, writes)) = ready(kernel, task, &question) else { return Ok(None) };
        let told = if reads { events & READS } else { 0 } | if writes { events & WRITES } else { 0 };
        entry[6..].copy_from_slice(&told.to_ne_bytes());
        count += i64::from(told != 0);
    }
    Ok(Some(Answer { count, told: vec![(task.argument(0), list)] }))
}

fn select(kernel: &Kernel, task: &Task) -> Result<Option<Answer>, Fault> {
    let most = task.argument(0).min(1024) as usize;
    let mut sets = [const { Vec::new() }; 3];
    for (place, set) in sets.iter_mut().enumerate() {
        if task.argument(place + 1) != 0 {
            set.resize(most.div_ceil(64) * 8, 0);
            task.read(task.argument(place + 1), set)?;
        }
    }
    let mut count = 0;
    for descriptor in 0..most {
        let (byte, bit) = (descriptor / 8, 1 << (descriptor % 8));
        let is_in = |set: &Vec<u8>| set.get(byte).is_some_and(|byte| byte & bit != 0);
        let question =
            Question { descriptor: descriptor as i32, reads: is_in(&sets[0]), writes: is_in(&sets[1]) };
        if !question.reads && !question.writes && !is_in(&sets[2]) {
            continue;
        }
        let Some((reads, writes)) = ready(kernel, task, &question) else { return Ok(None) };
        for (set, is_ready) in sets.iter_mut().zip([reads, writes, false]) {
            if let Some(byte) = set.get_mut(byte) {
                *byte = if is_ready { *byte } else { *byte & !bit };
            }
        }
        count += i64::from(reads) + i64::from(writes);
    }
    let told =
        (1..4).zip(sets).filter(|(_, set)| !set.is_empty()).map(|(place, set)| (task.argument(place), set));
    Ok(Some(Answer { count, told: told.collect() }))
}
