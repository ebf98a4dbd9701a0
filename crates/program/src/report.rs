//! Reports of a session about its program.

use std::fmt;

/// The deeds of a program up to now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Report {
    /// Stops of its tasks: each takes some microseconds of wall time.
    pub stops: u64,
    /// Looks that were charged, see [`Price`](crate::Price).
    pub charged: u64,
    /// The sum that they were charged, in nanoseconds, over all tasks.
    pub charged_ns: u64,
    /// Tasks (threads and processes) at most at a time.
    pub tasks_at_most: usize,
    /// Tasks in all.
    pub tasks: u32,
    /// Reads of the processor's counter (`rdtsc`), which were answered from simulated time.
    pub counter_reads: u64,
    /// Programs that were started with a vDSO that could not be changed: they are slower, with the same results.
    pub trapped: u32,
    /// Whether its memory is at other addresses in each run, as the system does not allow fixed ones, in a container for instance. What
    /// follows from addresses, such as the order of a set of objects in Python, may then differ.
    pub has_random_addresses: bool,
}

/// A task that waits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wait {
    /// The name of its program.
    pub program: String,
    /// Its number in the order of creation; the first is 0.
    pub task: u32,
    /// The call it waits in.
    pub call: &'static str,
    /// The instant at which it goes on at the latest, in nanoseconds; none: only bytes or another task can wake it.
    pub until_ns: Option<u64>,
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "task {} of {} waits in {}", self.task, self.program, self.call)?;
        match self.until_ns {
            Some(until_ns) => write!(f, " until {} s", until_ns as f64 / 1e9),
            None => f.write_str(" for what another task or a port does"),
        }
    }
}

/// The end of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum End {
    /// It has exited with this code.
    Exit(i32),
    /// This signal has killed it.
    Signal(i32),
}
