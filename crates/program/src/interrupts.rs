//! Signals: their delivery, and the waits that they end.

use crate::cables::Cables;
use crate::error::Error;
use crate::os::proc::{self, mask};
use crate::os::trace::{self, Resume};
use crate::schedule::{Next, Schedule};
use crate::task::{Activity, Interruption, Task};

/// The fate of a call with these values depends on the handler (linux/errno.h): it is restarted, or fails with EINTR.
const RESTART_IF_WANTED: i64 = -512;
const RESTART_WITHOUT_HANDLER: i64 = -514;

impl Schedule {
    /// Waits end of tasks that have a signal to act on.
    pub(crate) fn interrupt_waits(&mut self) -> Result<(), Error> {
        // Calls with a mask of signals of their own find out by themselves.
        self.kernel.act();
        let now_ns = self.kernel.now_ns;
        // A signal to a process goes to one of its tasks, the first that does not block it.
        let mut reached = Vec::new();
        for task in &mut self.kernel.tasks {
            let signals = proc::signals(task.tid);
            let blocked =
                if let Activity::Signal { blocked, .. } = task.activity { blocked } else { signals.blocked };
            let is_ours = signals.is_due(blocked, signals.pending);
            if !is_ours && (reached.contains(&task.process) || !signals.is_due(blocked, signals.shared)) {
                continue;
            }
            match task.activity {
                Activity::Ours { .. } | Activity::Futex { .. } => {
                    task.interrupted = Some(interruption(task, now_ns));
                    task.finish(-i64::from(libc::EINTR))?;
                }
                Activity::Kernels { .. } => {
                    task.interrupted = Some(interruption(task, now_ns));
                    task.activity = Activity::Running;
                }
                // The kernel's own call returns at once, as there is a signal.
                Activity::Signal { .. } => {
                    task.complete();
                    task.activity = Activity::Running;
                }
                Activity::Running | Activity::Paying { .. } => {}
                Activity::Lending { .. } | Activity::Ended => continue,
            }
            reached.push(task.process);
        }
        Ok(())
    }

    /// A signal is about to be delivered to a task.
    pub(crate) fn deliver(
        &mut self,
        place: usize,
        signal: i32,
        cables: &mut dyn Cables,
    ) -> Result<Next, Error> {
        if signal == libc::SIGSEGV && self.answer_counter(place)? {
            self.kernel.report.counter_reads += 1;
            self.kernel.look(place);
            return Ok(self.next_of(place));
        }
        let task = &mut self.kernel.tasks[place];
        if signal == libc::SIGSTOP {
            // The first stop of a task. Programs of ours are not stopped otherwise.
            return Ok(Next::Resume(Resume::Free));
        }
        if signal == libc::SIGSYS {
            return Err(task.refuse("a 32-bit system call", "only 64-bit programs run in simulated time"));
        }
        let signals = proc::signals(task.tid);
        let is_caught = signals.caught & mask(signal) != 0;
        if let Some(interruption) = task.interrupted.take() {
            resolve(task, interruption)?;
        }
        if is_caught {
            task.complete();
        }
        if !is_caught && signals.harmless() & mask(signal) == 0 {
            return self.end_process(place, signal, cables);
        }
        task.signal = signal;
        Ok(Next::Resume(Resume::Free))
    }

    /// Whether a task has read the processor's counter, which is trapped: it gets the nanoseconds of simulated time.
    fn answer_counter(&self, place: usize) -> Result<bool, Error> {
        let task = &self.kernel.tasks[place];
        let failed = |source| task.failure("reading its registers", source);
        let mut registers = trace::registers(task.tid).map_err(failed)?;
        let mut code = [0; 3];
        if task.read(registers.rip, &mut code[..2]).is_err() {
            return Ok(false);
        }
        let _ = task.read(registers.rip + 2, &mut code[2..]);
        let size = match code {
            // rdtsc, and rdtscp, which tells the processor's number, too.
            [0x0f, 0x31, _] => 2,
            [0x0f, 0x01, 0xf9] => 3,
            _ => return Ok(false),
        };
        registers.rax = self.kernel.now_ns & 0xffff_ffff;
        registers.rdx = self.kernel.now_ns >> 32;
        if size == 3 {
            registers.rcx = 0;
        }
        registers.rip += size;
        task.set(&registers)?;
        Ok(true)
    }
}

/// The fate of the call in which a task waits.
fn interruption(task: &Task, now_ns: u64) -> Interruption {
    let number = task.number_of_call();
    let left_at = match number {
        libc::SYS_nanosleep => task.argument(1),
        libc::SYS_clock_nanosleep if task.argument(1) & libc::TIMER_ABSTIME as u64 == 0 => task.argument(3),
        _ => 0,
    };
    if let (1.., Some(Some(until_ns))) = (left_at, task.call.again) {
        let _ = task.write_time(left_at, until_ns.saturating_sub(now_ns), 1);
    }
    match number {
        libc::SYS_write | libc::SYS_writev if task.call.done > 0 => {
            Interruption::Return(task.call.done.cast_signed())
        }
        libc::SYS_read
        | libc::SYS_readv
        | libc::SYS_write
        | libc::SYS_writev
        | libc::SYS_recvfrom
        | libc::SYS_recvmsg
        | libc::SYS_sendto
        | libc::SYS_sendmsg
        | libc::SYS_wait4
        | libc::SYS_waitid
        | libc::SYS_ioctl => Interruption::Restart,
        libc::SYS_futex if task.argument(3) == 0 => Interruption::Restart,
        _ => Interruption::Fail,
    }
}

/// The registers of a task whose call was interrupted, as the kernel would have them when it delivers the signal.
fn resolve(task: &Task, interruption: Interruption) -> Result<(), Error> {
    task.replace(|registers| match interruption {
        Interruption::Restart => registers.rax = RESTART_IF_WANTED.cast_unsigned(),
        Interruption::Fail => registers.rax = RESTART_WITHOUT_HANDLER.cast_unsigned(),
        Interruption::Return(value) => {
            registers.rax = value.cast_unsigned();
            registers.orig_rax = u64::MAX;
        }
    })
}
