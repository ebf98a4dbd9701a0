//! A program and its surroundings.

use std::ffi::OsString;
use std::fs::File;
use std::path::PathBuf;
use std::time::Duration;

/// A program and its surroundings.
#[derive(Debug, Default)]
pub struct Program {
    /// Its words, the program's name first. A name without a slash is looked up in `PATH`.
    pub words: Vec<OsString>,
    /// The folder it runs in; none: the caller's.
    pub folder: Option<PathBuf>,
    /// Additions to the caller's environment.
    pub environment: Vec<(OsString, OsString)>,
    /// The serial ports that it sees. It sees no others.
    pub ports: Vec<Port>,
    /// All random numbers that it asks the system for follow from this.
    pub seed: u64,
    /// The price of computing.
    pub price: Price,
    /// The wall time that the session gives to a program which does nothing that it can see.
    pub patience: Patience,
    /// Its standard output.
    pub output: Output,
    /// Its standard errors.
    pub errors: Output,
    /// Whether the thread that runs the session may move between processors. It is then several times slower, with the same results.
    /// Else it stays on one while it has a session, and so do threads that it starts meanwhile.
    pub is_unpinned: bool,
    /// Whether each look at a clock stops the program, as it does where the system does not let us change its vDSO. It is then several
    /// times slower, with the same results.
    pub traps_clocks: bool,
}

/// A serial port that the program sees.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Port {
    /// Its absolute path, such as `/dev/ttyUSB0`. Nothing needs to be there.
    pub path: String,
}

/// The price of computing in simulated time. A call that waits costs nothing; one that only looks (a clock, a poll that finds nothing,
/// a read without waiting) may, so that time goes on for a program that looks over and over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Price {
    /// So many looks one after the other, with no wait between them, are free.
    pub free_looks: u64,
    /// The price of each further look, in nanoseconds; at least 1.
    pub look_ns: u64,
}

impl Default for Price {
    fn default() -> Self {
        Self { free_looks: 100, look_ns: 100_000 }
    }
}

impl Price {
    /// Each look costs, from the first on.
    pub fn each(look_ns: u64) -> Self {
        Self { free_looks: 0, look_ns }
    }
}

/// The patience of a session, in wall time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Patience {
    /// For a call that does not return.
    pub call: Duration,
    /// For a task that computes and makes no call: its processor time.
    pub computing: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self { call: Duration::from_secs(5), computing: Duration::from_secs(2) }
    }
}

/// The place where a program's output goes.
#[derive(Debug, Default)]
pub enum Output {
    /// The same place as the caller's.
    #[default]
    Inherited,
    /// Nowhere.
    Discarded,
    /// A file, or the writing end of a pipe. The caller reads a pipe while the session runs, or it fills.
    Given(File),
}
