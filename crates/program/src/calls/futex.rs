//! Futexes: the waits and wakes of threads. The kernel would wake a task in its own time, so the queues are here.

use super::Outcome;
use crate::cables::Cables;
use crate::fault::Fault;
use crate::kernel::{EPOCH_NS, Kernel, UPTIME_NS};
use crate::os::proc;
use crate::task::{Activity, FutexKey, Task};

/// Any bit.
const ALL: u32 = u32::MAX;

pub(super) fn call(kernel: &mut Kernel, task: usize, _: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let operation = caller.argument(1) as i32;
    let command = operation & !(libc::FUTEX_PRIVATE_FLAG | libc::FUTEX_CLOCK_REALTIME);
    let is_private = operation & libc::FUTEX_PRIVATE_FLAG != 0;
    let first = key(caller, caller.argument(0), is_private);
    let count = caller.argument(2) as u32;
    match command {
        libc::FUTEX_WAIT | libc::FUTEX_WAIT_BITSET => wait(kernel, task, first, command, operation),
        libc::FUTEX_WAKE => Ok(Outcome::Moved(kernel.wake(first, count, ALL))),
        libc::FUTEX_WAKE_BITSET => {
            let bits = caller.argument(5) as u32;
            Ok(Outcome::Moved(kernel.wake(first, count, bits)))
        }
        libc::FUTEX_REQUEUE | libc::FUTEX_CMP_REQUEUE => requeue(kernel, task, first, command),
        libc::FUTEX_WAKE_OP => wake_op(kernel, task, first),
        other => Err(caller
            .refuse(
                format!("futex (operation {other})"),
                "mutexes with priorities are not there; use the default protocol",
            )
            .into()),
    }
}

fn key(task: &Task, address: u64, is_private: bool) -> FutexKey {
    let shared = if is_private { None } else { proc::shared_memory(task.tid, address) };
    shared.map_or(FutexKey::Private(task.process, address), |(file, place)| FutexKey::Shared(file, place))
}

fn wait(
    kernel: &mut Kernel,
    task: usize,
    key: FutexKey,
    command: i32,
    operation: i32,
) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    if caller.read_u32(caller.argument(0))? != caller.argument(2) as u32 {
        return Ok(Outcome::Look(-i64::from(libc::EAGAIN)));
    }
    let until_ns = match caller.argument(3) {
        0 => None,
        place => {
            let time_ns = caller.read_time(place, 1)?;
            let is_wall = operation & libc::FUTEX_CLOCK_REALTIME != 0;
            Some(match command {
                libc::FUTEX_WAIT => kernel.now_ns.saturating_add(time_ns),
                _ => time_ns.saturating_sub(if is_wall { EPOCH_NS } else { UPTIME_NS }),
            })
        }
    };
    if until_ns.is_some_and(|until_ns| until_ns <= kernel.now_ns) {
        return Ok(Outcome::Look(-i64::from(libc::ETIMEDOUT)));
    }
    let bits = if command == libc::FUTEX_WAIT { ALL } else { caller.argument(5) as u32 };
    kernel.order += 1;
    Ok(Outcome::Wait(Activity::Futex { key, bits, order: kernel.order, until_ns }))
}

/// Wakes some, and lets others wait at a second futex.
fn requeue(kernel: &mut Kernel, task: usize, first: FutexKey, command: i32) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    if command == libc::FUTEX_CMP_REQUEUE && caller.read_u32(caller.argument(0))? != caller.argument(5) as u32
    {
        return Ok(Outcome::Look(-i64::from(libc::EAGAIN)));
    }
    let is_private = caller.argument(1) as i32 & libc::FUTEX_PRIVATE_FLAG != 0;
    let second = key(caller, caller.argument(4), is_private);
    let (wakes, most) = (caller.argument(2) as u32, caller.argument(3) as u32);
    let woken = kernel.wake(first, wakes, ALL);
    let mut moved = 0;
    while moved < i64::from(most) {
        let Some(waiter) = kernel.first_at(first, ALL) else { break };
        if let Activity::Futex { key, .. } = &mut kernel.tasks[waiter].activity {
            *key = second;
        }
        moved += 1;
        if first == second {
            break;
        }
    }
    Ok(Outcome::Moved(if command == libc::FUTEX_CMP_REQUEUE { woken + moved } else { woken }))
}

/// Changes a second futex, and wakes tasks at both (futex(2), FUTEX_WAKE_OP).
fn wake_op(kernel: &mut Kernel, task: usize, first: FutexKey) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let (place, code) = (caller.argument(4), caller.argument(5) as u32);
    let is_private = caller.argument(1) as i32 & libc::FUTEX_PRIVATE_FLAG != 0;
    let second = key(caller, place, is_private);
    let sign_extended = |twelve_bits: u32| ((twelve_bits << 20) as i32 >> 20).cast_unsigned();
    let plain = sign_extended(code >> 12 & 0xfff);
    let operand = if code >> 31 != 0 { 1 << (plain & 31) } else { plain };
    let old = caller.read_u32(place)?;
    let new = match code >> 28 & 7 {
        0 => operand,
        1 => old.wrapping_add(operand),
        2 => old | operand,
        3 => old & !operand,
        4 => old ^ operand,
        _ => return Err(Fault::Errno(libc::ENOSYS)),
    };
    caller.write(place, &new.to_ne_bytes())?;
    let (old, other) = (old.cast_signed(), sign_extended(code & 0xfff).cast_signed());
    let is_true = match code >> 24 & 15 {
        0 => old == other,
        1 => old != other,
        2 => old < other,
        3 => old <= other,
        4 => old > other,
        5 => old >= other,
        _ => return Err(Fault::Errno(libc::ENOSYS)),
    };
    let (wakes, more) = (caller.argument(2) as u32, caller.argument(3) as u32);
    let woken = kernel.wake(first, wakes, ALL);
    Ok(Outcome::Moved(woken + if is_true { kernel.wake(second, more, ALL) } else { 0 }))
}

impl Kernel {
    /// The task that has waited longest at a futex.
    fn first_at(&self, wanted: FutexKey, wanted_bits: u32) -> Option<usize> {
        let waiting = self.tasks.iter().enumerate().filter_map(|(place, task)| {
            let Activity::Futex { key, bits, order, .. } = task.activity else { return None };
            (key == wanted && bits & wanted_bits != 0).then_some((order, place))
        });
        waiting.min().map(|(_, place)| place)
    }

    /// Wakes up to so many tasks, the first first.
    fn wake(&mut self, key: FutexKey, most: u32, bits: u32) -> i64 {
        let mut woken = 0;
        while woken < i64::from(most) {
            let Some(waiter) = self.first_at(key, bits) else { break };
            // A task that is killed meanwhile counts, as it would for the kernel.
            let _ = self.tasks[waiter].finish(0);
            woken += 1;
        }
        woken
    }

    /// A thread has ended, and the kernel has changed words of its memory: who waits for that looks again.
    pub(crate) fn recheck_futexes(&mut self) {
        for task in &mut self.tasks {
            if matches!(task.activity, Activity::Futex { .. })
                && task.read_u32(task.argument(0)).is_ok_and(|word| word != task.argument(2) as u32)
            {
                let _ = task.finish(0);
            }
        }
    }
}
