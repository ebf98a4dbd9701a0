//! Timers of programs.

use std::path::Path;

use crate::tty::flag::Flag;

/// A timer.
#[derive(Debug)]
pub(crate) struct Timer {
    pub(crate) owner: Owner,
    /// The value of its clock at the beginning of simulated time.
    pub(crate) start_ns: u64,
    /// The next instant; `u64::MAX`: it does not run.
    pub(crate) due_ns: u64,
    /// The period; 0: it rings once.
    pub(crate) every_ns: u64,
}

/// The thing that a timer belongs to.
#[derive(Debug)]
pub(crate) enum Owner {
    /// ITIMER_REAL of a process.
    Process(i32),
    /// A timer that a process has created, with its number, and its signal, if it has one.
    Created { process: i32, id: i32, notice: Option<Notice> },
    /// A file, which can be read when it has rung.
    File { flag: Flag, rings: u64 },
}

/// The signal of a timer that a process has created.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Notice {
    pub(crate) signal: i32,
    /// A number of the program's.
    pub(crate) value: u64,
    /// The thread that it is for.
    pub(crate) tid: Option<i32>,
}

impl Timer {
    /// The time to the next ring, and the period.
    pub(crate) fn left(&self, now_ns: u64) -> (u64, u64) {
        let left_ns = if self.due_ns == u64::MAX { 0 } else { self.due_ns.saturating_sub(now_ns) };
        (left_ns, self.every_ns)
    }

    /// The number of its rings, if it is this file.
    pub(crate) fn rings(&self, file: &Path) -> Option<u64> {
        match &self.owner {
            Owner::File { flag, rings } if flag.name() == file => Some(*rings),
            Owner::File { .. } | Owner::Process(_) | Owner::Created { .. } => None,
        }
    }

    /// Whether it is one of a process. Files may belong to several.
    pub(crate) fn is_of(&self, wanted: i32) -> bool {
        match self.owner {
            Owner::Process(process) | Owner::Created { process, .. } => process == wanted,
            Owner::File { .. } => false,
        }
    }
}
