//! Tasks (threads and processes), what they do, and what they wait for.

use crate::error::Error;
use crate::fault::Fault;
use crate::os::trace::{self, Registers};
use crate::os::{memory, proc};

/// A thread of a process of the program.
#[derive(Debug)]
pub(crate) struct Task {
    /// The system's number of it.
    pub(crate) tid: i32,
    /// The number of its process, which is that of its first thread.
    pub(crate) process: i32,
    /// Its number in the order of creation.
    pub(crate) number: u32,
    /// A place in its memory that is ours: `SCRATCH` bytes.
    pub(crate) scratch: u64,
    /// The page of its clocks, in that place, if its vDSO is ours.
    pub(crate) page: Option<u64>,
    /// The thing that it does.
    pub(crate) activity: Activity,
    /// The call that it is in, or was in last.
    pub(crate) call: Call,
    /// The thing to do at the return of the call, if it is natively done and that matters.
    pub(crate) after: Option<After>,
    /// A signal has interrupted the call: what the kernel is to make of it.
    pub(crate) interrupted: Option<Interruption>,
    /// The signal to deliver when it goes on.
    pub(crate) signal: i32,
    /// It has waited since this instant, unless it runs.
    pub(crate) waits_since_ns: Option<u64>,
    /// Looks since it has last waited or moved a byte.
    pub(crate) looks: u64,
    /// Calls since it has last waited.
    pub(crate) calls: u64,
    /// The cost of its looks, in nanoseconds: its processor time.
    pub(crate) charged_ns: u64,
}

/// Bytes of a task's scratch memory. The last of them are the page of its clocks.
pub(crate) const SCRATCH: u64 = 8192;

/// The doings of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Activity {
    /// It can run.
    Running,
    /// It pays for a look, and then goes on.
    Paying { until_ns: u64 },
    /// Its call is ours, and is looked at again when something has happened or it is due.
    Ours { until_ns: Option<u64>, seen: u64 },
    /// Its call is the kernel's, and is made again when something has happened or it is due; if it is not about ports, only something
    /// that the kernel has done since can change it.
    Kernels { until_ns: Option<u64>, seen: u64, done: Option<u64> },
    /// It waits at a futex.
    Futex { key: FutexKey, bits: u32, order: u64, until_ns: Option<u64> },
    /// It waits for a signal that this mask does not block.
    Signal { blocked: u64, until_ns: Option<u64> },
    /// It waits until the child that borrows its memory gives it back.
    Lending { child: i32 },
    /// The first thread of a process has ended before the others.
    Ended,
}

impl Activity {
    /// The instant at which it goes on at the latest.
    pub(crate) fn until_ns(&self) -> Option<u64> {
        match self {
            Self::Paying { until_ns } => Some(*until_ns),
            Self::Ours { until_ns, .. }
            | Self::Kernels { until_ns, .. }
            | Self::Futex { until_ns, .. }
            | Self::Signal { until_ns, .. } => *until_ns,
            Self::Running | Self::Lending { .. } | Self::Ended => None,
        }
    }
}

/// A futex: where waiting and waking tasks meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FutexKey {
    /// A process and an address in it.
    Private(i32, u64),
    /// A file that processes share, and a place in it.
    Shared(u64, u64),
}

/// A system call of a task.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Call {
    /// The registers at its entry.
    pub(crate) entry: Registers,
    /// The instant of its entry.
    pub(crate) began_ns: u64,
    /// It is the same call again, with this deadline.
    pub(crate) again: Option<Option<u64>>,
    /// The kernel has said that it will not wait.
    pub(crate) is_cleared: bool,
    /// The progress of a call of ours: bytes written, or steps done.
    pub(crate) done: u64,
}

/// The thing to do at the return of a call that the kernel does.
#[derive(Debug)]
pub(crate) enum After {
    /// A select, poll or epoll without time-out: if nothing is ready, it is made again. The sets of a select are given back.
    Multiplex { deadline: Option<u64>, sets: Vec<(u64, Vec<u8>)> },
    /// A wait for children without waiting.
    Child { is_patient: bool },
    /// A poll in place of a read or write of another descriptor, to see whether it would wait.
    Probe { descriptor: i32 },
    /// A piece of a write to a pipe.
    Piece,
    /// A port is opened, or another file of ours.
    Opening { port: Option<usize> },
    /// The folder /dev is listed.
    Listing,
    /// Descriptors of ports are closed.
    Closing,
    /// Signals are sent; the signal is SIGKILL for these processes.
    Signals { killed: Vec<i32> },
}

/// The fate of a call that a signal has interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Interruption {
    /// It is made again after a handler with SA_RESTART, else it fails with EINTR.
    Restart,
    /// It fails with EINTR.
    Fail,
    /// It has done something, and returns that.
    Return(i64),
}

impl Task {
    /// A task that stands at its beginning.
    pub(crate) fn new(tid: i32, process: i32, number: u32, scratch: u64, entry: Registers) -> Self {
        let call = Call { entry, began_ns: 0, again: None, is_cleared: false, done: 0 };
        Self {
            tid,
            process,
            number,
            scratch,
            page: None,
            activity: Activity::Running,
            call,
            after: None,
            interrupted: None,
            signal: 0,
            waits_since_ns: None,
            looks: 0,
            calls: 0,
            charged_ns: 0,
        }
    }

    /// Whether time has passed while it waited, and it has made no call since.
    pub(crate) fn has_waited(&self, now_ns: u64) -> bool {
        self.waits_since_ns.is_some_and(|since_ns| since_ns < now_ns)
    }

    /// A call begins: what came before has its consequences.
    pub(crate) fn begin_call(&mut self, now_ns: u64) {
        self.interrupted = None;
        if self.has_waited(now_ns) {
            (self.looks, self.calls) = (0, 0);
        }
        self.waits_since_ns = None;
    }

    /// The number of the call that it is in.
    pub(crate) fn number_of_call(&self) -> i64 {
        self.call.entry.orig_rax.cast_signed()
    }

    /// An argument of the call, from 0.
    pub(crate) fn argument(&self, place: usize) -> u64 {
        let entry = &self.call.entry;
        [entry.rdi, entry.rsi, entry.rdx, entry.r10, entry.r8, entry.r9][place]
    }

    /// A descriptor among the arguments.
    pub(crate) fn descriptor(&self, place: usize) -> i32 {
        self.argument(place) as i32
    }

    /// Reads the task's memory.
    pub(crate) fn read(&self, address: u64, into: &mut [u8]) -> Result<(), Fault> {
        memory::read(self.tid, address, into).map_err(|_| Fault::Errno(libc::EFAULT))
    }

    /// Writes the task's memory.
    pub(crate) fn write(&self, address: u64, from: &[u8]) -> Result<(), Fault> {
        memory::write(self.tid, address, from).map_err(|_| Fault::Errno(libc::EFAULT))
    }

    /// Eight bytes of the task's memory.
    pub(crate) fn read_u64(&self, address: u64) -> Result<u64, Fault> {
        let mut bytes = [0; 8];
        self.read(address, &mut bytes)?;
        Ok(u64::from_ne_bytes(bytes))
    }

    /// Four bytes of the task's memory.
    pub(crate) fn read_u32(&self, address: u64) -> Result<u32, Fault> {
        let mut bytes = [0; 4];
        self.read(address, &mut bytes)?;
        Ok(u32::from_ne_bytes(bytes))
    }

    /// A path in the task's memory.
    pub(crate) fn text(&self, address: u64) -> Result<Vec<u8>, Fault> {
        memory::text(self.tid, address).map_err(|_| Fault::Errno(libc::EFAULT))
    }

    /// A `struct timespec` or `struct timeval`, in nanoseconds; `unit_ns` is what its second field counts.
    pub(crate) fn read_time(&self, address: u64, unit_ns: u64) -> Result<u64, Fault> {
        let mut bytes = [0; 16];
        self.read(address, &mut bytes)?;
        let [seconds, part] = [0, 8]
            .map(|place| bytes[place..].iter().take(8).rev().fold(0, |n, byte| n << 8 | u64::from(*byte)));
        let seconds = seconds.cast_signed();
        if seconds < 0 || part >= 1_000_000_000 / unit_ns {
            return Err(Fault::Errno(libc::EINVAL));
        }
        Ok(seconds.unsigned_abs().saturating_mul(1_000_000_000).saturating_add(part * unit_ns))
    }

    /// Writes a time as `read_time` reads it.
    pub(crate) fn write_time(&self, address: u64, time_ns: u64, unit_ns: u64) -> Result<(), Fault> {
        self.write(address, &time_bytes(time_ns, unit_ns))
    }

    /// Sets its registers.
    pub(crate) fn set(&self, registers: &Registers) -> Result<(), Error> {
        trace::set_registers(self.tid, registers)
            .map_err(|source| self.failure("setting its registers", source))
    }

    /// The call is not done; it returns this.
    pub(crate) fn answer(&mut self, value: i64) -> Result<(), Error> {
        let mut registers = self.call.entry;
        registers.orig_rax = u64::MAX;
        registers.rax = value.cast_unsigned();
        self.activity = Activity::Running;
        self.set(&registers)
    }

    /// A wait of ours ends with this.
    pub(crate) fn finish(&mut self, value: i64) -> Result<(), Error> {
        self.complete();
        self.answer(value)
    }

    /// A reader of files does more than look; imports of Python look at the clock in between.
    pub(crate) fn forget_looks_of_readers(&mut self) {
        if matches!(self.number_of_call(), libc::SYS_read | libc::SYS_open | libc::SYS_openat) {
            self.looks = 0;
        }
    }

    /// The call is over: the next one is another.
    pub(crate) fn complete(&mut self) {
        self.call.again = None;
        self.call.is_cleared = false;
    }

    /// The value that the kernel returns, at the return of a call.
    pub(crate) fn value(&self) -> Result<i64, Error> {
        let registers = trace::registers(self.tid);
        Ok(registers.map_err(|source| self.failure("reading its registers", source))?.rax.cast_signed())
    }

    /// The kernel does another call in its place, or the same one with other arguments.
    pub(crate) fn replace(&self, change: impl FnOnce(&mut Registers)) -> Result<(), Error> {
        let mut registers = self.call.entry;
        change(&mut registers);
        self.set(&registers)
    }

    /// The call opens a file of ours in its place.
    pub(crate) fn open_instead(&self, path: &str, flags: u64) -> Result<(), Fault> {
        self.write(self.scratch, &[path.as_bytes(), &[0]].concat())?;
        Ok(self.replace(|registers| {
            registers.orig_rax = libc::SYS_openat.cast_unsigned();
            registers.rdi = i64::from(libc::AT_FDCWD).cast_unsigned();
            (registers.rsi, registers.rdx, registers.r10) = (self.scratch, flags, 0);
        })?)
    }

    /// At the return of a replaced call: the program sees its own arguments, and this value.
    pub(crate) fn returns(&self, value: i64) -> Result<(), Error> {
        self.replace(|registers| registers.rax = value.cast_unsigned())
    }

    /// At the return of a replaced call: the program makes its own call again.
    pub(crate) fn rewind(&mut self, deadline: Option<u64>) -> Result<(), Error> {
        self.call.again = Some(deadline);
        self.replace(|registers| {
            // The instruction `syscall` has two bytes.
            registers.rip -= 2;
            registers.rax = registers.orig_rax;
        })
    }

    /// The name of its program.
    pub(crate) fn program(&self) -> String {
        proc::name(self.tid).unwrap_or_else(|| format!("process {}", self.process))
    }

    /// The tracer fails at this task.
    pub(crate) fn failure(&self, step: &'static str, source: std::io::Error) -> Error {
        Error::Tracer { program: self.program(), step, source }
    }

    /// A call that is refused.
    pub(crate) fn refuse(&self, call: impl Into<String>, remedy: &'static str) -> Error {
        Error::Unsupported { program: self.program(), call: call.into(), remedy }
    }
}

/// A `struct timespec` (unit 1) or `struct timeval` (unit 1,000).
pub(crate) fn time_bytes(time_ns: u64, unit_ns: u64) -> [u8; 16] {
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&(time_ns / 1_000_000_000).to_ne_bytes());
    bytes[8..].copy_from_slice(&(time_ns % 1_000_000_000 / unit_ns).to_ne_bytes());
    bytes
}
